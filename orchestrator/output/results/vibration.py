"""Accelerations and orbits of recorded points, from their velocity at the sync points."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from orchestrator.ports import Array

BAND_HZ = 500.0
LARGEST_BAND = 0.9  # of half the rows' rate: up to there a filter can be made
STANDARD_GRAVITY_M_PER_S2 = 9.80665


@dataclass(frozen=True)
class Shaking:
    """Accelerations in g: of the whole vector and of its part along a direction."""

    peak: float
    rms: float
    peak_normal: float
    rms_normal: float


@dataclass(frozen=True)
class Orbit:
    """First harmonic of a motion: x(t) = amplitude * cos(speed t + phase), per component (3,),
    and the ellipse that it draws in the plane of the first and third component.

    ``tilt_rad`` turns the long axis from the first component towards the third, in
    (-pi/2, pi/2]; ``other_m`` (3,) is half the range of all that the first harmonic leaves.
    """

    amplitude_m: Array
    phase_rad: Array
    major_m: float
    minor_m: float
    tilt_rad: float
    other_m: Array


def acceleration_m_per_s2(velocity_m_per_s: Array, step_s: float) -> Array:
    """(n, 3) from (n, 3) at equal steps: band-limited to ``BAND_HZ`` by a Butterworth filter of
    fourth order run to and fro (no phase shift), then central differences."""
    limit = 2 * BAND_HZ * step_s
    if limit < LARGEST_BAND:  # else the steps themselves are the limit
        velocity_m_per_s = sosfiltfilt(butter(4, limit, output="sos"), velocity_m_per_s, axis=0)
    return np.asarray(np.gradient(velocity_m_per_s, step_s, axis=0))


def band_hz(step_s: float) -> float:
    """Up to which frequency ``acceleration_m_per_s2`` tells something."""
    return BAND_HZ if 2 * BAND_HZ * step_s < LARGEST_BAND else 0.5 / step_s


def shaking(acceleration_m_per_s2: Array, normal: Array) -> Shaking:
    """Of (n, 3) in world axes; ``normal`` (3,) is a unit vector."""
    size = np.linalg.norm(acceleration_m_per_s2, axis=1) / STANDARD_GRAVITY_M_PER_S2
    along = acceleration_m_per_s2 @ normal / STANDARD_GRAVITY_M_PER_S2
    return Shaking(float(size.max()), _rms(size), float(np.abs(along).max()), _rms(along))


def orbit(time_s: Array, place_m: Array, speed_rad_per_s: float) -> Orbit:
    """Least squares over (n,) times and (n, 3) places, which should span whole cycles."""
    phase = speed_rad_per_s * time_s
    terms = np.column_stack([np.cos(phase), np.sin(phase), np.ones_like(phase), time_s - time_s[0]])
    fit = np.linalg.lstsq(terms, place_m, rcond=None)[0]
    phasor = fit[0] - 1j * fit[1]
    rest = place_m - terms @ fit
    major, minor, tilt = ellipse(phasor[0], phasor[2])
    other = (rest.max(axis=0) - rest.min(axis=0)) / 2
    return Orbit(np.abs(phasor), np.angle(phasor), major, minor, tilt, other)


def ellipse(x: complex, z: complex) -> tuple[float, float, float]:
    """Half axes and tilt of the path (Re x e^{iwt}, Re z e^{iwt}).

    It is the sum of two circles turning against each other, with radii |x + iz| / 2 and
    |x - iz| / 2; ``minor`` is positive when the point turns from x towards z.
    """
    forward, backward = (x + 1j * z) / 2, (np.conj(x) + 1j * np.conj(z)) / 2
    tilt = (np.angle(forward) + np.angle(backward)) / 2 if abs(forward * backward) else 0.0
    tilt = float((tilt + np.pi / 2) % np.pi - np.pi / 2)
    return abs(forward) + abs(backward), abs(forward) - abs(backward), tilt


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
