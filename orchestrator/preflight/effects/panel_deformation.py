"""Deformation of panels; the middles of flat panels would move otherwise, and the stroke would change."""

from __future__ import annotations

import math

from orchestrator.case import solvers
from orchestrator.preflight.scene.clamp_motion import change_of_stroke
from orchestrator.preflight.scene.effect import PARTS, TENTH, Effect, Verdict, compare
from orchestrator.preflight.scene.moved_panel import clamp_response
from orchestrator.preflight.scene.scene import NOTHING_MOVES, Scene
from orchestrator.preflight.scene.shaking import solve_shakings

COST = "little if nothing varies across, else a tenth to a half of the particles' time"


def judge(scene: Scene) -> Verdict:
    """Return the verdict on the largest of three numbers.

    They are the throw of the panels' middles over the throw of the frames, the response of a panel's
    middle to its clamps' normal motion, and the change of the stroke, because flat panels do not pull.
    """
    change, pulling = change_of_stroke(scene, solve_shakings(scene.plan), "flat panels do not pull: then")
    shares = _slackening(scene), _answering(scene), ("change of the stroke", abs(change), pulling)
    number, ratio, why = max(shares, key=lambda share: share[1])
    about = PARTS if abs(change) > TENTH else ("particles", "panels")
    if not scene.speed_rad_per_s > 0:
        return compare(number, None, NOTHING_MOVES, cost=COST, about=about)
    verdict = compare(number, ratio, why, cost=COST, about=about)
    lightest_kg_per_m2 = min(panel.mass_kg_per_m2 for panel in scene.panels)
    if not verdict.matters and scene.bed_kg_per_m2 > TENTH * lightest_kg_per_m2:
        return verdict.doubted("what the bed does to them, only a run tells")
    return verdict


def _slackening(scene: Scene) -> tuple[str, float, str]:
    """Return the name, value and text of the number for panels that are slack in a part of the cycle."""
    throw, rigid = scene.panels_throw, scene.frames_throw
    ratio = throw / rigid if rigid else math.inf if throw else 0.0
    why = f"panels' middles are thrown with {throw:.2g} g, frames with {rigid:.2g} g"
    return "throw of panel / of frame", ratio, why


def _answering(scene: Scene) -> tuple[str, float, str]:
    """Return the name, value and text of the number for the panel that is closest to its resonance."""
    ratio, lowest = max(
        (clamp_response(scene.speed_rad_per_s / panel.frequency_rad_per_s), panel.frequency_rad_per_s)
        for panel in scene.panels
    )
    why = f"panels with {lowest:.3g} rad/s of their own answer a shaking of {scene.speed_rad_per_s:.3g}"
    return "answer of the middle / of the clamps", ratio, why


EFFECT = Effect(
    part="panels",
    judge=judge,
    overlay=lambda case: {"panel": {"solver": solvers.name_without("panel", "panel-deformation")}},
    key="panel.solver",
    checked_by="frames_throw",
    saves=True,
)
