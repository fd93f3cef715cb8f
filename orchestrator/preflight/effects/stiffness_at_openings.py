"""Contacts as stiff as the materials at openings.

A softened particle passes an opening that is smaller by its overlaps with both sides, and so counts
as finer than it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.case.bed.contact_times import hertz_static_overlap_m, pair_modulus_Pa
from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.bed.size_distribution import share_between
from orchestrator.case.tables.bed import SizeClass
from orchestrator.preflight.scene.contacts import STEP_COST, compute_softness, is_softened
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import Scene, bed_parts


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the mass that passes only by overlap over the mass that passes anyway.

    A particle overlaps at least as if its weight and the throw pressed it, and at most as in an impact.
    Return None without openings.
    """
    if not scene.openings_m:
        return None
    softness, opening_m = compute_softness(scene), max(scene.openings_m)
    pressed_m = pressed_overlap_m(scene, opening_m)
    struck_m = max(pressed_m, softness.overlap * opening_m / 2)
    if scene.observed.deepest is not None:
        struck_m = max(pressed_m, scene.observed.deepest.surface_m)
    least, most = (passing_more(scene, opening_m, overlap_m) for overlap_m in (pressed_m, struck_m))
    return Verdict(
        number="mass that overlaps let pass / that passes",
        value=most,
        threshold="0.1",
        matters=None if least <= TENTH < most else most > TENTH,
        why=(
            f"of {opening_m * 1e3:.2g} mm, {least:.1%} more pass when they lie and are thrown, "
            f"{most:.1%} if every one struck ({softness.where}) passed"
        ),
        cost=STEP_COST,
    )


def pressed_overlap_m(scene: Scene, size_m: float) -> float:
    """Return the overlap of particles of a size with a panel, for the softest pair, by weight and throw."""
    overlaps_m = [0.0]
    for name, smallest in smallest_grains(scene.case).items():
        grain = smallest.resized(size_m)
        force_N = grain.mass_kg * scene.gravity_m_per_s2 * (1 + scene.throw)
        for panel in {row.panel.table.material for row in scene.panels}:
            reduced_Pa = pair_modulus_Pa(scene.case, (name, panel))
            overlaps_m.append(hertz_static_overlap_m(force_N, grain.contact_radius_m, reduced_Pa))
    return max(overlaps_m)


def passing_more(scene: Scene, opening_m: float, overlap_m: float) -> float:
    """Return the mass of particles that pass an opening only by overlap over the mass of finer ones.

    The result is 0 if no particle passes by overlap alone; else it is infinite if none is finer.
    """
    masses = list(_masses(scene))
    more = sum(kg * share_between(row, opening_m, opening_m + 2 * overlap_m) for kg, row in masses)
    finer = sum(kg * share_between(row, 0.0, opening_m) for kg, row in masses)
    if more == 0.0:
        return 0.0
    return more / finer if finer else math.inf


def _masses(scene: Scene) -> Iterator[tuple[float, SizeClass]]:
    """Yield the mass in kg of every size class, with the sizes of real particles."""
    case, k = scene.case, scene.case.particles.coarse_graining
    for mass_kg, rows in bed_parts(case, lambda feed: feed.rate_kg_per_s * case.duration_s):
        for row in rows:
            real = row.times(1 / k, "smallest_m", "largest_m")
            yield mass_kg * row.mass_fraction, real


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: not is_softened(case),
    key="particles.largest_youngs_modulus_Pa",
    checked_by="deepest",
    about=("particles",),
)
