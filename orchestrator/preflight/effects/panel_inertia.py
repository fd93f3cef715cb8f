"""Inertia of the panels, which matters by the square of the excitation's frequency over their lowest one."""

from __future__ import annotations

from orchestrator.preflight.scene.effect import Effect, Verdict, compare
from orchestrator.preflight.scene.scene import NOTHING_MOVES, Scene, elastic_solvers


def judge(scene: Scene) -> Verdict:
    """Judge the square of the excitation's frequency over the lowest one of a panel."""
    frequency = min(panel.frequency_rad_per_s for panel in scene.panels)
    shaken = scene.speed_rad_per_s > 0
    return compare(
        "(speed / lowest frequency)^2",
        (scene.speed_rad_per_s / frequency) ** 2 if shaken else None,
        f"the empty panel's lowest is at {frequency:.3g} rad/s" if shaken else NOTHING_MOVES,
        threshold="0.1 (one oscillator)",
        cost=elastic_solvers(),
    )


EFFECT = Effect(part="panels", judge=judge, needs=("panel-deformation",))
