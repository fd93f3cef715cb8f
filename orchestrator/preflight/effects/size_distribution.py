"""Distribution of the particles' sizes, which decides what passes the openings.

In a bed, small particles trickle through the gaps from a ratio of sizes of 6.46.
"""

from __future__ import annotations

import math

from orchestrator.case.bed.grains import sieve_sizes_m
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import Scene

PERCOLATION = 1 / (2 / math.sqrt(3) - 1)  # 6.46: the throat between three touching spheres
COST = "number of particles with 1/d^3, step with d of the smallest"


def judge(scene: Scene) -> Verdict:
    """Return the verdict on the sizes of the particles or, after a run, of its products."""
    products = scene.observed.products
    if products is not None:
        number, threshold = "coarsest / finest product, mean size", f"{1 + TENTH:g} (own choice)"
        return Verdict(number, products.ratio, threshold, products.ratio > 1 + TENTH, products.words, COST)
    ratio = _ratio(scene.case)
    number, threshold = "largest / smallest size", "6.46 (throat of three), or openings between"
    return Verdict(number, ratio, threshold, *_matter(scene, ratio), COST)


def _ratio(case: Case) -> float:
    smallest_m, largest_m = sieve_sizes_m(case)
    return largest_m / smallest_m


def _matter(scene: Scene, ratio: float) -> tuple[bool | None, str]:
    for opening_m in scene.openings_m:
        if scene.finest_m < opening_m <= ratio * scene.finest_m:
            return True, f"openings of {opening_m * 1e3:.3g} mm divide the sizes"
    if ratio >= PERCOLATION:
        return True, "small ones trickle through the gaps between large ones"
    if ratio == 1.0:
        return None, "there is one size only; whether the material has more is not said"
    return None, "a shaken bed separates smaller ratios, too: only a run tells"


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: _ratio(case) > 1,
    key="bed: sizes, curve, smallest_fed_m",
    checked_by="products",
    about=("particles",),
)
