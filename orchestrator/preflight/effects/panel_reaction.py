"""Reaction of the panels on the frames.

The panels' stiffness along the deck is compared with the bushings' stiffness between the same frames,
and the stroke with the stroke without panels.
"""

from __future__ import annotations

import math

from orchestrator.preflight.scene.clamp_motion import change_of_stroke, has_moved_by_forces
from orchestrator.preflight.scene.effect import Verdict, compare, exchange_effect
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames, solve_shakings


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the panels' stiffness and the stroke; None without frames."""
    if not scene.plan.bodies:
        return None
    free = bool(free_frames(scene.plan))
    change, why = change_of_stroke(scene, solve_shakings(scene.plan), "without the panels")
    if not free:
        why = "all frames move as prescribed: panels cannot change that"
    if not scene.panels:
        why = "there are no panels"
    number, value = "panels / bushings, stiffness along the deck", _panels_share(scene)
    if abs(change) > value:
        number, value = "change of the stroke", abs(change)
    if not free:
        return Verdict(number, None, "0.1", False, why, "hardly anything")
    return compare(number, value, why, cost="hardly anything")


def _panels_share(scene: Scene) -> float:
    """Return the largest ratio of the panels' stiffness to the bushings' of all pairs of frames.

    The ratio is infinite if panels alone join a pair.
    """
    shares = [0.0]
    pairs = {frozenset(spring.frames) for spring in scene.springs}
    for pair in (pair for pair in pairs if len(pair) == 2):
        springs = [spring for spring in scene.springs if frozenset(spring.frames) == pair]
        along = springs[0].along
        bushings = [row for row in scene.plan.bushings if frozenset(row.bodies) == pair]
        bushings_N_per_m = sum(row.stiffness_N_per_m @ (row.axes @ along) ** 2 for row in bushings)
        panels_N_per_m = sum(spring.stiffness_N_per_m for spring in springs)
        shares.append(float(panels_N_per_m / bushings_N_per_m) if bushings_N_per_m else math.inf)
    return max(shares)


EFFECT = exchange_effect(
    "frames",
    judge,
    "panel_reaction",
    off="frames do not feel panels and walls",
    described=lambda case: has_moved_by_forces(case) and bool(case.screen.panels),
    needs=("frame-dynamics",),
    checked_by="panels_N_per_m",
)
