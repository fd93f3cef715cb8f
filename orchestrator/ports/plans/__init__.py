"""Plans: all that a solver needs to know to be built, checked and in plain records.

``build.py`` makes them from the case; tests make them by hand.  Every adapter is a module
``adapters.<port>.<solver>`` with one function ``build(plan)`` that returns the open solver.
Here they are by port, each field with its unit and meaning: ``frames``, ``panel``, ``particles``.
"""

from __future__ import annotations

from orchestrator.ports.failures import SolverFailed, SolverMissing
from orchestrator.ports.plans.frames import Body, Bushing, Drive, Exciter, FramesPlan, Motor
from orchestrator.ports.plans.panel import LARGEST_MESHES_GIB, Hyperelastic, MeshSize, PanelPlan, Stop
from orchestrator.ports.plans.particles import (
    Exit,
    Feed,
    GrainMaterial,
    Jkr,
    ParticleList,
    ParticlesPlan,
    Sjkr,
)
from orchestrator.ports.plans.work import Cost, FramesWork, PanelsWork, ParticlesWork

__all__ = [
    "LARGEST_MESHES_GIB",
    "Body",
    "Bushing",
    "Cost",
    "Drive",
    "Exciter",
    "Exit",
    "Feed",
    "FramesPlan",
    "FramesWork",
    "GrainMaterial",
    "Hyperelastic",
    "Jkr",
    "MeshSize",
    "Motor",
    "PanelPlan",
    "PanelsWork",
    "ParticleList",
    "ParticlesPlan",
    "ParticlesWork",
    "Sjkr",
    "SolverFailed",
    "SolverMissing",
    "Stop",
]
