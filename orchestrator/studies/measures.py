"""Measures of criteria: numbers of runs, from their folders, and comparisons of them; all in SI."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from orchestrator.case.scalars import SCALARS, value_at
from orchestrator.coupling.ledger import share_created
from orchestrator.output.records import trust
from orchestrator.output.results.harmonics import find_orbits, why_no_orbits
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.studies.criterion import Criterion
from orchestrator.studies.points import Point, Vary, summary_of

AXES = {"": None, "x": 0, "y": 1, "z": 2, "size": -1}
TAKES: dict[str, Callable[[Array, Array], float]] = {
    "first": lambda time_s, values: float(values[0]),
    "last": lambda time_s, values: float(values[-1]),
    "mean": lambda time_s, values: float(values.mean()),
    "lowest": lambda time_s, values: float(values.min()),
    "highest": lambda time_s, values: float(values.max()),
    "range": lambda time_s, values: float(np.ptp(values)),
    "largest": lambda time_s, values: float(np.abs(values).max()),
    "impulse": lambda time_s, values: float(np.diff(time_s) @ values[1:]),  # rows are means
}


class Unknown(Exception):
    """A number that these runs do not tell; the message says why."""


@dataclass(frozen=True)
class Runs:
    """The points of one entry of ``runs``, and the key that is varied among them, if any."""

    points: tuple[Point, ...]
    vary: Vary | None = None

    def at(self, value: str) -> Runs:
        """Returns the run of this value alone.  Raises Unknown."""
        points = tuple(each for each in self.points if each.value == value)
        if not points:
            raise Unknown(f"no run with {self.vary.name if self.vary else 'value'} = {value}")
        return Runs(points, self.vary)

    def between(self, limits: tuple[float, float] | None) -> Runs:
        """Returns the runs of values in a range, in order of their values.  Values that are no
        numbers stay in the order in which they are given; with limits they raise Unknown."""
        if limits is None and not self._has_numbers:
            return self
        low, high = limits or (-np.inf, np.inf)
        inside = [each for each in self.points if low <= _number_in(each) <= high]
        return Runs(tuple(sorted(inside, key=_number_in)), self.vary)

    @property
    def values(self) -> Array:
        """The values.  Raises Unknown if they are no numbers."""
        return np.array([_number_in(each) for each in self.points])

    @property
    def _has_numbers(self) -> bool:
        try:
            return bool(np.isfinite(self.values).all())
        except Unknown:
            return False


def _number_in(point: Point) -> float:
    try:
        return float(point.value)
    except ValueError:
        raise Unknown(f'"{point.value}" is no number') from None


def evaluate(row: Criterion, runs: Mapping[str, Runs]) -> float:
    """Returns the number of a criterion, in SI units.  Raises Unknown."""
    every = runs[row.run]
    chosen = every.at(row.at) if row.at else every.between(row.between)
    if row.compare:
        return COMPARISONS[row.compare](row, chosen, runs)
    return number_of(row, chosen.points[0].folder)


def number_of(row: Criterion, run: Path) -> float:
    """Returns the number that a criterion asks of one run.  Only a run that can be trusted has
    one, unless the question is just that.  Raises Unknown."""
    state = str(summary_of(run).get("status", "missing"))
    if row.measure not in ABOUT_TRUST and state != trust.DONE:
        raise Unknown(f"{run.name}: {state}")
    return MEASURES[row.measure](row, run)


def result(row: Criterion, run: Path) -> float:
    """Returns a number of summary.json, by its keys with dots or by a result's short name; per
    cents are shares."""
    return _result(run, row.of)


def series(row: Criterion, run: Path) -> float:
    """Returns one number (``take``) of a dataset in history.h5 over a part of the time."""
    time_s, values = _series(run, row)
    low, high = row.between_s or (-np.inf, np.inf)
    inside = (low <= time_s) & (time_s <= high)
    if not inside.any():
        raise Unknown(f"{row.of} has no row between {low:g} and {high:g} s")
    return TAKES[row.take](time_s[inside], values[inside])


def amplitude(row: Criterion, run: Path) -> float:
    """Returns the first harmonic, in m, of a frame, a probe on it, or two frames against each
    other."""
    results = RunReader(run).results
    if not (orbits := find_orbits(results)):
        raise Unknown(f"{run.name}: {why_no_orbits(results)}")
    if row.of not in orbits:
        raise Unknown(f'no point "{row.of}"; there are {", ".join(orbits)}')
    return float(orbits[row.of]["amplitude_m"][AXES[row.axis or "x"]])


def arch(row: Criterion, run: Path) -> float:
    """Returns, of a panel, the largest distance of its middle line from the straight line between
    its ends in the cycles that end in the run's second half, in m, on either side."""
    time_s, sag_m = (_dataset(run, f"panel_cycles/{row.of}/{name}") for name in ("time_s", "sag_most_m"))
    return float(sag_m[time_s > 0.5 * time_s[-1]].max())


def rise(row: Criterion, run: Path) -> float:
    """Returns the largest rise from one entry of a list of results to the next (``*`` in the keys):
    negative if they fall all the way."""
    before, _, after = row.of.partition(".*.")
    values: list[float] = []
    while value_at(summary_of(run), f"{before}.{len(values)}.{after}") is not None:
        values.append(_result(run, f"{before}.{len(values)}.{after}"))
    if len(values) < 2:
        raise Unknown(f"{run.name}: {row.of} is not known")
    return float(np.diff(values).max())


def created(row: Criterion, run: Path) -> float:
    """Returns the size of the energy that the coupling created, over what was exchanged and lost."""
    return abs(share_created(summary_of(run)))


def unexplained(row: Criterion, run: Path) -> float:
    """Returns the largest size, at any output time, of stored + lost - supplied: the energy, in J,
    that came from nowhere, by the coupling or by a solver."""
    return _largest_sum_J(run, {"stored": 1.0, "lost": 1.0, "supplied": -1.0})


def kept(row: Criterion, run: Path) -> float:
    """Returns the largest size, at any output time, of stored - supplied, in J: the change of all
    energy where nothing may take any."""
    return _largest_sum_J(run, {"stored": 1.0, "supplied": -1.0})


def share_unexplained(row: Criterion, run: Path) -> float:
    """Returns ``unexplained`` over all that was supplied and lost by the end."""
    with RunReader(run) as reader:
        last_J = {name: float(reader.read(f"energy/{name}")[-1]) for name in reader.names("energy")}
    turned_over_J = sum(abs(last) for name, last in last_J.items() if name.startswith(("supplied.", "lost.")))
    return unexplained(row, run) / turned_over_J


def trusted(row: Criterion, run: Path) -> float:
    """Returns 1 for a stable run (``outcome``), 0 for one that was stopped or warns of itself."""
    return float(_known_outcome(run) == "stable")


def clear(row: Criterion, run: Path) -> float:
    """Returns 1 for a run that is stable or was stopped with a reason, 0 for one that went on to
    its end although it warns of itself."""
    return float(_known_outcome(run) != "warned")


ABOUT_TRUST = ("trusted", "clear")
MEASURES: dict[str, Callable[[Criterion, Path], float]] = {
    "result": result,
    "series": series,
    "amplitude": amplitude,
    "arch": arch,
    "rise": rise,
    "created": created,
    "unexplained": unexplained,
    "share_unexplained": share_unexplained,
    "kept": kept,
    "trusted": trusted,
    "clear": clear,
}


def growth(row: Criterion, chosen: Runs, runs: Mapping[str, Runs]) -> float:
    """Returns how much the number grows from the first value of a varied key to the last,
    relative."""
    values = _of_all(row, chosen)
    return float(values[-1] / values[0] - 1)


def change(row: Criterion, chosen: Runs, runs: Mapping[str, Runs]) -> float:
    """Returns the difference of the number of the last value of a varied key from the first."""
    values = _of_all(row, chosen)
    return float(values[-1] - values[0])


def lowest_at(row: Criterion, chosen: Runs, runs: Mapping[str, Runs]) -> float:
    """Returns the value of a varied key at which the number is least, by a parabola through the
    least and its neighbours."""
    values, keys = _of_all(row, chosen), chosen.values
    least = int(np.clip(values.argmin(), 1, len(values) - 2))
    near = slice(least - 1, least + 2)
    a, b, _ = np.polyfit(keys[near], values[near], 2)
    return float(-b / (2 * a))


def ratio(row: Criterion, chosen: Runs, runs: Mapping[str, Runs]) -> float:
    """Returns the number over that of the run ``against``, or of the part ``earlier_s``."""
    return number_of(row, chosen.points[0].folder) / _other(row, chosen, runs)


def difference(row: Criterion, chosen: Runs, runs: Mapping[str, Runs]) -> float:
    """Returns the size of the difference from the run ``against``, or the part ``earlier_s``."""
    return abs(number_of(row, chosen.points[0].folder) - _other(row, chosen, runs))


def row_by_row(row: Criterion, chosen: Runs, runs: Mapping[str, Runs]) -> float:
    """Returns the largest difference of a dataset from that of the run ``against``, row by row."""
    ours, theirs = (_dataset(each.points[0].folder, row.of) for each in (chosen, runs[row.against]))
    if ours.shape != theirs.shape:
        raise Unknown(f"{row.of} has {len(ours)} rows and {len(theirs)}")
    return float(np.abs(ours - theirs).max())


COMPARISONS: dict[str, Callable[[Criterion, Runs, Mapping[str, Runs]], float]] = {
    "growth": growth,
    "change": change,
    "lowest-at": lowest_at,
    "ratio": ratio,
    "difference": difference,
    "row-by-row": row_by_row,
}


def _of_all(row: Criterion, chosen: Runs) -> Array:
    return np.array([number_of(row, each.folder) for each in chosen.points])


def _other(row: Criterion, chosen: Runs, runs: Mapping[str, Runs]) -> float:
    if row.against:
        return number_of(row, runs[row.against].points[0].folder)
    return number_of(row.model_copy(update={"between_s": row.earlier_s}), chosen.points[0].folder)


def _result(run: Path, path: str) -> float:
    value = value_at(summary_of(run), path)
    if value is None:
        raise Unknown(f"{run.name}: {path} is not known")
    words = SCALARS[path].words if path in SCALARS else path
    return value.value * (0.01 if words.endswith(("_percent", "/ %")) else 1.0)


def _series(run: Path, row: Criterion) -> tuple[Array, Array]:
    """Returns times, and the component or size of each row."""
    group = row.of.rpartition("/")[0]
    time_s, values = _dataset(run, f"{group}/time_s"), _dataset(run, row.of)
    axis = AXES[row.axis]
    if axis is None:
        return time_s, values
    return time_s, np.linalg.norm(values, axis=-1) if axis < 0 else values[..., axis]


def _dataset(run: Path, name: str) -> Array:
    try:
        with RunReader(run) as reader:
            return np.asarray(reader.read(name), dtype=float)
    except (OSError, KeyError):
        raise Unknown(f"{run.name}: history.h5 has no {name}") from None


def _largest_sum_J(run: Path, signs: Mapping[str, float]) -> float:
    """Returns the largest size of the sum over whole accounts of the energy ledger, each with its
    sign."""
    with RunReader(run) as reader:
        accounts = [
            (name.partition(".")[0], reader.read(f"energy/{name}")) for name in reader.names("energy")
        ]
    terms = [signs[account] * values for account, values in accounts if account in signs]
    return float(np.abs(np.sum(terms, axis=0)).max())


Outcome = Literal["stable", "warned", "stopped", "not run"]
OF_THE_COUPLING = ("created_energy", "created_in_total", "growing_modes")  # of the monitor
INTERNAL_ERROR = "internal error"


def outcome(run: Path) -> Outcome:
    """Returns how a run came out.

    ``stable``: it came to its end, the monitor of the coupling had nothing to say of its energy and
    modes, and it is not doubtful; ``warned``: it came to its end, and one of them; ``stopped``: it
    ended early with a reason (exit code 4); ``not run``: interrupted, missing, or an internal error.
    """
    summary = summary_of(run)
    state, reason = str(summary.get("status")), str(summary.get("reason"))
    if state == "failed" and not reason.startswith(INTERNAL_ERROR):
        return "stopped"
    if not trust.came_to_its_end(state):
        return "not run"
    monitored = summary.get("monitor", {}).get("figures", {})
    amiss = any(monitored[key]["times"] for key in OF_THE_COUPLING if key in monitored)
    return "warned" if amiss or state == trust.DOUBTFUL else "stable"


def _known_outcome(run: Path) -> Outcome:
    known = outcome(run)
    if known == "not run":
        raise Unknown(f"{run.name}: not run")
    return known
