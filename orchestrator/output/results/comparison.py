"""The comparison of runs: the keys in which their cases differ, and the results that differ.

The first run is the reference.  Two results with 95 % confidence intervals of half widths w1 and w2 differ by
more than chance if they are farther apart than sqrt(w1^2 + w2^2), the half width of the interval of their
difference for independent runs.  By chance alone, this is true for one result in twenty.  Results of a slice
are compared as those of the whole width.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from orchestrator.case.file.errors import CaseError, show_value
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.case.file.layers import find_changes, read_toml
from orchestrator.case.file.nested import value_at
from orchestrator.case.provenance import read_provenance
from orchestrator.output.results.tidy import OF_THE_WIDTH, Result, RunResults, doubtful, read_results

SAME, BY_CHANCE, MORE, UNKNOWN = "same", "within chance", "more than chance", "no interval"
UNIMPORTANT = {"title", "description", "default_level"}
EQUAL = 1e-12  # results with a smaller relative difference are the same
MISSING = "–"
CUT = "screening.cut_size_m"
ANGLES = {"rad", "degree"}
SCALED = "masses, rates, numbers, forces and powers are compared as those of the whole width"


@dataclass(frozen=True)
class DifferingKey:
    """A key of the case with its value in each run, as text; "–" where a run does not have it."""

    key: str
    values: tuple[str, ...]


@dataclass(frozen=True)
class ComparedResult:
    """A result that the first run and another run have, with the verdict on each run after the first.

    ``results`` has None for a run without this result, and so has ``verdicts``.
    """

    name: str
    unit: str
    results: tuple[Result | None, ...]

    @cached_property
    def verdicts(self) -> tuple[str | None, ...]:
        """The verdict on each run; None for the first run."""
        first, *others = self.results
        assert first is not None
        return (None, *(None if other is None else judge_difference(first, other) for other in others))

    @property
    def differs(self) -> bool:
        """True if a run differs from the first by more than chance, or if no interval can tell."""
        return bool({MORE, UNKNOWN} & set(self.verdicts))

    @property
    def is_short(self) -> bool:
        """True for a result with a short name."""
        return any(result is not None and result.is_short for result in self.results)

    def changes(self) -> tuple[float | None, ...]:
        """Return the difference of each run from the first over the size of the first; None if unknown.

        Angles have none, and neither has what the first run does not resolve.
        """
        first, *others = self.results
        assert first is not None
        if self.unit in ANGLES or abs(first.value) <= first.floor:
            return (None,) * len(self.results)
        differences = (None if other is None else other.value - first.value for other in others)
        return (0.0, *(None if each is None else each / abs(first.value) for each in differences))


@dataclass(frozen=True)
class Comparison:
    """A comparison of two or more runs, whose ``names`` are short and differ from each other."""

    runs: tuple[RunResults, ...]
    names: tuple[str, ...]
    keys: tuple[DifferingKey, ...]
    results: tuple[ComparedResult, ...]

    @cached_property
    def distinct(self) -> tuple[ComparedResult, ...]:
        """The results without those that have the numbers of another, as a path has those of a short name."""
        rows: dict[Any, ComparedResult] = {}
        for row in self.results:
            rows.setdefault(tuple(each and (each.value, each.half_width) for each in row.results), row)
        return tuple(rows.values())

    @property
    def doubts(self) -> list[str]:
        """The lines about runs that are not to be trusted, slices of different widths, different cuts,
        and other programs."""
        return [*doubtful(self.runs, SCALED), *_differing_cuts(self.runs), *_differing_programs(self.runs)]

    @property
    def compared(self) -> int:
        """The number of comparisons by intervals."""
        return sum(verdict in (BY_CHANCE, MORE) for row in self.distinct for verdict in row.verdicts)

    @property
    def more_than_chance(self) -> int:
        """The number of comparisons by intervals that show a difference."""
        return sum(verdict == MORE for row in self.distinct for verdict in row.verdicts)

    def as_json(self) -> Mapping[str, Any]:
        """Return the comparison as a table of lists, with an entry for each run in each list."""
        return {
            "runs": [{"folder": str(run.folder), "status": run.status} for run in self.runs],
            "keys": {row.key: list(row.values) for row in self.keys},
            "results": {
                row.name: {
                    "unit": row.unit,
                    "values": [result and result.value for result in row.results],
                    "half_widths": [result and result.half_width for result in row.results],
                    "verdicts": list(row.verdicts),
                }
                for row in self.results
            },
            "compared": self.compared,
            "more_than_chance": self.more_than_chance,
        }


def judge_difference(one: Result, other: Result) -> str:
    """Return whether two results are the same, or differ within or by more than chance.

    Values that runs do not resolve are the same; without intervals, so are values that differ by less than
    runs resolve.
    """
    difference, largest = abs(other.value - one.value), max(abs(one.value), abs(other.value))
    if largest <= one.floor or difference <= EQUAL * largest:
        return SAME
    if one.half_width is None or other.half_width is None:
        return SAME if difference <= one.floor else UNKNOWN
    return MORE if difference > math.hypot(one.half_width, other.half_width) else BY_CHANCE


def compare(folders: Sequence[Path]) -> Comparison:
    """Compare runs with the first of them.

    Raises FolderUnusable if there are fewer than two runs, if one is named twice or cannot be read, and if
    the runs have no results in common.
    """
    runs = tuple(run.of_the_whole_width() for run in read_results(folders))
    places = [run.folder.resolve() for run in runs]
    if len(set(places)) < len(places):
        raise FolderUnusable("a run is named twice; it would be compared with itself")
    if len(runs) < 2:
        raise FolderUnusable(f"{runs[0].folder}: there is nothing to compare it with; name two or more runs")
    results = tuple(_compare_results(runs))
    if not results:
        others = ", ".join(str(run.folder) for run in runs[1:])
        raise FolderUnusable(f"{runs[0].folder} has no results in common with {others}")
    return Comparison(runs, tuple(_short_names(runs)), tuple(_compare_keys(runs)), results)


def _compare_results(runs: Sequence[RunResults]) -> list[ComparedResult]:
    first, *others = (_comparable(run, runs[0]) for run in runs)
    return [
        ComparedResult(name, result.unit, (result, *(other.get(name) for other in others)))
        for name, result in first.items()
        if name not in OF_THE_WIDTH and any(name in other for other in others)
    ]


def _comparable(run: RunResults, first: RunResults) -> dict[str, Result]:
    """Return the results of a run without those that depend on the cut, if the first run has another."""
    cuts_m = [each.results[CUT].value if CUT in each.results else None for each in (run, first)]
    if cuts_m[0] == cuts_m[1]:
        return run.results
    return {name: result for name, result in run.results.items() if not result.figure.is_of_cut}


def _differing_cuts(runs: Sequence[RunResults]) -> Iterator[str]:
    """Yield a line if runs divide fine from coarse at different sizes."""
    cuts = [f"{1e3 * run.results[CUT].value:.4g} mm" if CUT in run.results else "none" for run in runs]
    if len(set(cuts)) > 1:
        yield f"the runs have different cuts ({', '.join(cuts)}): their efficiencies are not compared"


def _compare_keys(runs: Sequence[RunResults]) -> list[DifferingKey]:
    """Return the keys in which the resolved cases of the runs differ; files differ by their contents."""
    try:
        tables = [_with_checksums(read_toml(run.folder / "case.toml"), run.folder) for run in runs]
    except CaseError as error:
        raise FolderUnusable(str(error)) from None
    places = [*zip(tables, (run.folder for run in runs), strict=True)]
    keys = dict.fromkeys(key for table in tables[1:] for key in find_changes(tables[0], table))
    return [
        DifferingKey(".".join(key), tuple(_value_at(*place, key) for place in places))
        for key in keys
        if key[0] not in UNIMPORTANT
    ]


def _differing_programs(runs: Sequence[RunResults]) -> Iterator[str]:
    """Yield a line for each program of which the runs had different versions."""
    programs = [_programs(run.folder) for run in runs]
    for name in dict.fromkeys(name for each in programs for name in each):
        versions = [each.get(name) or "unknown" for each in programs]
        if len(set(versions)) > 1:
            yield f"other programs made the runs, which may change results: {name} {', '.join(versions)}"


def _programs(folder: Path) -> dict[str, str | None]:
    """Return the versions of the programs that made a run; none where its provenance cannot be read."""
    try:
        table = read_provenance(folder)
        return {"commit": table.get("commit"), **table.get("versions", {})}
    except (OSError, ValueError, AttributeError, TypeError):
        return {}


def _with_checksums(table: MutableMapping[str, Any], folder: Path) -> MutableMapping[str, Any]:
    """Return a resolved case with the beginning of its checksum beside the name of each file.

    The folder of a run has copies of all files of the case under names that are always the same.
    """
    screen = table.get("screen", {})
    surfaces = [(row, key) for row in screen.get("surfaces", {}).values() for key in ("stl", "file")]
    openings = [(row.get("apertures", {}), "file") for row in screen.get("panels", {}).values()]
    for row, key in ((table.get("bed", {}), "table"), *surfaces, *openings):
        if key in row and (file := folder / row[key]).is_file():
            with file.open("rb") as content:
                row[key] += f" (sha256 {hashlib.file_digest(content, 'sha256').hexdigest()[:12]})"
    return table


def _value_at(table: Any, folder: Path, key: Sequence[str]) -> str:
    value = value_at(table, key)
    if value is None:
        return MISSING
    text = f"{value:.10g}" if isinstance(value, float) else show_value(value)
    return text + (_origin_of_bed(folder) if key == ("bed", "table") else "")


def _origin_of_bed(folder: Path) -> str:
    """Return where the particles come from with which a run began, as words after the name of their file."""
    if not (folder / "provenance.json").is_file():
        return ""
    origin = read_provenance(folder).get("bed", {})
    if "file" not in origin:
        return ""
    time_s = origin.get("time_s")
    return f" from {origin['file']}" + ("" if time_s is None else f" at t = {time_s:g} s")


def _short_names(runs: Sequence[RunResults]) -> list[str]:
    """Return the last parts of the folders' paths, as many of them as tell all runs apart."""
    parts = [run.folder.resolve().parts for run in runs]
    longer = (["/".join(each[-count:]) for each in parts] for count in range(1, max(map(len, parts)) + 1))
    return next(names for names in longer if len(set(names)) == len(names))
