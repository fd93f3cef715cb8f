"""Contacts as stiff as the materials, at openings: a soft particle passes one that is smaller by
its overlap."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.bed.size_distribution import classes
from orchestrator.casefile.contents import has_particles
from orchestrator.deck.opening_places import smaller_sides_m
from orchestrator.scene.effect import Effect, Verdict
from orchestrator.scene.scene import Scene
from orchestrator.scene.softness import STEP_COST, Softness, softened, softness

LARGEST_SHIFT = 0.01  # of an opening, by which soft particles seem smaller: the project's choice
NEAR = 1.5  # ratio to an opening of what may just pass or just not: the project's choice


def judge(scene: Scene) -> Verdict | None:
    """Of a particle as large as an opening, if there are any near it; None without openings."""
    openings_m = list(smaller_sides_m(scene.case))
    if not openings_m:
        return None
    found, opening_m = softness(scene), max(openings_m)
    near = any(low < NEAR * opening_m and high > opening_m / NEAR for low, high in _sizes_m(scene))
    overlap = found.overlap / 2
    if scene.seen.deepest is not None:
        overlap = scene.seen.deepest.surface_m / opening_m
    value = overlap if near else 0.0
    far = (
        f"no particles are within a factor of {NEAR:g} of the openings of {opening_m * 1e3:.2g} mm"
    )
    return Verdict(
        number="overlap / opening",
        value=value,
        threshold="0.01 (own choice)",
        matters=value > LARGEST_SHIFT,
        why=_words(scene, found, overlap, opening_m) if near else far,
        cost=STEP_COST,
    )


def _words(scene: Scene, found: Softness, overlap: float, opening_m: float) -> str:
    who = "" if scene.seen.deepest is not None else f"a particle of {opening_m * 1e3:.2g} mm "
    return found.in_words(overlap, LARGEST_SHIFT, who + found.where)


def _sizes_m(scene: Scene) -> Iterator[tuple[float, float]]:
    """Limits of all classes, of real particles."""
    k = scene.case.particles.coarse_graining
    for one in scene.case.bed.particles.values():
        yield one.diameter_m, one.diameter_m
    for source in scene.case.bed.sources:
        for row in classes(source):
            yield row.smallest_m / k, row.largest_m / k


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: has_particles(case) and not softened(case),
    key="particles.largest_youngs_modulus_Pa",
    checked_by="deepest",
)
