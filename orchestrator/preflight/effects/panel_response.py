"""Panels move as their clamps and their own state make them, not as they did in an earlier run."""

from __future__ import annotations

from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene, elastic_solvers


def judge(scene: Scene) -> Verdict:
    return Verdict(
        number="none",
        value=None,
        threshold="none",
        matters=None,
        why="a recording holds for the machine and the cycles it was made of, and no others",
        cost=elastic_solvers(),
    )


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: bool(case.screen.panels),
    needs=("panel-deformation",),
    key="panel.solver",
)
