"""One frame rocks as prescribed, the other floats on bushings: panels and a bed between them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.output.records.series import rotations_rad
from orchestrator.preflight.check import find_problems
from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.screen import BED, MACHINE

pytestmark = pytest.mark.solver
ROCKING = (
    "screen.frames.driving.drive={speed_rad_per_s=150, amplitude_m=[0.003, 0, 0.002], "
    "rotation_rad=[0, 0.01, 0], center_m=[0.16, 0.05, -0.02], run_up_s=0.004}"
)


@pytest.mark.parametrize("scheme", ["particles-first", "serial-staggered"])
def test_books_close_and_the_drive_is_exact(tmp_path: Path, scheme: str) -> None:
    """10 ms under a bed.  Momentum to rounding: 1e-12 of what should balance.  The drive's work
    leaves a defect of second order in the frames' step of 5e-5 s; measured 4e-9 of it."""
    loaded = load_case(tmp_path, MACHINE + BED, [ROCKING, f"coupling.scheme={scheme}"])
    assert find_problems(loaded) == []
    with opened(loaded) as run:
        start = run.machine.members.frames.pose()
        run.advance(200)
        residuals = run.momentum_residual()
        assert max(residuals.values()) < 1e-12, residuals
        energy_J = run.energy_J()
        work_J = energy_J["supplied.frames.drive"]
        assert work_J > 1.0
        assert abs(energy_J["defect.frames"]) < 2e-8 * work_J
        pose = run.machine.members.frames.pose()
        turned, moved_m = rotations_rad(pose), pose.position_m - start.position_m
        driving, driven = map(run.machine.frames.index, ("driving", "driven"))
    # the deck slopes by 15 degrees about y, about which the frame rocks
    assert turned[driving] == pytest.approx([0.0, 0.01 * np.sin(1.5), 0.0], abs=1e-14)
    slope = np.radians(15.0)
    along = np.array([np.cos(slope), 0.0, -np.sin(slope)])
    up = np.array([np.sin(slope), 0.0, np.cos(slope)])
    swing_m = np.sin(1.5) * (0.003 * along + 0.002 * up)
    assert moved_m[driving] == pytest.approx(swing_m, abs=1e-14)
    assert np.linalg.norm(moved_m[driven]) > 1e-4
    assert np.abs(turned[driven]).max() > 1e-4
