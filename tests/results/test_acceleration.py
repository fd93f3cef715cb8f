"""Sine motions have the accelerations of the textbook."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.machine import acceleration_m_per_s2, rms
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2

SPEED = 78.5
STEP_S = 1e-4
TIME = np.arange(0.0, 10 * 2 * np.pi / SPEED, STEP_S)
Z = np.array([0.0, 0.0, 1.0])


def test_a_sine_has_a_w_squared() -> None:
    """5 mm at 78.5 rad/s: 3.142 g; RMS by the square root of 2.  Central differences of 1e-4 s
    are short by (w h)^2 / 6 = 1e-5."""
    velocity = np.outer(0.005 * SPEED * np.cos(SPEED * TIME), Z)
    found = acceleration_m_per_s2(velocity, STEP_S)[1000:-1000, 2] / STANDARD_GRAVITY_M_PER_S2
    peak = 0.005 * SPEED**2 / STANDARD_GRAVITY_M_PER_S2
    assert np.abs(found).max() == pytest.approx(peak, rel=1e-3)
    assert rms(found) == pytest.approx(peak / np.sqrt(2), rel=0.02)


@pytest.mark.parametrize(("hertz", "kept"), [(50.0, True), (2500.0, False)])
def test_the_band_ends_at_500_hz(hertz: float, kept: bool) -> None:
    w = 2 * np.pi * hertz
    velocity = np.outer(np.cos(w * TIME) / w, Z)
    size = np.abs(acceleration_m_per_s2(velocity, STEP_S)[2000:-2000]).max()
    assert size == pytest.approx(1.0, rel=1e-3) if kept else size < 2e-3


def test_steps_longer_than_the_band_are_not_filtered() -> None:
    velocity = np.outer(np.arange(50) * 2.0, Z)
    assert acceleration_m_per_s2(velocity, 1.0)[:, 2] == pytest.approx(np.full(50, 2.0))
