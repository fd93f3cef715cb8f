"""The machine runs up: in N cycles, that adds up to 1/(2 N) of the acceleration."""

from __future__ import annotations

import math
from typing import Any

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict
from orchestrator.preflight.scene.scene import Scene

CYCLES = 5.0


def judge(scene: Scene) -> Verdict | None:
    """None where nothing shakes."""
    cycles = _cycles(scene.case)
    if cycles is None:
        return None
    matters, why = _start(cycles)
    return Verdict(
        number="cycles of the run-up",
        value=cycles,
        threshold=f"{CYCLES:g} (below it a tenth more acceleration)",
        matters=matters,
        why=why,
        cost="that much machine time",
    )


def _cycles(case: Case) -> float | None:
    """Fewest of all exciters and drives."""
    drives = [frame.drive for frame in case.screen.frames.values() if frame.drive]
    found_rad = [row.run_up_s * row.speed_rad_per_s for row in drives]
    found_rad += [row.run_up_s * row.speed_rad_per_s for row in case.screen.exciters.values()]
    return min(found_rad) / (2 * math.pi) if found_rad else None


def _start(cycles: float) -> tuple[bool | None, str]:
    if cycles == 0:
        return True, "the machine starts with a jump"
    over = f"at the start accelerations are up to {1 / (2 * cycles):.0%} higher"
    return None, f"{over}; whether its end is another without a run-up, only a run tells"


def overlay(case: Case) -> Overlay:
    screen = case.screen
    found: dict[str, Any] = {}
    if screen.exciters:
        found["exciters"] = {name: {"run_up_s": 0.0} for name in screen.exciters}
    if driven := [name for name, frame in screen.frames.items() if frame.drive]:
        found["frames"] = {name: {"drive": {"run_up_s": 0.0}} for name in driven}
    return {"screen": found} if found else {}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: bool(_cycles(case)),
    overlay=overlay,
    key="run_up_s of exciters and drives",
)
