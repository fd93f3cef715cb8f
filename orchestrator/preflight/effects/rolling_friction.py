"""Rolling friction, with which a sphere rolls down a slope with 5/7 g (sin - mu_r cos).

A lone sphere stops on a slope whose tangent is below mu_r.  On a steeper one it rolls ever faster, while
grains that are no spheres stop: what rolls depends on the friction that stands for their shape.
"""

from __future__ import annotations

from orchestrator.preflight.scene.contacts import (
    LEVEL,
    contact_law_effect,
    contacts_on_deck,
    describe_friction,
    friction_over_pull,
)
from orchestrator.preflight.scene.effect import Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    """Judge rolling friction, which matters on every slope, and on the level where there is any."""
    friction = max((row.rolling_friction for row in contacts_on_deck(scene.case)), default=0.0)
    ratio = friction_over_pull(scene, friction)
    why = describe_friction(ratio, "rolling alone")
    slopes = scene.slope >= LEVEL
    if slopes and ratio < 1:
        why += ": a lone sphere does not stop, and grains that are not spheres do"
    number, threshold, cost = "mu_r / tan(slope)", "1 (a lone sphere stops)", "a contact history (epsd2)"
    return Verdict(number, ratio, threshold, slopes or ratio > 0, why, cost)


EFFECT = contact_law_effect(
    judge,
    coefficient="rolling_friction",
    law="rolling",
    laws=("cdt", "epsd2"),
    without="no resistance to rolling",
    key="particles.rolling",
    checked_by="bearing",
)
