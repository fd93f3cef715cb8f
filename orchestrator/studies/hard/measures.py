"""What is measured of a hard case's runs: numbers from a run's folder, by name, in SI."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.coupling.ledger import share_created
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.studies.hard.outcome import Outcome, outcome

if TYPE_CHECKING:
    from orchestrator.studies.hard.criterion import Criterion

Folders = Mapping[str, Path]

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


def series(folders: Folders, row: Criterion) -> float:
    """Of a dataset in history.h5, one number (``take``) over a part of the time."""
    time_s, values = _series(folders[row.run], row)
    low, high = row.between_s or (-np.inf, np.inf)
    inside = (low <= time_s) & (time_s <= high)
    if not inside.any():
        raise Unknown(f"{row.of} has no row between {low:g} and {high:g} s")
    return TAKES[row.take](time_s[inside], values[inside])


def summary(folders: Folders, row: Criterion) -> float:
    """A number of summary.json, by its keys with dots between."""
    found: Any = _summary(folders[row.run])
    for key in row.of.split("."):
        found = found.get(key) if isinstance(found, dict) else None
    if not isinstance(found, int | float):
        raise Unknown(f"summary.json has no number {row.of}")
    return float(found)


def created(folders: Folders, row: Criterion) -> float:
    """Energy that the coupling created, over what was exchanged and lost: its size."""
    found = _summary(folders[row.run])
    if "energy_ledger_J" not in found:
        raise Unknown(f"{row.run} has no energy ledger: it did not come to its end")
    return abs(share_created(found))


def unexplained(folders: Folders, row: Criterion) -> float:
    """Largest size, at any output time, of stored + lost - supplied: the energy, in J, that came
    from nowhere, by the coupling or by a solver."""
    return _largest_J(folders[row.run], {"stored": 1.0, "lost": 1.0, "supplied": -1.0})


def kept(folders: Folders, row: Criterion) -> float:
    """Largest size, at any output time, of stored - supplied, in J: the change of all energy where
    nothing may take any."""
    return _largest_J(folders[row.run], {"stored": 1.0, "supplied": -1.0})


def share_unexplained(folders: Folders, row: Criterion) -> float:
    """``unexplained`` over all that was supplied and lost by the end."""
    with RunReader(folders[row.run]) as run:
        books = {name: run.read(f"energy/{name}")[-1] for name in run.names("energy")}
    turned_over_J = sum(
        abs(value) for name, value in books.items() if name.startswith(("supplied.", "lost."))
    )
    return unexplained(folders, row) / float(turned_over_J)


def difference(folders: Folders, row: Criterion) -> float:
    """Largest difference of a dataset from that of the run ``against``, row by row."""
    one, other = (_dataset(folders[name], row.of) for name in (row.run, row.against))
    if one.shape != other.shape:
        raise Unknown(f"{row.of} has {len(one)} rows and {len(other)}")
    return float(np.abs(one - other).max())


def relative(folders: Folders, row: Criterion) -> float:
    """``series`` over that of the run ``against``."""
    other = row.model_copy(update={"run": row.against})
    return series(folders, row) / series(folders, other)


def later(folders: Folders, row: Criterion) -> float:
    """``series`` over that of the part of the time ``earlier_s``."""
    before = row.model_copy(update={"between_s": row.earlier_s})
    return series(folders, row) / series(folders, before)


def moved(folders: Folders, row: Criterion) -> float:
    """Returns the size of the difference of ``series`` from that of the part of the time
    ``earlier_s``."""
    before = row.model_copy(update={"between_s": row.earlier_s})
    return abs(series(folders, row) - series(folders, before))


def relative_summary(folders: Folders, row: Criterion) -> float:
    """``summary`` over that of the run ``against``."""
    other = row.model_copy(update={"run": row.against})
    return summary(folders, row) / summary(folders, other)


def trusted(folders: Folders, row: Criterion) -> float:
    """1 for a stable run (``outcome``), 0 for one that was stopped or warns of itself."""
    return float(_outcome(folders, row) == "stable")


def clear(folders: Folders, row: Criterion) -> float:
    """1 for a run that is stable or was stopped with a reason, 0 for one that went on to its end
    although it warns of itself."""
    return float(_outcome(folders, row) != "warned")


def _outcome(folders: Folders, row: Criterion) -> Outcome:
    found = outcome(folders[row.run])
    if found == "not run":
        raise Unknown(f"{row.run}: not run")
    return found


MEASURES: dict[str, Callable[[Folders, Criterion], float]] = {
    "series": series,
    "summary": summary,
    "created": created,
    "unexplained": unexplained,
    "share_unexplained": share_unexplained,
    "kept": kept,
    "difference": difference,
    "relative": relative,
    "relative_summary": relative_summary,
    "later": later,
    "moved": moved,
    "trusted": trusted,
    "clear": clear,
}


def _summary(folder: Path) -> dict[str, Any]:
    try:
        return RunReader(folder).summary
    except (OSError, ValueError):
        raise Unknown(f"{folder.name}: not run") from None


def _largest_J(folder: Path, signs: Mapping[str, float]) -> float:
    """Of the sum over whole books of the energy ledger, each with its sign."""
    with RunReader(folder) as run:
        books = [(name.partition(".")[0], run.read(f"energy/{name}")) for name in run.names("energy")]
    terms = [signs[book] * values for book, values in books if book in signs]
    return float(np.abs(np.sum(terms, axis=0)).max())


def _dataset(folder: Path, name: str) -> Array:
    try:
        with RunReader(folder) as run:
            return np.asarray(run.read(name), dtype=float)
    except (OSError, KeyError):
        raise Unknown(f"{folder.name}: history.h5 has no {name}") from None


def _series(folder: Path, row: Criterion) -> tuple[Array, Array]:
    """Times, and the component or size of each row."""
    group = row.of.rpartition("/")[0]
    time_s, values = _dataset(folder, f"{group}/time_s"), _dataset(folder, row.of)
    axis = AXES[row.axis]
    if axis is None:
        return time_s, values
    return time_s, np.linalg.norm(values, axis=-1) if axis < 0 else values[..., axis]
