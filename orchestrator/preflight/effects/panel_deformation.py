"""Panels deform: what flat ones would change, in their middles' motion and in the stroke."""

from __future__ import annotations

import math

from orchestrator.case import solvers
from orchestrator.preflight.scene.clamp_motion import change_of_stroke
from orchestrator.preflight.scene.effect import PARTS, TENTH, Effect, Verdict
from orchestrator.preflight.scene.moved_panel import clamp_response
from orchestrator.preflight.scene.scene import NOTHING_MOVES, Scene
from orchestrator.preflight.scene.shaking import solve_shakings


def judge(scene: Scene) -> Verdict:
    """The largest of three shares: throw of the panels' middles of the frames'; what the clamps'
    motion alone, normal to a panel, makes of its middle; and what becomes of the stroke, as flat
    panels do not pull."""
    shaken = scene.speed_rad_per_s > 0
    shares = _slackening(scene), _answering(scene), _pulling(scene)
    number, ratio, why = max(shares, key=_size)
    matters: bool | None = ratio > TENTH
    if not matters and scene.bed_kg_per_m2 > TENTH * min(panel.mass_kg_per_m2 for panel in scene.panels):
        matters, why = None, f"{why}; what the bed does to them, only a run tells"
    return Verdict(
        number=number,
        value=ratio if shaken else None,
        threshold="0.1",
        matters=matters if shaken else None,
        limit=TENTH,
        why=why if shaken else NOTHING_MOVES,
        cost="little if nothing varies across, else a tenth to a half of the particles' time",
        about=PARTS if _size(shares[-1]) > TENTH else ("particles", "panels"),
    )


Share = tuple[str, float, str]


def _size(share: Share) -> float:
    return share[1]


def _slackening(scene: Scene) -> Share:
    """Arches of panels that are slack in part of the cycle."""
    throw, rigid = scene.panels_throw, scene.frames_throw
    ratio = throw / rigid if rigid else math.inf if throw else 0.0
    why = f"panels' middles are thrown with {throw:.2g} g, frames with {rigid:.2g} g"
    return "throw of panel / of frame", ratio, why


def _answering(scene: Scene) -> Share:
    """The panel nearest to its resonance."""
    ratio, lowest = max(
        (clamp_response(scene.speed_rad_per_s / one.frequency_rad_per_s), one.frequency_rad_per_s)
        for one in scene.panels
    )
    why = f"panels with {lowest:.3g} rad/s of their own answer a shaking of {scene.speed_rad_per_s:.3g}"
    return "answer of the middle / of the clamps", ratio, why


def _pulling(scene: Scene) -> Share:
    change, why = change_of_stroke(scene, solve_shakings(scene.plan), "flat panels do not pull: then")
    return "change of the stroke", abs(change), why


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: bool(case.screen.panels),
    overlay=lambda case: {"panel": {"solver": solvers.without("panel", "panel-deformation")}},
    key="panel.solver",
    checked_by="frames_throw",
    saves=True,
)
