"""Rolling friction, with which a sphere rolls down a slope with 5/7 g (sin - mu_r cos)."""

from __future__ import annotations

from orchestrator.preflight.scene.contacts import (
    contact_law_effect,
    contacts_on_deck,
    describe_friction,
    friction_over_pull,
)
from orchestrator.preflight.scene.effect import Verdict, compare
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    """Judge rolling friction over the slope; the verdict is in doubt where particles are thrown."""
    friction = max((row.rolling_friction for row in contacts_on_deck(scene.case)), default=0.0)
    ratio = friction_over_pull(scene, friction)
    why, cost = describe_friction(ratio, "rolling alone"), "a contact history (epsd2)"
    verdict = compare("mu_r / tan(slope)", ratio, why, "0.1 (rolling sphere)", cost=cost)
    if verdict.matters and scene.throw > 1:
        return verdict.doubted(f"but what is thrown, with {scene.throw:.2g} g, hardly rolls")
    return verdict


EFFECT = contact_law_effect(
    judge,
    coefficient="rolling_friction",
    law="rolling",
    laws=("cdt", "epsd2"),
    without="no resistance to rolling",
    key="particles.rolling",
    checked_by="bearing",
)
