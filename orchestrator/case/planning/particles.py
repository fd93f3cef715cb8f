"""What the particles' solver needs of a case."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.bed.adhesion import planned_adhesion
from orchestrator.case.bed.contact_times import contact_moduli
from orchestrator.case.bed.particle_step import particle_step_s
from orchestrator.case.bed.sources import combined_feed, initial_particles, largest_diameter_m
from orchestrator.case.deck.panels import axes, to_world
from orchestrator.case.file.contents import has_particles
from orchestrator.case.planning.materials import by_pair, material_numbers
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import ExitPlan, GrainMaterial, ParticlesPlan


def particles_plan(
    case: Case, surface: TriangleSurface, communicator: Any = None, folder: Path | None = None
) -> ParticlesPlan | None:
    """``surface`` as the particles will touch it, its materials numbered by
    ``material_numbers``; None for a case without particles."""
    if not has_particles(case):
        return None
    numbers = material_numbers(case)
    cap = case.particles.largest_youngs_modulus_Pa
    return ParticlesPlan(
        surface=surface,
        materials=tuple(GrainMaterial(name, *contact_moduli(case.materials[name], cap)) for name in numbers),
        restitution=by_pair(case, numbers, "restitution", 1.0),
        sliding_friction=by_pair(case, numbers, "sliding_friction"),
        rolling_friction=_rolling_friction(case, numbers),
        adhesion=planned_adhesion(case, numbers),
        rolling="cdt" if case.particles.rolling == "cdt" else "epsd2",
        wear_m3_per_N_m=_wear(case, numbers),
        predicts_load=case.coupling.scheme == "robin",
        particles=initial_particles(case, numbers),
        largest_diameter_m=largest_diameter_m(case),
        domain_m=np.array(case.domain_m),
        gravity_m_per_s2=np.array(case.gravity_m_per_s2),
        step_s=particle_step_s(case),
        sync_interval_s=case.coupling.sync_interval_s,
        feed=combined_feed(case, numbers),
        exits=exits(case),
        periodic_y=case.slice is not None and case.slice.sides == "periodic",
        communicator=communicator,
        folder=folder,
    )


def exits(case: Case) -> tuple[ExitPlan, ...]:
    """The exits, as boxes in the world, in the order of the case."""
    found = []
    for name, row in case.screen.exits.items():
        low, high = np.array(row.box_m)
        center_m = to_world(case, (low + high) / 2.0)
        found.append(ExitPlan(name, row.product, center_m, axes(case).T, (high - low) / 2.0))
    return tuple(found)


def _rolling_friction(case: Case, numbers: dict[str, int]) -> Array:
    """(k, k)"""
    given = by_pair(case, numbers, "rolling_friction")
    return np.zeros_like(given) if case.particles.rolling == "none" else given


def _wear(case: Case, numbers: dict[str, int]) -> Array | None:
    """(k, k), or None where nothing wears."""
    rate_m3_per_N_m = by_pair(case, numbers, "specific_wear_m3_per_N_m")
    return rate_m3_per_N_m if rate_m3_per_N_m.any() and case.particles.wear != "none" else None
