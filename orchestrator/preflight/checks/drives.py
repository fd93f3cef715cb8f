"""Frames that move as prescribed: what a drive must be, and what each solver can do."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.tables.case import Case


def driven_frames(case: Case) -> Iterator[CaseProblem]:
    """Frames that a drive moves while forces move others: they have no exciter."""
    solver = solvers.frames(case)
    if not (solver.drives and solver.moved_by_forces):
        return
    frames = case.screen.frames
    for name, exciter in case.screen.exciters.items():
        if exciter.frame in frames and frames[exciter.frame].drive is not None:
            what = f'"{exciter.frame}" has a drive, which leaves nothing to an exciter'
            yield CaseProblem(("screen", "exciters", name, "frame"), what, "take one of them out")


def start_of_drives(case: Case) -> Iterator[CaseProblem]:
    """A drive without run-up must start from the place in which its frame is drawn."""
    for name, frame in case.screen.frames.items():
        drive = frame.drive
        if drive is None or drive.run_up_s > 0:
            continue
        key: Key = ("screen", "frames", name, "drive")
        for phase, unit, size, phase_rad in (
            ("phase_rad", "m", drive.amplitude_m, drive.phase_rad),
            ("rotation_phase_rad", "rad", drive.rotation_rad, drive.rotation_phase_rad),
        ):
            jump = float(np.abs(np.multiply(size, np.sin(phase_rad))).max())
            if jump > 1e-9:
                what = f"the frame would jump by {jump:.3g} {unit} at t = 0"
                yield CaseProblem((*key, phase), what, "give run_up_s, or 0")


def sudden_drives(case: Case) -> Iterator[str]:
    """Drives without run-up that move panels' clamps at full speed from t = 0, while the panels are
    at rest."""
    for name, frame in case.screen.frames.items():
        drive = frame.drive
        held = [panel.name for panel in single_panels(case) if name in panel.frames]
        if drive is None or drive.run_up_s > 0 or not held:
            continue
        moving = np.multiply(drive.amplitude_m, np.cos(drive.phase_rad))
        turning = np.multiply(drive.rotation_rad, np.cos(drive.rotation_phase_rad))
        speeds = [
            f"{drive.speed_rad_per_s * size:.3g} {unit}"
            for size, unit in ((np.linalg.norm(moving), "m/s"), (np.linalg.norm(turning), "rad/s"))
            if size > 0
        ]
        if speeds:
            cycles_s = 2 * 2 * np.pi / drive.speed_rad_per_s
            more = f" and {len(held) - 1} more" if len(held) > 1 else ""
            yield (
                f'frame "{name}" moves at {" and ".join(speeds)} from t = 0, while panel '
                f"{held[0]}{more} on it is at rest: a blow that no machine gives; give its drive a "
                f"run_up_s, two cycles are {cycles_s:.2g} s"
            )
