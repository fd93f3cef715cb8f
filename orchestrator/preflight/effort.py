"""How well an interval is solved that a scheme repeats."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.tables.case import Case
from orchestrator.ports.physics import sphere_mass_kg


@dataclass(frozen=True)
class Tries:
    """How often an interval is run on average, by the particles and by the panels; ``point_s`` is
    the processor time in which the scheme looks for the way of a point of the surface."""

    particles: float
    panel: float
    point_s: float = 0.0


RUNS = {
    "particles-first": Tries(1.0, 1.0),
    "serial-staggered": Tries(1.0, 1.0),
    "robin": Tries(1.0, 2.0, 1.1e-6),
    "aitken": Tries(2.0, 3.0),
    "quasi-newton": Tries(2.0, 3.0),
}
"""Measured over whole runs of quickstart, draft; repeated intervals end with the panels under the
load that was found."""


@dataclass(frozen=True)
class Effort:
    """An interval is solved when the load that the particles give differs from the one that the
    panel moved under by at most ``tolerance`` of its size, or by ``floor_N``; sizes are Euclidean
    norms over all surface points.  It is run at most ``most`` times."""

    tolerance: float = 1e-3
    floor_N: float = 0.0
    most: int = 20


def effort(case: Case) -> Effort:
    """What a case asks for; the floor is the tolerance of the lightest particle's weight."""
    tolerance = case.coupling.tolerance
    lightest_kg = min(
        (
            float(sphere_mass_kg(np.array(diameter_m), case.materials[name].density_kg_per_m3))
            for name, diameter_m in smallest_diameters_m(case).items()
        ),
        default=0.0,
    )
    weight_N = lightest_kg * float(np.linalg.norm(case.gravity_m_per_s2))
    return Effort(tolerance, tolerance * weight_N, case.coupling.most_iterations)
