"""Damping in the panels' material.

In each cycle, it takes a share of the stored energy that is 2 pi times the loss factor.
"""

from __future__ import annotations

import math

from orchestrator.case.tables.case import Case, Hyperelastic
from orchestrator.preflight.scene.effect import MARGIN, TENTH, Effect, Overlay, Verdict, compare
from orchestrator.preflight.scene.moved_panel import loss_factor
from orchestrator.preflight.scene.scene import Scene

NUMBER = "energy lost / stored, per cycle", "0.1 (loss factor 0.016)"
COST = "hardly anything if nothing varies across, else an eighth to a quarter of the panels' time"
LOSSES = "maxwell", "loss_curve"
HARMONICS = 20  # multiples of the excitation's frequency that count, up to some hundred Hz


def judge(scene: Scene) -> Verdict:
    """Judge the energy that the panels' material loses in a cycle, over the energy stored."""
    number, threshold = NUMBER
    if not any(panel.material.branches for panel in scene.panels):
        unknown = "neither branches nor a curve are given: measure the loss factor (0.02 would matter)"
        return compare(number, None, unknown, threshold, cost=COST)
    w, where = scene.speed_rad_per_s, "the excitation's frequency"
    if w == 0:
        w, where = min(panel.frequency_rad_per_s for panel in scene.panels), "its own frequency"
    factor = max(loss_factor(panel.material, w) for panel in scene.panels)
    if scene.observed.loss_factor is not None:
        factor, where = scene.observed.loss_factor, "the frequencies of the panels' pull"
    why = f"loss factor {factor:.2g} at {where}"
    verdict = compare(number, 2 * math.pi * factor, why, threshold, cost=COST)
    if verdict.matters:
        change = scene.change_of_response(loss_factor=factor)
        if change is not None and change <= TENTH:
            verdict = verdict.doubted(f"taut panels' middles move as far without, to {change:.1%}")
    elif any(scene.near_resonance(panel) for panel in scene.panels):
        verdict = verdict.doubted("near a panel's resonance only damping limits its answer")
    if not verdict.matters and _lost_at_harmonics(scene) > TENTH / MARGIN:
        verdict = verdict.doubted("slack panels snap, and lose more at multiples of it")
    return verdict


def _lost_at_harmonics(scene: Scene) -> float:
    """Return the largest loss per cycle at multiples of the excitation's frequency.

    Only panels that are slack in a part of the cycle count, because their pull is a train of pulses.
    """
    factors = (
        loss_factor(panel.material, number * scene.speed_rad_per_s)
        for panel in scene.panels
        if panel.sag_m > 0
        for number in range(1, HARMONICS + 1)
    )
    return 2 * math.pi * max(factors, default=0.0)


def overlay(case: Case) -> Overlay:
    """Return the overlay that takes the loss out of all panel materials.

    Its lists are empty and not gone, since the library completes what a material does not give.
    """
    laws = {name: material.hyperelastic for name, material in case.materials.items()}
    rows: Overlay = {
        name: {"hyperelastic": {key: [] for key in LOSSES if getattr(law, key)}}
        for name, law in laws.items()
        if _is_damped(law)
    }
    return {"materials": rows} if rows else {}


def _is_damped(law: Hyperelastic | None) -> bool:
    return law is not None and any(getattr(law, key) for key in LOSSES)


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: any(_is_damped(row.hyperelastic) for row in case.materials.values()),
    overlay=overlay,
    needs=("panel-deformation",),
    key="materials.<name>.hyperelastic.maxwell",
    checked_by="loss_factor",
    saves=True,
    about=("panels",),
)
