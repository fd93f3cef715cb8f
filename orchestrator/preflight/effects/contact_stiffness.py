"""Contacts as stiff as the materials; softened contacts must not let particles through panels."""

from __future__ import annotations

from orchestrator.preflight.scene.contacts import STEP_COST, compute_softness, is_softened
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene

LARGEST_OVERLAP = 1 / 3
"""Largest overlap over the radius.

Results of loaded cases differ by 0.3 % between 1e6 and 1e8 Pa; the estimated overlaps of
cases/ffs0827-slice are then 0.30 and 0.05.  Overlaps in runs are up to 1.5 times as large as estimated.
Above the limit, a particle's centre may therefore come within half a radius of a panel; at an overlap
of 1 it passes through."""


def judge(scene: Scene) -> Verdict:
    """Judge the largest overlap of contacts over the radius, as the particles are softened."""
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
