"""Panels' inertia: square of the excitation's frequency over the panel's lowest."""

from __future__ import annotations

from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import NOTHING_MOVES, Scene, elastic_solvers


def judge(scene: Scene) -> Verdict:
    frequency = min(panel.frequency_rad_per_s for panel in scene.panels)
    ratio = (scene.speed_rad_per_s / frequency) ** 2
    shaken = scene.speed_rad_per_s > 0
    return Verdict(
        number="(speed / lowest frequency)^2",
        value=ratio if shaken else None,
        threshold="0.1 (one oscillator)",
        matters=ratio > TENTH if shaken else None,
        limit=TENTH,
        why=f"the empty panel's lowest is at {frequency:.3g} rad/s" if shaken else NOTHING_MOVES,
        cost=elastic_solvers(),
    )


EFFECT = Effect(
    part="panels", judge=judge, described=lambda case: bool(case.screen.panels), needs=("panel-deformation",)
)
