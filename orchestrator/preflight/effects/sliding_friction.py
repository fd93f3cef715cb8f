"""Sliding friction, which takes the share mu / tan of the pull down a slope.

A body slides with g (sin - mu cos).
"""

from __future__ import annotations

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.contacts import contacts_on_deck, describe_friction, friction_over_pull
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict, compare, overlay_of_rows
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    """Return the verdict on the coefficient or, after a run with friction, on the force of friction."""
    number, friction, bearing = "mu / tan(slope)", _friction(scene.case), scene.observed.bearing
    if bearing is not None and bearing.mobilised is not None:
        number, friction = "friction / weight, along the deck", bearing.mobilised
    ratio = friction_over_pull(scene, friction)
    why = describe_friction(ratio, "sliding")
    return compare(number, ratio, why, "0.1 (Coulomb)", cost="hardly anything")


def overlay(case: Case) -> Overlay:
    """Return the overlay that sets the sliding friction of all contacts to 0."""
    return overlay_of_rows("contacts", map(str, range(len(case.contacts))), {"sliding_friction": 0.0})


def _friction(case: Case) -> float:
    return max((row.sliding_friction for row in contacts_on_deck(case)), default=0.0)


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: _friction(case) > 0,
    overlay=overlay,
    key="contacts.sliding_friction",
    checked_by="bearing",
    about=("particles",),
)
