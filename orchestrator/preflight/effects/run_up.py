"""Run-up of the machine, which in N cycles increases accelerations by up to the share 1/(2 N)."""

from __future__ import annotations

import math
from typing import Any

from orchestrator.case.tables.case import Case
from orchestrator.case.tables.frames import Drive
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict
from orchestrator.preflight.scene.scene import Scene

CYCLES = 5.0


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the cycles of the run-up; None if nothing shakes."""
    cycles = _cycles(scene.case)
    if cycles is None:
        return None
    why = "the machine starts with a jump"
    if cycles:
        higher = f"at the start accelerations are up to {1 / (2 * cycles):.0%} higher"
        why = f"{higher}; whether its end is another without a run-up, only a run tells"
    return Verdict(
        number="cycles of the run-up",
        value=cycles,
        threshold=f"{CYCLES:g} (below it a tenth more acceleration)",
        matters=None if cycles else True,
        why=why,
        cost="that much machine time",
    )


def _drives(case: Case) -> dict[str, Drive]:
    """Return the drives, by frame, that could start at full speed: their frames would not jump."""
    drives = {name: frame.drive for name, frame in case.screen.frames.items() if frame.drive}
    return {name: drive for name, drive in drives.items() if not drive.jumps}


def _cycles(case: Case) -> float | None:
    """Return the smallest number of cycles in a run-up of an exciter or a drive; None without any."""
    cycles = [row.run_up_s * row.speed_rad_per_s / (2 * math.pi) for row in _drives(case).values()]
    cycles += [row.run_up_s * row.speed_rad_per_s / (2 * math.pi) for row in case.screen.exciters.values()]
    return min(cycles, default=None)


def overlay(case: Case) -> Overlay:
    """Return the overlay that starts exciters and drives at full speed; empty without any."""
    tables: dict[str, Any] = {}
    if case.screen.exciters:
        tables["exciters"] = {name: {"run_up_s": 0.0} for name in case.screen.exciters}
    if drives := _drives(case):
        tables["frames"] = {name: {"drive": {"run_up_s": 0.0}} for name in drives}
    return {"screen": tables} if tables else {}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: bool(_cycles(case)),
    overlay=overlay,
    key="run_up_s of exciters and drives",
)
