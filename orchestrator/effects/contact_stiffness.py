"""Contacts as stiff as the materials: softened ones must stay small against the particles."""

from __future__ import annotations

from orchestrator.casefile.contents import has_particles
from orchestrator.scene.effect import Effect, Verdict
from orchestrator.scene.scene import Scene
from orchestrator.scene.softness import STEP_COST, softened, softness

LARGEST_OVERLAP = 0.1  # of the radius: contacts are small against bodies, as Hertz's theory wants


def judge(scene: Scene) -> Verdict:
    found = softness(scene)
    return Verdict(
        number="overlap / radius",
        value=found.overlap,
        threshold="0.1 (Hertz: small contacts)",
        matters=found.overlap > LARGEST_OVERLAP,
        why=found.in_words(found.overlap, LARGEST_OVERLAP, found.where),
        cost=STEP_COST,
    )


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: has_particles(case) and not softened(case),
    key="particles.largest_youngs_modulus_Pa",
    checked_by="deepest",
)
