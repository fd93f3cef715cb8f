"""The case bushing-hysteresis against the closed form of a spring with a damper."""

from __future__ import annotations

import json
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.runs.outside import QUICK, flipflow, run_words

SPEED_RAD_S = 25 * np.pi  # a cycle of 80 ms, which is 200 sync intervals
AMPLITUDE_M = 0.008


@pytest.fixture(scope="module")
def history(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("bushing") / "run"
    sets = [*QUICK, f"screen.frames.plate.drive.speed_rad_per_s={SPEED_RAD_S!r}"]
    done = flipflow(*run_words("bushing-hysteresis", folder, sets))
    assert done.returncode == 0, done.stderr
    return folder / "history.h5"


@pytest.mark.parametrize(("name", "damping_N_s_per_m"), [("table", 12.5), ("rubber", 286.6)])
def test_the_loop_has_the_area_pi_c_w_x2(history: Path, name: str, damping_N_s_per_m: float) -> None:
    """0.197 J with the table's damping, 4.52 J with a loss factor of 0.1.  The rectangle rule over
    a whole cycle is exact for sines, so the tolerance is rounding."""
    with h5py.File(history) as series:
        force_N = series[f"bushings/{name}/force_N"][-200:]
        velocity_m_per_s = series["frames/plate/velocity_m_per_s"][-200:]
    lost_J = np.sum(force_N * velocity_m_per_s) * 4e-4
    assert lost_J == pytest.approx(np.pi * damping_N_s_per_m * SPEED_RAD_S * AMPLITUDE_M**2, rel=1e-9)


@pytest.mark.parametrize(("name", "loss_factor"), [("table", 0.00436), ("rubber", 0.1)])
def test_the_loop_is_as_wide_as_its_loss_factor(history: Path, name: str, loss_factor: float) -> None:
    """Force at no deformation over force at full deformation is c w / k; within the 3 % that the
    deformation moves on from one sync point to the next, 2 pi / 200."""
    with h5py.File(history) as series:
        x_m = series[f"bushings/{name}/deformation_m"][-200:, 0]
        force_N = series[f"bushings/{name}/force_N"][-200:, 0]
    assert np.ptp(x_m) / 2 == pytest.approx(AMPLITUDE_M, rel=1e-3)
    through = np.flatnonzero((x_m[:-1] < 0) & (x_m[1:] >= 0))[0]
    at_zero_N = np.interp(0.0, x_m[through : through + 2], force_N[through : through + 2])
    assert at_zero_N / (225e3 * AMPLITUDE_M) == pytest.approx(loss_factor, rel=0.03)


def test_the_power_that_is_in_no_account_is_no_number(history: Path) -> None:
    """A plate that moves as told gives its bushings 59 W, which nobody books: not a power of 0 W."""
    results = json.loads((history.parent / "summary.json").read_text())["results"]
    assert "drives_W" not in results["power"]
    assert results["missing"]["power of the drives"].startswith("the frames move as told")
