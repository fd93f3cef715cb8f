"""Sine motions have the accelerations and orbits of the textbook."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.vibration import (
    STANDARD_GRAVITY_M_PER_S2,
    acceleration_m_per_s2,
    ellipse,
    orbit,
    shaking,
)

SPEED = 78.5
STEP_S = 1e-4
TIME = np.arange(0.0, 10 * 2 * np.pi / SPEED, STEP_S)
Z = np.array([0.0, 0.0, 1.0])


def test_a_sine_has_a_w_squared() -> None:
    """5 mm at 78.5 rad/s: 3.142 g; RMS by the square root of 2.  Central differences of 1e-4 s
    are short by (w h)^2 / 6 = 1e-5."""
    velocity = np.outer(0.005 * SPEED * np.cos(SPEED * TIME), Z)
    found = shaking(acceleration_m_per_s2(velocity, STEP_S)[1000:-1000], Z)
    peak = 0.005 * SPEED**2 / STANDARD_GRAVITY_M_PER_S2
    assert found.peak == pytest.approx(peak, rel=1e-3)
    assert found.peak_normal == pytest.approx(peak, rel=1e-3)
    assert found.rms_normal == pytest.approx(peak / np.sqrt(2), rel=0.02)


def test_the_normal_is_only_a_part() -> None:
    acceleration = np.tile([3.0, 0.0, 4.0], (10, 1)) * STANDARD_GRAVITY_M_PER_S2
    found = shaking(acceleration, Z)
    assert (found.peak, found.peak_normal, found.rms, found.rms_normal) == pytest.approx((5, 4, 5, 4))


@pytest.mark.parametrize(("hertz", "kept"), [(50.0, True), (2500.0, False)])
def test_the_band_ends_at_500_hz(hertz: float, kept: bool) -> None:
    w = 2 * np.pi * hertz
    velocity = np.outer(np.cos(w * TIME) / w, Z)
    size = np.abs(acceleration_m_per_s2(velocity, STEP_S)[2000:-2000]).max()
    assert size == pytest.approx(1.0, rel=1e-3) if kept else size < 2e-3


def test_steps_longer_than_the_band_are_not_filtered() -> None:
    velocity = np.outer(np.arange(50) * 2.0, Z)
    assert acceleration_m_per_s2(velocity, 1.0)[:, 2] == pytest.approx(np.full(50, 2.0))


def test_an_orbit_is_found_under_drift_and_harmonics() -> None:
    place = np.column_stack(
        [
            0.002 * np.cos(SPEED * TIME + 0.3) + 0.01 + 0.02 * TIME,
            0.0 * TIME,
            0.003 * np.cos(SPEED * TIME - 1.0) + 0.0005 * np.cos(3 * SPEED * TIME),
        ]
    )
    found = orbit(TIME, place, SPEED)
    assert found.amplitude_m == pytest.approx([0.002, 0.0, 0.003], abs=2e-6)
    assert found.phase_rad[[0, 2]] == pytest.approx([0.3, -1.0], abs=2e-3)
    assert found.other_m == pytest.approx([0.0, 0.0, 0.0005], abs=5e-6)


@pytest.mark.parametrize(
    ("x", "z", "major", "minor", "tilt_deg"),
    [
        (2.0, 0.0, 2.0, 0.0, 0.0),  # a line along x
        (1.0, 1.0, np.sqrt(2), 0.0, 45.0),  # a line
        (3.0, -1j, 3.0, 1.0, 0.0),  # cos, sin: turns from x towards z
        (3.0, 1j, 3.0, -1.0, 0.0),  # and back
        (1.0, -2j, 2.0, 1.0, 90.0),
        (1.0, -1j, 1.0, 1.0, 0.0),  # a circle
    ],
)
def test_ellipses(x: complex, z: complex, major: float, minor: float, tilt_deg: float) -> None:
    found = ellipse(x, z)
    assert found[:2] == pytest.approx((major, minor), abs=1e-12)
    if abs(major) != abs(minor):
        assert np.degrees(found[2]) % 180 == pytest.approx(tilt_deg, abs=1e-9)
