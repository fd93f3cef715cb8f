"""Coarse graining: each coarse particle stands for k^3 particles, where k is ``particles.coarse_graining``.

Diameters are multiplied by k; density, stiffness, restitution and friction stay the same.  All
stresses and energies per volume therefore stay the same, because Hertz's contact law does not
depend on the particles' size.  Adhesion does depend on it: its share of the energy is proportional
to work / diameter, and so the works of adhesion are multiplied by k, too.
Bierwisch, C., Kraft, T., Riedel, H. and Moseler, M., Journal of the Mechanics and Physics of
Solids 57, 2009, 10-31, doi 10.1016/j.jmps.2008.10.006.

A coarse particle does not pass an opening as real particles do.  Only particles that are far larger
than the openings may therefore be coarse.
"""

from __future__ import annotations

import math
from typing import TypeVar

from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.tables.bed import Bed, Feed, Filling
from orchestrator.case.tables.case import Case

KEY: Key = ("particles", "coarse_graining")
FAR_LARGER = 4.0  # An opening never holds a particle that is so many times larger.

Filled = TypeVar("Filled", bound=Filling)


def coarsen(case: Case) -> Case:
    """Return the case with coarse particles; for k = 1, the case itself.

    Raises CaseError for single particles and for particles that may pass an opening.
    """
    k = case.particles.coarse_graining
    if k == 1.0:
        return case
    if problems := [*_single_particles(case), *_across_openings(case)]:
        raise CaseError(problems)
    contacts = tuple(row.times(k, "work_of_adhesion_J_per_m2") for row in case.contacts)
    particles = case.particles
    if particles.sjkr_diameter_m is not None:
        particles = particles.times(k, "sjkr_diameter_m")
    return case.computed_with({"bed": _bed(case.bed, k), "contacts": contacts, "particles": particles})


def _single_particles(case: Case) -> list[CaseProblem]:
    if not case.bed.particles:
        return []
    first = next(iter(case.bed.particles))
    what = f"single particles (bed.particles.{first}) stand for themselves"
    return [CaseProblem(KEY, what, "take 1, or blocks and feeds")]


def _across_openings(case: Case) -> list[CaseProblem]:
    """Return a problem for each source of particles that are not far larger than the openings.

    Particles that are taken over have coarse diameters already.
    """
    openings_m = [
        panel.apertures.smaller_m for panel in case.screen.panels.values() if panel.apertures is not None
    ]
    if not openings_m:
        return []
    limit_m = FAR_LARGER * max(openings_m)
    smallest_m = {
        f"bed.{kind}.{name}": _smallest_m(row)
        for kind, rows in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds))
        for name, row in rows.items()
    }
    if (carried := case.bed.carried) is not None:
        real_m = float(carried.grains.sieve_size_m.min()) / case.particles.coarse_graining
        smallest_m[f"the bed from {carried.source}"] = real_m
    return [_too_fine(source, size_m, limit_m) for source, size_m in smallest_m.items() if size_m < limit_m]


def _too_fine(source: str, smallest_m: float, limit_m: float) -> CaseProblem:
    """Return the problem of a source whose smallest real particles are not far larger than the openings."""
    what = (
        f"{source} has particles of {smallest_m:.4g} m: coarse ones do not meet openings of "
        f"{limit_m / FAR_LARGER:g} m as they do"
    )
    return CaseProblem(KEY, what, f"take 1; only beds of {limit_m:g} m and more may be coarse here")


def _smallest_m(row: Filling) -> float:
    """Return the smallest size of a block or feed; infinite if it gives no sizes."""
    given_m = [size_class.smallest_m for size_class in row.sizes]
    given_m += [point.sieve_size_m for point in row.curve]
    return max(min(given_m, default=math.inf), row.smallest_fed_m or 0.0)


def _bed(bed: Bed, k: float) -> Bed:
    """Return the bed with sizes k times as large and with k^3 times fewer particles in blocks."""
    blocks = {
        name: _scale_sizes(row, k).model_copy(update={"count": max(1, round(row.count / k**3))})
        for name, row in bed.blocks.items()
    }
    feeds = {name: _scale_sizes(row, k) for name, row in bed.feeds.items()}
    return bed.model_copy(update={"blocks": blocks, "feeds": feeds})


def _scale_sizes(row: Filled, k: float) -> Filled:
    sizes = tuple(size_class.times(k, "smallest_m", "largest_m") for size_class in row.sizes)
    curve = tuple(point.times(k, "sieve_size_m") for point in row.curve)
    limits = ("smallest_fed_m", *(("sampled_below_m", "sampled_as_m") if isinstance(row, Feed) else ()))
    return row.times(k, *limits).model_copy(update={"sizes": sizes, "curve": curve})
