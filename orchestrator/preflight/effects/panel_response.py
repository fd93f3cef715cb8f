"""Panels move as their clamps and their own state make them, not as they did in an earlier run."""

from __future__ import annotations

from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene, elastic_solvers


def judge(scene: Scene) -> Verdict:
    why = "a recording holds for the machine and the cycles it was made of, and no others"
    return Verdict("none", None, "none", None, why, elastic_solvers())


EFFECT = Effect(part="panels", judge=judge, needs=("panel-deformation",), key="panel.solver")
