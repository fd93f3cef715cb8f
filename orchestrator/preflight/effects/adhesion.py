"""Adhesion of particles.

It matters if JKR's pull-off force of the smallest particles is not small against the forces that pull
them apart.  The Bond number is the pull-off force over the weight; weight and throw pull apart.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.case.bed.adhesion import softened_work_J_per_m2
from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.tables.case import Case
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.preflight.scene.contacts import contact_law_effect
from orchestrator.preflight.scene.effect import TENTH, Verdict, compare
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    """Judge the largest pull-off force in weights of a particle over the pull of the shaking."""
    pulls, apart = list(_pulls(scene.case)), 1 + scene.throw
    pull = max((per_work * work for per_work, work in pulls), default=0.0)
    most = max((per_work for per_work, _ in pulls), default=0.0)
    why = f"the pull-off force is {pull:.3g} weights, shaking pulls with {apart:.3g}"
    if not pull:
        from_here = f" (it would matter from {TENTH * apart / most:.1g} J/m2)" if most else ""
        why = f"no contact has a work of adhesion: the material is dry{from_here}"
    cost = "about half as much again per step (jkr)"
    return compare("Bond / (1 + throw)", pull / apart, why, "0.1 (JKR 1971)", cost=cost)


def _pulls(case: Case) -> Iterator[tuple[float, float]]:
    """Yield the pull-off force over the weight at 1 J/m2, and the work of adhesion, of each pair that meets.

    Both are those of the smallest real particles, even if the case computes coarse ones, with the work of
    contacts as they are softened.
    """
    k = case.particles.coarse_graining
    real = {name: each.resized(each.sieve_size_m / k) for name, each in smallest_grains(case).items()}
    for number, row in enumerate(case.contacts):
        pair = [real[name] for name in row.between if name in real]
        if not pair:
            continue
        smaller = min(pair, key=lambda each: each.contact_radius_m)
        weight_N = STANDARD_GRAVITY_M_PER_S2 * smaller.mass_kg
        reduced_m = 1 / sum(1 / each.contact_radius_m for each in pair)
        yield 1.5 * math.pi * reduced_m / weight_N, softened_work_J_per_m2(case, number) / k


EFFECT = contact_law_effect(
    judge,
    coefficient="work_of_adhesion_J_per_m2",
    law="adhesion",
    laws=("jkr", "sjkr"),
    without="nothing sticks",
    key="particles.adhesion",
    checked_by="frames_throw",
)
