"""Sizes decide what passes; in a bed, small ones trickle through from a ratio of 6.46."""

from __future__ import annotations

import math

from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.bed.sources import largest_diameter_m
from orchestrator.case.deck.openings import smaller_sides_m
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.observed import Products
from orchestrator.preflight.scene.scene import Scene

PERCOLATION = 1 / (2 / math.sqrt(3) - 1)  # 6.46: through the throat between three touching spheres
COST = "number of particles with 1/d^3, step with d of the smallest"


def judge(scene: Scene) -> Verdict:
    """By the sizes that there are, or by those of a run's products."""
    if scene.observed.products is not None:
        return _separated(scene.observed.products)
    ratio = _ratio(scene.case)
    matters, why = _matter(scene.case, ratio)
    return Verdict(
        number="largest / smallest diameter",
        value=ratio,
        threshold="6.46 (throat of three), or openings between",
        matters=matters,
        why=why,
        cost=COST,
    )


def _separated(products: Products) -> Verdict:
    return Verdict(
        number="coarsest / finest product, mean diameter",
        value=products.ratio,
        threshold="1.1 (own choice)",
        matters=products.ratio > 1 + TENTH,
        why=products.words,
        cost=COST,
    )


def _ratio(case: Case) -> float:
    return largest_diameter_m(case) / min(smallest_diameters_m(case).values())


def _matter(case: Case, ratio: float) -> tuple[bool | None, str]:
    low_m = min(smallest_diameters_m(case).values()) / case.particles.coarse_graining
    for opening_m in smaller_sides_m(case):
        if low_m < opening_m <= ratio * low_m:
            return True, f"openings of {opening_m * 1e3:.3g} mm divide the sizes"
    if ratio >= PERCOLATION:
        return True, "small ones trickle through the gaps between large ones"
    if ratio == 1.0:
        return None, "there is one size only; whether the material has more is not said"
    return None, "a shaken bed separates smaller ratios, too: only a run tells"


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: has_particles(case) and _ratio(case) > 1,
    key="bed: sizes, curve, smallest_fed_m",
    checked_by="products",
    about=("particles",),
)
