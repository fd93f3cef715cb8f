"""Contacts are as stiff as the materials; softened ones must not let particles through."""

from __future__ import annotations

from orchestrator.preflight.scene.contacts import STEP_COST, compute_softness, is_softened
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene

LARGEST_OVERLAP = 1 / 3
"""Of the radius.  Results of loaded cases were found to differ by 0.3 % from 1e6 to 1e8 Pa, which
for cases/ffs0827-slice are estimated overlaps of 0.30 to 0.05.  Overlaps in runs are up to 1.5
times as large as estimated, so that from here on a particle's centre may come within half a radius
of a panel, through which it passes at 1."""


def judge(scene: Scene) -> Verdict:
    softness = compute_softness(scene)
    return Verdict(
        number="overlap / radius",
        value=softness.overlap,
        threshold="0.333 (half a radius in a run)",
        matters=softness.overlap > LARGEST_OVERLAP,
        why=softness.in_words(LARGEST_OVERLAP),
        cost=STEP_COST,
    )


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: not is_softened(case),
    key="particles.largest_youngs_modulus_Pa",
    checked_by="deepest",
)
