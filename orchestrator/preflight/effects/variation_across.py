"""Variation of the panels across their width.

It matters if panels are wide against their length, because the clamps hinder their contraction.
"""

from __future__ import annotations

from orchestrator.case import solvers
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict
from orchestrator.preflight.scene.scene import Scene

WIDE = 1.0
"""Width over length above which it matters.  A panel without variation across is wrong by 2 and 9 % at
0.15 and 1.2 (docs/theory/panel_strip.md)."""


def judge(scene: Scene) -> Verdict:
    """Judge the width of the panels over their length; of a slice, the reason names the whole machine."""
    aspect = max(panel.panel.rectangle.width_m / panel.length_m for panel in scene.panels)
    why = "particles spread unevenly across, and corners, are not in this number"
    if scene.case.slice is not None:
        rows = scene.case.whole_machine.screen.panels.values()
        whole = max(row.width_m / row.length_m for row in rows)
        why = f"of the slice; the whole machine's panels have {whole:.2g}"
    return Verdict(
        number="width / length",
        value=aspect,
        threshold="1 (measured: with against without it)",
        matters=True if aspect > WIDE else None,
        why=why,
        cost="22 x 8 cells take 2 to 3 times the time of a panel without it",
    )


def overlay(case: Case) -> Overlay:
    """Return the keys of a solver without the variation, with its own step; empty with one cell along."""
    if case.panel.cells[0] < 2:
        return {}
    uniform = solvers.name_without("panel", "variation-across")
    return {"panel": {"solver": uniform, "integrator": "explicit", "step_s": 0.0}}


EFFECT = Effect(
    part="panels",
    judge=judge,
    overlay=overlay,
    needs=("panel-deformation",),
    key="panel.solver",
    saves=True,
    about=("panels",),
)
