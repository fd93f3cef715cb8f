"""A slice against the particles in it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from orchestrator.case.bed.sources import largest_diameter_m
from orchestrator.case.deck.panels import walls
from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.file.slice import ENOUGH_DIAMETERS
from orchestrator.case.tables.case import Case, has_particles

FEWEST_DIAMETERS = 3.0  # a particle must not meet itself, or a neighbour twice


def too_narrow(case: Case) -> Iterator[CaseProblem]:
    """Periodic sides so close that particles would touch each other on both sides."""
    if case.slice is None or case.slice.sides == "walls" or not has_particles(case):
        return
    least_m = FEWEST_DIAMETERS * largest_diameter_m(case)
    if case.slice.width_m < least_m:
        what = f"{case.slice.width_m:g} m is less than {FEWEST_DIAMETERS:g} largest diameters"
        yield CaseProblem(("slice", "width_m"), what, f"take {least_m:.3g} m or more")


def doubtful_slice(case: Case, folder: Path) -> Iterator[str]:
    """A slice narrower than some particles, and one whose sides are open."""
    if case.slice is None or not has_particles(case):
        return
    width_m, diameter_m = case.slice.width_m, largest_diameter_m(case)
    if width_m < ENOUGH_DIAMETERS * diameter_m:
        yield (
            f"slice.width_m = {width_m:g} m is {width_m / diameter_m:.2g} of the largest "
            f"diameters, fewer than {ENOUGH_DIAMETERS:g}: large particles may bridge"
        )
    if case.slice.sides == "walls" and not _has_sides(case, folder):
        yield 'slice.sides = "walls", but no surface stands along the sides: particles can fall off'


def _has_sides(case: Case, folder: Path) -> bool:
    """Does any triangle stand along a side of the panels, or outside of them?"""
    y_m = [panel.corner_m[1] for panel in case.screen.panels.values()]
    y_m += [p.corner_m[1] + p.across[1] * p.width_m for p in case.screen.panels.values()]
    for wall in walls(case, folder):
        across_m = wall.position_m[wall.triangles][:, :, 1]
        outside = (across_m <= min(y_m) + 1e-6).all(axis=1)
        outside |= (across_m >= max(y_m) - 1e-6).all(axis=1)
        if np.any(outside):
            return True
    return False
