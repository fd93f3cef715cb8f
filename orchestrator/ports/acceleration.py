"""Accelerations up to a frequency, from velocities at equal steps."""

from __future__ import annotations

import numpy as np

from orchestrator.ports.interface_records import Array

BAND_HZ = 500.0
"""The band of accelerations in all results."""
QUOTED_HZ = 100.0
"""The band in which makers and most measurements quote a mat's acceleration."""


def acceleration_m_per_s2(velocity_m_per_s: Array, step_s: float, band_Hz: float = BAND_HZ) -> Array:
    """Return the accelerations (n, ...) up to ``band_Hz`` from velocities (n, ...) at equal steps.

    What velocities exceed the straight line from the first to the last is a sum of sines, whose derivatives
    are exact whatever the step.  Each counts by the gain of a Butterworth filter of fourth order that runs
    forward and backward and so shifts no phase, 1 / (1 + (f / ``band_Hz``)^8).
    """
    steps = len(velocity_m_per_s) - 1
    along = (slice(None), *(None,) * (velocity_m_per_s.ndim - 1))  # times and frequencies, for any point
    slope_m_per_s2 = (velocity_m_per_s[-1] - velocity_m_per_s[0]) / (steps * step_s)
    line_m_per_s = velocity_m_per_s[0] + slope_m_per_s2 * step_s * np.arange(steps + 1)[along]
    over_m_per_s = velocity_m_per_s - line_m_per_s
    waves = np.fft.rfft(np.concatenate([over_m_per_s, -over_m_per_s[-2:0:-1]]), axis=0)
    hz = np.fft.rfftfreq(2 * steps, step_s)[along]
    derived = np.fft.irfft(2j * np.pi * hz / (1.0 + (hz / band_Hz) ** 8) * waves, 2 * steps, axis=0)
    return np.asarray(slope_m_per_s2 + derived[: steps + 1])


def band_hz(step_s: float, band_Hz: float = BAND_HZ) -> float:
    """Return the highest frequency that ``acceleration_m_per_s2`` shows at steps of ``step_s``."""
    return min(band_Hz, 0.5 / step_s)
