"""Results of a machine whose motor lags behind: cycles of its shaft, not of its named speed.

One frame on springs that are alike in its plane, without weight: its circular steady motion loads the shaft
evenly.  Speeds and amplitudes follow from the balance of torques (``tests/frames/test_motor.py``).
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.output.results.frame_drives import drives
from tests.frames.test_motor import (
    MOTOR,
    DAMPING_N_s_per_m,
    MASS_kg,
    MOMENT_kg_m,
    STIFFNESS_N_per_m,
    steady_speeds,
)
from tests.runs.outside import flipflow, summary

NAMED_RAD_PER_S = 80.0
STRONG = replace(MOTOR, rated_power_W=6e3, rated_slip=0.2)  # lags by 3.5 per cent
WEAK = replace(MOTOR, rated_power_W=4e3)


def results(folder: Path, rated_power_W: float, rated_slip: float) -> dict[str, Any]:
    """Return the results of 4 s, of whose start nothing is left in the second half."""
    (folder / "case.toml").write_text(f"""
title = "a motor turns a frame"
duration_s = 4.0
gravity_m_per_s2 = [0.0, 0.0, 0.0]
domain_m = [[-2.0, -2.0, -2.0], [2.0, 2.0, 2.0]]

[materials]

[screen.frames.driving]
mass_kg = {MASS_kg}
inertia_kg_m2 = [50.0, 200.0, 200.0]
center_of_mass_m = [0.0, 0.0, 0.0]

[screen.bushings.isolation]
between = ["ground", "driving"]
positions_m = [[-0.9, -0.4, 0.0], [0.9, -0.4, 0.0], [-0.9, 0.4, 0.0], [0.9, 0.4, 0.0]]
stiffness_N_per_m = {[STIFFNESS_N_per_m / 4] * 3}
damping_N_s_per_m = {[DAMPING_N_s_per_m / 4] * 3}

[screen.exciters.shaft]
frame = "driving"
position_m = [0.0, 0.0, 0.0]
mass_moment_kg_m = {MOMENT_kg_m}
speed_rad_per_s = {NAMED_RAD_PER_S}

[screen.exciters.shaft.motor]
rated_power_W = {rated_power_W}
synchronous_speed_rad_per_s = {MOTOR.synchronous_rad_per_s}
rated_slip = {rated_slip}
breakdown_ratio = {MOTOR.breakdown_ratio}
moment_of_inertia_kg_m2 = {MOTOR.inertia_kg_m2}
bearing_loss_N_m_s = {MOTOR.bearing_N_m_s}

[frames]
solver = "planar"

[coupling]
sync_interval_s = 2.5e-3
""")
    done = flipflow("run", str(folder), "--out", str(folder / "run"))
    assert done.returncode == 0, done.stderr
    table: dict[str, Any] = summary(folder / "run")["results"]
    return table


def test_the_first_harmonic_is_that_of_the_shaft(tmp_path: Path) -> None:
    """Stroke and speed within 0.1 %: the window holds no whole number of the shaft's turns, and the speed
    found is that of a straight line through its angles."""
    (speed_rad_per_s,) = steady_speeds(STRONG)
    assert speed_rad_per_s < 0.97 * NAMED_RAD_PER_S
    motion = results(tmp_path, STRONG.rated_power_W, STRONG.rated_slip)["motion"]
    assert motion["shafts_rad_per_s"]["shaft"] == pytest.approx(speed_rad_per_s, rel=1e-3)
    assert motion["speed_rad_per_s"] == pytest.approx(speed_rad_per_s, rel=1e-3)
    dynamic = STIFFNESS_N_per_m - MASS_kg * speed_rad_per_s**2 + 1j * DAMPING_N_s_per_m * speed_rad_per_s
    amplitude_m = MOMENT_kg_m * speed_rad_per_s**2 / np.abs(dynamic)
    x_m, _, z_m = motion["frames"]["driving"]["amplitude_m"]
    assert [x_m, z_m] == pytest.approx([amplitude_m] * 2, rel=1e-3)
    assert max(motion["frames"]["driving"]["half_width_m"]) < 1e-3 * amplitude_m
    assert motion["is_settled"], motion["reason"]
    (drive,) = drives(tmp_path / "run")
    match = re.search(r"speed_rad_per_s = ([0-9.]+),", drive)
    assert match is not None
    assert float(match[1]) == pytest.approx(speed_rad_per_s, rel=1e-3)


def test_a_motor_that_does_not_come_up_is_said(tmp_path: Path) -> None:
    """The motor stays at the resonance, at less than half of its speed."""
    caught_rad_per_s = steady_speeds(WEAK)[0]
    motion = results(tmp_path, WEAK.rated_power_W, WEAK.rated_slip)["motion"]
    assert motion["shafts_rad_per_s"]["shaft"] == pytest.approx(caught_rad_per_s, rel=0.01)
    assert not motion["is_settled"]
    assert "the motor of shaft turns its shaft at" in motion["reason"]
    assert "too weak" in motion["reason"]
    log = (tmp_path / "run" / "run.log").read_text()
    assert f"The machine has not settled: {motion['reason']}." in log, "what the console says, too"
