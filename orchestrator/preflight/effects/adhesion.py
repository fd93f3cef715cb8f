"""Adhesion: JKR's pull-off force of the smallest particles over their weight (the Bond number),
over what pulls them apart, their weight and the throw."""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.tables.case import Case
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2, sphere_mass_kg
from orchestrator.preflight.scene.contacts import contact_law_effect
from orchestrator.preflight.scene.effect import TENTH, Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    pull = max((pull * work for pull, work in _pulls(scene.case)), default=0.0)
    apart = 1 + scene.throw
    ratio = pull / apart
    sticks = f"the pull-off force is {pull:.3g} weights, shaking pulls with {apart:.3g}"
    dry = "no contact has a work of adhesion: the material is dry"
    return Verdict(
        number="Bond / (1 + throw)",
        value=ratio,
        threshold="0.1 (JKR 1971)",
        matters=ratio > TENTH,
        limit=TENTH,
        why=sticks if pull else f"{dry}{_would_matter(scene, apart)}",
        cost="about half as much again per step (jkr)",
    )


def _pulls(case: Case) -> Iterator[tuple[float, float]]:
    """Pull-off force over weight for a work of adhesion of 1 J/m2, and the work: of the smallest
    real particles of each pair that can meet, whatever coarse ones the case computes."""
    k = case.particles.coarse_graining
    radius_m = {name: d / 2 / k for name, d in smallest_diameters_m(case).items()}
    for row in case.contacts:
        radii = [radius_m.get(name, math.inf) for name in row.between]
        if math.isinf(min(radii)):
            continue
        name = row.between[radii.index(min(radii))]
        weight_N = STANDARD_GRAVITY_M_PER_S2 * sphere_mass_kg(
            2 * min(radii), case.materials[name].density_kg_per_m3
        )
        reduced_m = 1 / (1 / radii[0] + 1 / radii[1])
        yield 1.5 * math.pi * reduced_m / weight_N, row.work_of_adhesion_J_per_m2 / k


def _would_matter(scene: Scene, apart: float) -> str:
    most = max((pull for pull, _ in _pulls(scene.case)), default=0.0)
    return f" (it would matter from {TENTH * apart / most:.1g} J/m2)" if most else ""


EFFECT = contact_law_effect(
    judge,
    coefficient="work_of_adhesion_J_per_m2",
    law="adhesion",
    laws=("jkr", "sjkr"),
    without="nothing sticks",
    key="particles.adhesion",
    checked_by="frames_throw",
)
