"""The rotation of a machine: that of its slowest exciter or, without exciters, of its slowest drive."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.case.tables.case import Case


@dataclass(frozen=True)
class Turning:
    """The rotation of a machine, which starts at ``start_s`` and runs up for ``run_up_s`` to its speed."""

    speed_rad_per_s: float
    start_s: float
    run_up_s: float


def turning(case: Case) -> Turning | None:
    """Return the rotation of a case's machine; None if the machine has no exciters and no drives."""
    exciters = [
        Turning(exciter.speed_rad_per_s, exciter.start_s, exciter.run_up_s)
        for exciter in case.screen.exciters.values()
    ]
    drives = [
        Turning(frame.drive.speed_rad_per_s, 0.0, frame.drive.run_up_s)
        for frame in case.screen.frames.values()
        if frame.drive and frame.drive.moves
    ]
    return min(exciters or drives, key=lambda machine: machine.speed_rad_per_s, default=None)
