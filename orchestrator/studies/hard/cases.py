"""The hard cases and their runs: points of a sweep, which are never run twice."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.tables.case import Case
from orchestrator.preflight.check import mistakes
from orchestrator.preflight.levels import load
from orchestrator.preflight.stability.choice import settled_card
from orchestrator.studies import sweep
from orchestrator.studies.hard.expected import FILE, Expected, Runs, read
from orchestrator.studies.hard.outcome import outcome
from orchestrator.studies.sweep import Point

QUIET = ("output.pictures=false",)


@dataclass(frozen=True)
class HardCase:
    """A case with what is expected of it, and its runs by name."""

    name: str
    folder: Path
    expected: Expected
    points: dict[str, Point]


def found(folder: Path, out: Path) -> list[HardCase]:
    """Every case of a folder with ``expected.toml``, in the order of their numbers; nothing is run.
    Raises CaseError if one of them is wrong or there is none."""
    cases = [hard_case(file.parent, out) for file in folder.glob(f"*/{FILE}")]
    if not cases:
        raise CaseError([CaseProblem((), f"has no case with {FILE}", file=str(folder))])
    return sorted(cases, key=lambda case: case.expected.number)


def hard_case(folder: Path, out: Path) -> HardCase:
    """Raises CaseError."""
    expected = read(folder)
    points = {name: _point(folder, name, wanted, out / folder.name) for name, wanted in expected.runs.items()}
    return HardCase(folder.name, folder, expected, points)


def _point(case: Path, name: str, wanted: Runs, out: Path) -> Point:
    sets = [*QUIET, *wanted.sets]
    if wanted.of_limit is not None:
        sets += interval_of(case, sets, wanted.of_limit)
    return point(case, name, sets, out / name, wanted.resume_at_s)


def interval_of(case: Path, sets: Sequence[str], multiple: float) -> list[str]:
    """``--set`` for a sync interval of so many times the largest safe one.  Raises CaseError where
    nothing limits it."""
    loaded = load(case, None, sets)
    if wrong := mistakes(loaded):
        raise CaseError(wrong)
    interval_s = multiple * safe_s(loaded.case)
    if not 0 < interval_s < loaded.case.duration_s:
        what = f"{multiple:g} times the largest safe sync interval is {interval_s:g} s"
        raise CaseError([CaseProblem(("coupling", "sync_interval_s"), what, file=str(case))])
    return [f"coupling.sync_interval_s={interval_s:.3g}"]


def safe_s(case: Case) -> float:
    """The largest safe sync interval, whatever the case takes."""
    return settled_card(case).safe_s


def point(
    case: Path, name: str, sets: Sequence[str], folder: Path, resume_at_s: float | None = None
) -> Point:
    """A checked run of a case at its default level.  Raises CaseError."""
    ready = replace(sweep.point(case, None, sets, name, folder), ended=ended)
    if resume_at_s is None:
        return ready
    first = (*ready.words, "--set", f"duration_s={resume_at_s!r}")
    end = f"duration_s={ready.loaded.case.duration_s!r}"
    then = ("resume", str(folder.resolve()), "--set", end)
    return replace(ready, words=first, then=then, ended=resumed)


def ended(folder: Path) -> bool:
    """Also of a run that was stopped: that it was is what it found out."""
    return outcome(folder) != "not run"


def resumed(folder: Path) -> bool:
    """Ended, and not at the first of two ends."""
    log = folder / "provenance.json"
    return ended(folder) and "resumed" in log.read_text(encoding="utf-8")


def all_points(cases: Sequence[HardCase]) -> Iterator[Point]:
    for case in cases:
        yield from case.points.values()
