"""Measured curves of bushings, which matter where stiffness or loss changes over the measured points."""

from __future__ import annotations

from orchestrator.case.file.bushing_curve import curve_points
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict, compare, overlay_of_rows
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the range of the measured stiffness; None without measured points."""
    bushings = scene.case.screen.bushings
    number, cost = "change of the stiffness over the measured points", "elements in each of the frames' steps"
    changes = {
        name: max(stiffness) / min(stiffness) - 1
        for name, bushing in bushings.items()
        for curve in bushing.curves
        if (stiffness := [point[2] for point in curve_points(curve)])
    }
    if not changes:
        return None
    name = max(changes, key=lambda name: changes[name])
    return compare(number, changes[name], f"of {name}", cost=cost)


def overlay(case: Case) -> Overlay:
    """Return the overlay that takes the curves out of all bushings that have one."""
    curved = [name for name, row in case.screen.bushings.items() if row.curves]
    return overlay_of_rows("screen.bushings", curved, {"curves": None})


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: any(row.curves for row in case.screen.bushings.values()),
    overlay=overlay,
    needs=("frame-dynamics",),
    key="screen.bushings.<name>.curves",
)
