"""Panels push the frames: their stiffness along the deck over that of the bushings between the
same frames, and the stroke without them."""

from __future__ import annotations

import math

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.clamp_motion import change_of_stroke, moved_by_forces
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames, solve_shakings


def judge(scene: Scene) -> Verdict | None:
    """None without frames."""
    if not scene.plan.bodies:
        return None
    free = bool(free_frames(scene.plan))
    ratio = _panels_share(scene)
    change, why = change_of_stroke(scene, solve_shakings(scene.plan), "without the panels")
    if not free:
        why = "all frames move as prescribed: panels cannot change that"
    if not scene.panels:
        why = "there are no panels"
    return Verdict(
        number="panels / bushings, stiffness along the deck",
        value=max(ratio, abs(change)) if free else None,
        threshold="0.1, or the stroke by a tenth",
        matters=free and (ratio > TENTH or abs(change) > TENTH),
        limit=TENTH,
        why=why,
        cost="hardly anything",
    )


def _panels_share(scene: Scene) -> float:
    """Largest over the pairs of frames that panels join; infinite where nothing else does."""
    found = [0.0]
    pairs = {frozenset(spring.frames) for spring in scene.springs}
    for pair in (one for one in pairs if len(one) == 2):
        springs = [one for one in scene.springs if frozenset(one.frames) == pair]
        along = springs[0].along
        joints = [one for one in scene.plan.bushings if frozenset(one.bodies) == pair]
        bushings_N_per_m = sum(one.stiffness_N_per_m @ (one.axes @ along) ** 2 for one in joints)
        panels_N_per_m = sum(spring.stiffness_N_per_m for spring in springs)
        found.append(float(panels_N_per_m / bushings_N_per_m) if bushings_N_per_m else math.inf)
    return max(found)


def left_out(case: Case) -> str:
    off = "exchange.panel_reaction is off: frames do not feel panels and walls"
    return "" if case.exchange.panel_reaction else off


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: bool(moved_by_forces(case)) and bool(case.screen.panels),
    left_out=left_out,
    overlay=lambda case: {"exchange": {"panel_reaction": False}},
    needs=("frame-dynamics",),
    key="exchange.panel_reaction",
    checked_by="panels_N_per_m",
)
