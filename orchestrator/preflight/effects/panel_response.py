"""Response of panels to their clamps and loads, instead of the motion that an earlier run recorded."""

from __future__ import annotations

from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene, elastic_solvers


def judge(scene: Scene) -> Verdict:
    """Return the verdict that no number can judge a recording in place of a panel."""
    why = "a recording holds for the machine and the cycles it was made of, and no others"
    return Verdict("none", None, "none", None, why, elastic_solvers())


EFFECT = Effect(part="panels", judge=judge, needs=("panel-deformation",), key="panel.solver")
