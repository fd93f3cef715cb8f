"""What is compared with a paper: functions of runs, by name, all in SI."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from orchestrator.output.results.harmonics import find_orbits, why_no_orbits
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.studies.points import Vary
from orchestrator.studies.sweep import Point

UNITS = {"mm": 1e-3, "m": 1.0, "rad/s": 1.0, "%": 0.01, "m/s": 1.0, "1": 1.0}
COMPONENT = {"x": 0, "y": 1, "z": 2}


class Unknown(Exception):
    """A value that these runs do not tell; the message says why."""


@dataclass(frozen=True)
class Sweep:
    """Runs over values of a key."""

    vary: Vary
    points: Sequence[Point]

    def at(self, value: str) -> Sweep:
        """The one run of this value.  Raises Unknown."""
        found = [p for p in self.points if p.value == value]
        if not found:
            raise Unknown(f"no run with {self.vary.name} = {value}")
        return Sweep(self.vary, found)

    def between(self, limits: tuple[float, float] | None) -> Sweep:
        """The runs of values in a range, in order of their values.  Those that are no numbers stay
        as they are given; with limits they raise Unknown."""
        if limits is None and not self._numbers:
            return self
        low, high = limits or (-np.inf, np.inf)
        inside = [point for point in self.points if low <= _number_in(point) <= high]
        return Sweep(self.vary, sorted(inside, key=_number_in))

    @property
    def values(self) -> Array:
        """Raises Unknown if they are no numbers."""
        return np.array([_number_in(point) for point in self.points])

    @property
    def _numbers(self) -> bool:
        try:
            return bool(np.isfinite(self.values).all())
        except Unknown:
            return False


def _number_in(point: Point) -> float:
    try:
        return float(point.value)
    except ValueError:
        raise Unknown(f'"{point.value}" is no number') from None


def _done(runs: Sweep) -> Sequence[Point]:
    for point in runs.points:
        if point.status() != "done":
            raise Unknown(f"{point.folder.name}: {point.status()}")
    return runs.points


def _amplitudes(runs: Sweep, name: str, axis: str) -> Array:
    found = []
    for point in _done(runs):
        results = RunReader(point.folder).results
        if not (orbits := find_orbits(results)):
            raise Unknown(f"{point.folder.name}: {why_no_orbits(results)}")
        if name not in orbits:
            raise Unknown(f'no point "{name}"; there are {", ".join(orbits)}')
        found.append(orbits[name]["amplitude_m"][COMPONENT[axis]])
    return np.array(found)


def amplitude(runs: Sweep, point: str, axis: str) -> float:
    """First harmonic, in m, of a frame, a probe on it, or two frames against each other."""
    return float(_amplitudes(runs, point, axis)[0])


def growth(runs: Sweep, point: str, axis: str) -> float:
    """Of the amplitude from the first value of the sweep to the last, relative."""
    found = _amplitudes(runs, point, axis)
    return float(found[-1] / found[0] - 1)


def lowest_at(runs: Sweep, point: str, axis: str) -> float:
    """The value of the sweep at which the amplitude is least, by a parabola through the least and
    its neighbours."""
    found, values = _amplitudes(runs, point, axis), runs.values
    least = int(np.clip(found.argmin(), 1, len(found) - 2))
    near = slice(least - 1, least + 2)
    a, b, _ = np.polyfit(values[near], found[near], 2)
    return float(-b / (2 * a))


def arch(runs: Sweep, point: str, axis: str) -> float:
    """Of a panel: the largest distance of its middle line from the straight line between its ends
    at the sync points of the cycles that end in the run's second half, in m, on either side."""
    (one,) = _done(runs)
    with RunReader(one.folder) as run:
        if not run.has(f"panel_cycles/{point}"):
            raise Unknown(f'no panel "{point}"')
        time_s, sag_m = (run.read(f"panel_cycles/{point}/{name}") for name in ("time_s", "sag_most_m"))
        return float(sag_m[time_s > 0.5 * time_s[-1]].max())


def result(runs: Sweep, point: str, axis: str) -> float:
    """A number of the results in a run's summary, by its keys with dots; percents as shares."""
    return float(_results(runs, point)[0])


def effect(runs: Sweep, point: str, axis: str) -> float:
    """Difference of such a number, of the last value of the sweep from the first."""
    found = _results(runs, point)
    return float(found[-1] - found[0])


def rise(runs: Sweep, point: str, axis: str) -> float:
    """The largest from one entry of a list of such numbers (``*`` in the keys) to the next:
    negative if they fall all the way."""
    (run,) = _done(runs)
    results = RunReader(run.folder).results
    before, _, after = point.partition(".*.")
    count = len(_inner(results, before))
    return float(np.diff([_number(run, f"{before}.{n}.{after}") for n in range(count)]).max())


def _results(runs: Sweep, path: str) -> Array:
    return np.array([_number(point, path) for point in _done(runs)])


def _number(run: Point, path: str) -> float:
    inner = _inner(RunReader(run.folder).results, path)
    value = inner.get("value") if isinstance(inner, dict) else inner
    if value is None:
        raise Unknown(f"{run.folder.name}: {path} is not known")
    return float(value) * (0.01 if path.endswith("_percent") else 1.0)


def _inner(results: Any, path: str) -> Any:
    for word in path.split("."):
        results = results[int(word)] if isinstance(results, list) else results.get(word, {})
    return results


QUANTITIES: dict[str, Callable[[Sweep, str, str], float]] = {
    "amplitude": amplitude,
    "growth": growth,
    "lowest-at": lowest_at,
    "arch": arch,
    "result": result,
    "effect": effect,
    "rise": rise,
}
