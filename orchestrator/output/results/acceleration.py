"""Accelerations of recorded points, from their velocities."""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, sosfiltfilt

from orchestrator.ports import Array

BAND_HZ = 500.0
LARGEST_BAND = 0.9  # of half the rows' rate: up to there a filter can be made


def acceleration_m_per_s2(velocity_m_per_s: Array, step_s: float) -> Array:
    """Returns (n, 3) accelerations from (n, 3) velocities at equal steps.

    They are band-limited to ``BAND_HZ`` by a Butterworth filter of fourth order run to and fro (no
    phase shift), then differentiated by central differences.
    """
    limit = 2 * BAND_HZ * step_s
    if limit < LARGEST_BAND:  # else the steps themselves are the limit
        velocity_m_per_s = sosfiltfilt(butter(4, limit, output="sos"), velocity_m_per_s, axis=0)
    return np.asarray(np.gradient(velocity_m_per_s, step_s, axis=0))


def band_hz(step_s: float) -> float:
    """Returns up to which frequency ``acceleration_m_per_s2`` tells something."""
    return BAND_HZ if 2 * BAND_HZ * step_s < LARGEST_BAND else 0.5 / step_s


def rms(values: Array) -> float:
    """Returns the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))
