"""Rolling friction: a sphere rolls down with 5/7 g (sin - mu_r cos)."""

from __future__ import annotations

from orchestrator.preflight.scene.contacts import (
    contact_law_effect,
    contacts_on_deck,
    describe_friction,
    friction_over_pull,
)
from orchestrator.preflight.scene.effect import TENTH, Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    friction = max((row.rolling_friction for row in contacts_on_deck(scene.case)), default=0.0)
    ratio = friction_over_pull(scene, friction)
    matters: bool | None = ratio > TENTH
    why = describe_friction(ratio, "rolling alone")
    if matters and scene.throw > 1:
        matters, why = None, f"{why}; but what is thrown, with {scene.throw:.2g} g, hardly rolls"
    return Verdict(
        number="mu_r / tan(slope)",
        value=ratio,
        threshold="0.1 (rolling sphere)",
        matters=matters,
        limit=TENTH,
        why=why,
        cost="a contact history (epsd2)",
    )


EFFECT = contact_law_effect(
    judge,
    coefficient="rolling_friction",
    law="rolling",
    laws=("cdt", "epsd2"),
    without="no resistance to rolling",
    key="particles.rolling",
    checked_by="bearing",
)
