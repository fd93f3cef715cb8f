"""From the case to plans: what each solver needs, in plain records and world axes.

Materials are numbered by ``material_numbers`` wherever a plan or a surface has an index.
"""

from __future__ import annotations

from orchestrator.case.planning.frames import bushings, frames_plan
from orchestrator.case.planning.materials import hyperelastic, material_numbers, touching_materials
from orchestrator.case.planning.panels import panel_plans
from orchestrator.case.planning.particles import exits, particles_plan

__all__ = [
    "bushings",
    "exits",
    "frames_plan",
    "hyperelastic",
    "material_numbers",
    "panel_plans",
    "particles_plan",
    "touching_materials",
]
