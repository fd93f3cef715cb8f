"""Damping in the panels' material: energy lost per cycle over energy stored, 2 pi times the loss
factor."""

from __future__ import annotations

import math

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.effect import MARGIN, TENTH, Effect, Overlay, Verdict
from orchestrator.preflight.scene.moved_panel import loss_factor
from orchestrator.preflight.scene.scene import Scene

HARMONICS = 20  # of the excitation: to some hundred Hz


def judge(scene: Scene) -> Verdict:
    if scene.speed_rad_per_s == 0:
        speed, where = min(panel.frequency_rad_per_s for panel in scene.panels), "its own frequency"
    else:
        speed, where = scene.speed_rad_per_s, "the excitation's frequency"
    factor = max(loss_factor(panel.material, speed) for panel in scene.panels)
    if scene.observed.loss_factor is not None:
        factor, where = scene.observed.loss_factor, "the frequencies of the panels' pull"
    lost = 2 * math.pi * factor
    given = any(panel.material.branches for panel in scene.panels)
    matters: bool | None = lost > TENTH
    why = f"loss factor {factor:.2g} at {where}"
    if not matters and any(scene.near_resonance(panel) for panel in scene.panels):
        matters, why = None, f"{why}; near a panel's resonance only damping limits its answer"
    change = scene.change_of_response(loss_factor=factor)
    if matters and change is not None and change <= TENTH:
        matters, why = None, f"{why}; taut panels' middles move as far without, to {change:.1%}"
    unknown = "neither branches nor a curve are given: measure the loss factor (0.02 would matter)"
    if not matters and _at_harmonics(scene) > TENTH / MARGIN:
        matters, why = None, f"{why}; slack panels snap, and lose more at multiples of it"
    return Verdict(
        number="energy lost / stored, per cycle",
        value=lost if given else None,
        threshold="0.1 (loss factor 0.016)",
        matters=matters if given else None,
        limit=TENTH,
        why=why if given else unknown,
        cost="hardly anything if nothing varies across, else an eighth to a quarter of the panels' time",
    )


def _at_harmonics(scene: Scene) -> float:
    """Largest loss per cycle at multiples of the excitation of panels that are slack in part of the
    cycle: their pull is a train of pulses."""
    slack = [panel for panel in scene.panels if panel.sag_m > 0]
    every = (
        loss_factor(panel.material, number * scene.speed_rad_per_s)
        for panel in slack
        for number in range(1, HARMONICS + 1)
    )
    return 2 * math.pi * max(every, default=0.0)


def overlay(case: Case) -> Overlay:
    without: Overlay = {"hyperelastic": {"maxwell": None, "loss_curve": None}}
    damped = _damped(case)
    return {"materials": dict.fromkeys(damped, without)} if damped else {}


def _damped(case: Case) -> list[str]:
    return [
        name
        for name, material in case.materials.items()
        if (law := material.hyperelastic) and (law.maxwell or law.loss_curve)
    ]


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: bool(case.screen.panels) and bool(_damped(case)),
    overlay=overlay,
    needs=("panel-deformation",),
    key="materials.<name>.hyperelastic.maxwell",
    checked_by="loss_factor",
    saves=True,
    about=("panels",),
)
