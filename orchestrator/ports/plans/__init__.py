"""Plans: all that a solver needs to know to be built, checked and in plain records.

``build.py`` makes them from the case; tests make them by hand.  Every adapter is a module
``adapters.<port>.<solver>`` with one function ``build(plan)`` that returns the open solver.
Here they are by port, each field with its unit and meaning: ``frames``, ``panel``, ``particles``.
"""

from __future__ import annotations

from orchestrator.ports.failures import SolverFailed, SolverMissing
from orchestrator.ports.plans.frames import (
    BodyPlan,
    BushingPlan,
    DrivePlan,
    ExciterPlan,
    FramesPlan,
    MotorPlan,
)
from orchestrator.ports.plans.panel import LARGEST_MESHES_GIB, HyperelasticPlan, MeshSize, PanelPlan, StopPlan
from orchestrator.ports.plans.particles import (
    ExitPlan,
    GrainMaterial,
    Jkr,
    ParticleFeed,
    ParticleList,
    ParticlesPlan,
    Sjkr,
)
from orchestrator.ports.plans.work import Cost, FramesWork, PanelsWork, ParticlesWork

__all__ = [
    "LARGEST_MESHES_GIB",
    "BodyPlan",
    "BushingPlan",
    "Cost",
    "DrivePlan",
    "ExciterPlan",
    "ExitPlan",
    "FramesPlan",
    "FramesWork",
    "GrainMaterial",
    "HyperelasticPlan",
    "Jkr",
    "MeshSize",
    "MotorPlan",
    "PanelPlan",
    "PanelsWork",
    "ParticleFeed",
    "ParticleList",
    "ParticlesPlan",
    "ParticlesWork",
    "Sjkr",
    "SolverFailed",
    "SolverMissing",
    "StopPlan",
]
