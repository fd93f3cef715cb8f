"""The case with coarse-grained particles: each stands for k^3 of the case's, k = its
``particles.coarse_graining``.

Diameters are multiplied by k, at the same density, stiffness, restitution and friction; so all
stresses and energies per volume stay what they are, and Hertz's contacts know no size.  Adhesion
does: its share of the energy goes with work / diameter, so works of adhesion are multiplied by k,
too.  Bierwisch, C., Kraft, T., Riedel, H. and Moseler, M., Journal of the Mechanics and Physics of
Solids 57, 2009, 10-31, doi 10.1016/j.jmps.2008.10.006.

A coarse particle does not pass an opening as the real ones do: only what is far larger than the
openings may be coarse.
"""

from __future__ import annotations

import math
from typing import TypeVar

from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.tables.bed import Bed, Filling
from orchestrator.case.tables.case import Case

KEY: Key = ("particles", "coarse_graining")
FAR_LARGER = 4.0  # openings: what is never held in one

Filled = TypeVar("Filled", bound=Filling)


def coarsen(case: Case) -> Case:
    """The case with coarse particles, itself for k = 1.  Raises CaseError where they make no sense."""
    k = case.particles.coarse_graining
    if k == 1.0:
        return case
    if found := [*_single_particles(case), *_across_openings(case)]:
        raise CaseError(found)
    contacts = tuple(row.times(k, "work_of_adhesion_J_per_m2") for row in case.contacts)
    return case.with_coarse({"bed": _bed(case.bed, k), "contacts": contacts})


def _single_particles(case: Case) -> list[CaseProblem]:
    if not case.bed.particles:
        return []
    first = next(iter(case.bed.particles))
    what = f"single particles (bed.particles.{first}) stand for themselves"
    return [CaseProblem(KEY, what, "take 1, or blocks and feeds")]


def _across_openings(case: Case) -> list[CaseProblem]:
    openings_m = [
        min(panel.apertures.length_m, panel.apertures.width_m)
        for panel in case.screen.panels.values()
        if panel.apertures is not None
    ]
    if not openings_m:
        return []
    limit_m = FAR_LARGER * max(openings_m)
    found = []
    for kind, rows in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds)):
        for name, row in rows.items():
            smallest_m = _smallest_m(row)
            if smallest_m < limit_m:
                what = (
                    f"bed.{kind}.{name} has particles of {smallest_m:g} m: coarse ones do not meet "
                    f"openings of {max(openings_m):g} m as they do"
                )
                hint = f"take 1; only beds of {limit_m:g} m and more may be coarse here"
                found.append(CaseProblem(KEY, what, hint))
    return found


def _smallest_m(row: Filling) -> float:
    """Smallest diameter that a block or feed is made of; infinite if it names none."""
    given = [one.smallest_m for one in row.sizes] + [one.diameter_m for one in row.curve]
    return max(min(given, default=math.inf), row.smallest_fed_m or 0.0)


def _bed(bed: Bed, k: float) -> Bed:
    blocks = {
        name: _scaled(row, k).model_copy(update={"count": max(1, round(row.count / k**3))})
        for name, row in bed.blocks.items()
    }
    feeds = {name: _scaled(row, k) for name, row in bed.feeds.items()}
    return bed.model_copy(update={"blocks": blocks, "feeds": feeds})


def _scaled(row: Filled, k: float) -> Filled:
    sizes = tuple(size_class.times(k, "smallest_m", "largest_m") for size_class in row.sizes)
    curve = tuple(point.times(k, "diameter_m") for point in row.curve)
    return row.times(k, "smallest_fed_m").model_copy(update={"sizes": sizes, "curve": curve})
