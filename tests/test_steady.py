"""First harmonics of motions whose harmonics are known."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.studies.steady import harmonic

TIME_S = np.arange(2000) * 4e-4  # ten cycles, but not a whole number of them
SPEED = 78.5


def test_amplitude_and_phase_of_a_sine() -> None:
    amplitude = np.array([2e-3 * np.exp(0.7j), 5e-3j, 0.0])
    moved = np.real(amplitude * np.exp(1j * SPEED * TIME_S)[:, None]) + np.array([0.1, 0.0, 3.0])
    assert harmonic(TIME_S, moved, SPEED) == pytest.approx(amplitude, abs=1e-14)


def test_a_slow_swing_hardly_leaks_into_it() -> None:
    """2 mm at 29 rad/s, which decays, beside 8 mm at 78.5 rad/s: Hann's side lobes beyond the sixth
    are below 1e-3; without a window it would be 2 %."""
    moved = 8e-3 * np.cos(SPEED * TIME_S) + 2e-3 * np.exp(-TIME_S) * np.cos(29 * TIME_S)
    found = harmonic(TIME_S, moved[:, None], SPEED)[0]
    assert found == pytest.approx(8e-3, rel=1e-3)
