"""The first harmonic of a motion: the one definition of amplitude and phase in all results.

A motion x(t) of a machine with angular speed w is the sum of A cos(w t + phi), a mean place, a slow drift,
higher harmonics, and other vibrations.  A and phi follow from weighted least squares over whole
cycles.  The weight is Hann's window, which suppresses frequencies that are no multiples of w: a machine on
soft springs swings for seconds at a frequency of its own (Harris, Proc. IEEE 66, 1978, 51-83, doi
10.1109/PROC.1978.10837).  Multiples of w are orthogonal over whole cycles and change nothing.

The interval comes from batches of whole cycles (``estimate.py``).  Each batch has a phasor of its own, of
which only the component along the mean phasor counts.  Noise therefore widens the interval and does not
raise the amplitude, as it would raise a mean of the cycles' amplitudes or half a range.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.figures.estimate import Estimate
from orchestrator.figures.machine import Orbit
from orchestrator.output.cycles import count_whole_cycles, within
from orchestrator.output.results.estimate import Interval, IntervalOf, batch_count, chance
from orchestrator.ports import Array

Phasors = npt.NDArray[Any]  # complex
FEWEST_CYCLES_FOR_HANN = 2  # over a single cycle, the window would let the second harmonic in
FEWEST_CYCLES_FOR_CHANGE = 4  # two in each half
HANN_WIDENS = 1.5**0.5  # the standard error of a mean that is weighted by Hann's window


@dataclass(frozen=True)
class Harmonic:
    """The first harmonic of a motion over whole cycles, by component.

    The motion is Re(``phasor`` exp(i w t)): its amplitude is the size of the phasor, and its phase is the
    angle in cos(w t + phase), where t is the time of the run.  ``intervals`` are those of the amplitudes,
    from ``batches``.  ``other`` is half the range of the motion without mean place, drift and first
    harmonic.  ``change`` is the change of the phasor from the first half of the cycles to the second, or None
    with fewer than four cycles.
    """

    phasor: Phasors
    intervals: tuple[Interval, ...]
    batches: int
    other: Array
    change: Phasors | None

    @property
    def amplitude(self) -> Array:
        """The amplitudes by component."""
        return np.abs(self.phasor)

    @property
    def half_width(self) -> Array | None:
        """The half widths of the intervals by component, NaN where one is unknown; None if all are."""
        widths = np.array([one.half_width for one in self.intervals], dtype=float)
        return None if np.isnan(widths).all() else widths

    def estimate(self, component: int) -> Estimate:
        """Return the amplitude of one component with its interval."""
        one = self.intervals[component]
        return Estimate(
            float(self.amplitude[component]),
            one.half_width,
            self.batches,
            standard_error=one.standard_error,
            reason=one.reason,
        )

    def orbit(self) -> Orbit:
        """Return a point's motion in m along x, y and z, with its ellipse in the x-z plane."""
        major_m, minor_m, tilt_rad = ellipse(self.phasor[0], self.phasor[2])
        return Orbit(
            amplitude_m=self.amplitude,
            half_width_m=self.half_width,
            phase_rad=np.angle(self.phasor),
            major_m=major_m,
            minor_m=minor_m,
            tilt_deg=float(np.degrees(tilt_rad)),
            other_m=self.other,
        )


def first_harmonic(
    time_s: Array,
    values: Array,
    cycle_s: float,
    start_s: float = 0.0,
    end_s: float | None = None,
    interval_of: IntervalOf = chance,
) -> Harmonic:
    """Return the first harmonic of ``values`` (rows, components) at ``time_s`` (rows,).

    It covers the last whole cycles between ``start_s`` and ``end_s``, which is by default the time of the
    last row.  Raises ValueError if there is no whole cycle, or fewer than four rows for each cycle.
    """
    end_s = float(time_s[-1]) if end_s is None else end_s
    cycles = count_whole_cycles(end_s - start_s, cycle_s)
    if cycles == 0:
        raise ValueError(f"{end_s - start_s:g} s are shorter than a cycle of {cycle_s:g} s")
    start_s = end_s - cycles * cycle_s
    inside = within(time_s, start_s, end_s, cycle_s)
    time_s, values = time_s[inside], np.asarray(values, float)[inside]
    if len(time_s) < 4 * cycles:
        raise ValueError(f"{len(time_s)} rows are too few for {cycles} cycles")
    phasor, slow = _fit(time_s, values, start_s, end_s, cycle_s)
    speed_rad_per_s = 2 * np.pi / cycle_s
    wave = np.real(phasor * np.exp(1j * speed_rad_per_s * time_s)[:, None])
    other = np.ptp(values - slow - wave, axis=0) / 2
    batches = batch_count(cycles)
    along = _along(time_s, values - slow, phasor, end_s, cycle_s, cycles // batches, batches)
    intervals = tuple(map(interval_of, along.T))
    if interval_of is chance:
        intervals = tuple(one.times(HANN_WIDENS) for one in intervals)
    change = None
    if cycles >= FEWEST_CYCLES_FOR_CHANGE:
        half_s = cycles // 2 * cycle_s
        early, late = (
            _fit(time_s, values, begin_s, begin_s + half_s, cycle_s)[0]
            for begin_s in (start_s, end_s - half_s)
        )
        change = late - early
    return Harmonic(phasor, intervals, batches, other, change)


def drift(harmonics: list[Harmonic]) -> float | None:
    """Return the largest change from the first half of the cycles to the second, over the largest amplitude.

    Return None if there are too few cycles, or if nothing moves.
    """
    changes = [np.abs(each.change).max() for each in harmonics if each.change is not None]
    largest = max((each.amplitude.max() for each in harmonics), default=0.0)
    return float(max(changes) / largest) if changes and largest > 0 else None


def ellipse(x: complex, z: complex) -> tuple[float, float, float]:
    """Return the half axes and the tilt of the ellipse (Re x e^{iwt}, Re z e^{iwt}).

    The ellipse is the sum of two circles that turn against each other, with the radii |x + iz| / 2 and
    |x - iz| / 2.  The minor half axis is positive if the point turns from x towards z.  The tilt, in rad,
    turns the long axis from x towards z, and lies in [-pi/2, pi/2).
    """
    forward, backward = (x + 1j * z) / 2, (np.conj(x) + 1j * np.conj(z)) / 2
    tilt = (np.angle(forward) + np.angle(backward)) / 2 if abs(forward * backward) else 0.0
    tilt = float((tilt + np.pi / 2) % np.pi - np.pi / 2)
    return float(abs(forward) + abs(backward)), float(abs(forward) - abs(backward)), tilt


def _fit(time_s: Array, values: Array, start_s: float, end_s: float, cycle_s: float) -> tuple[Phasors, Array]:
    """Return the phasors (components,) of the whole cycles between two times, and the slow motion.

    The slow motion (rows, components) is the mean place with its drift.
    """
    inside = within(time_s, start_s, end_s, cycle_s)
    time_s, values = time_s[inside], values[inside]
    speed_rad_per_s = 2 * np.pi / cycle_s
    phase = speed_rad_per_s * time_s
    slow = np.column_stack([np.ones_like(phase), (time_s - time_s.mean()) * speed_rad_per_s])
    terms = np.column_stack([np.cos(phase), -np.sin(phase), slow])
    weight = np.ones(len(time_s))
    if count_whole_cycles(end_s - start_s, cycle_s) >= FEWEST_CYCLES_FOR_HANN:
        weight = np.sin(np.pi * (time_s - start_s) / (end_s - start_s)) ** 2
    root = np.sqrt(weight)[:, None]
    fitted = np.linalg.lstsq(root * terms, root * values, rcond=None)[0]
    return fitted[0] + 1j * fitted[1], slow @ fitted[2:]


def _along(
    time_s: Array, moved: Array, phasor: Phasors, end_s: float, cycle_s: float, length: int, batches: int
) -> Array:
    """Return the phasors' components along ``phasor`` (batches, components) of batches of ``length`` cycles.

    The last batch ends at ``end_s``.
    """
    phase = 2 * np.pi / cycle_s * time_s
    terms = np.column_stack([np.cos(phase), -np.sin(phase), np.ones_like(phase)])
    lasting_s = length * cycle_s
    each = []
    for number in range(batches, 0, -1):
        start_s = end_s - number * lasting_s
        rows = within(time_s, start_s, start_s + lasting_s, cycle_s)
        fitted = np.linalg.lstsq(terms[rows], moved[rows], rcond=None)[0]
        each.append(fitted[0] + 1j * fitted[1])
    size = np.abs(phasor)
    direction = np.divide(phasor, size, out=np.ones_like(phasor), where=size > 0)
    return np.real(np.array(each) * np.conj(direction))
