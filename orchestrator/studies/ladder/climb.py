"""Runs the rungs of a case: each once, in a process and a folder of its own, never twice.

A rung is a run of the command line, like a point of a sweep; what two ladders share is run once.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from orchestrator.case import recording_file
from orchestrator.case.file.errors import CaseError
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.preflight.check import mistakes
from orchestrator.preflight.cost import particles_at_start, predicted_s
from orchestrator.preflight.levels import LoadedCase, load
from orchestrator.studies import points as sweep
from orchestrator.studies.ladder.motion import drives
from orchestrator.studies.ladder.rungs import Rung, rungs
from orchestrator.studies.points import Point, sampled_at
from orchestrator.studies.record import record
from orchestrator.studies.workers import Crew

RECORDING = "panels.h5"


@dataclass(frozen=True)
class Wanted:
    """What a user asked for; ``duration_s`` None: the case's own."""

    case: Path
    level: str | None
    sets: tuple[str, ...]
    ladders: tuple[str, ...]
    budget_s: float
    out: Path
    jobs: int


@dataclass(frozen=True)
class Step:
    """A rung with its run, or with the reason why it has none."""

    rung: Rung
    point: Point | None
    predicted_s: float = 0.0
    omitted: str = ""

    @property
    def done(self) -> bool:
        return self.point is not None and self.point.status() == "done"


def climbed(wanted: Wanted, say: Callable[[str], None]) -> list[Step]:
    """All steps, with the runs done that could be.  Raises CaseError for a case that is wrong as
    it is, and FolderUnusable."""
    base = load(wanted.case, wanted.level, wanted.sets)
    if wrong := mistakes(base):
        raise CaseError(wrong)
    common = (*wanted.sets, *sampled_at(base.case.coupling.sync_interval_s))
    steps = [
        _step(wanted, common, rung, base) for ladder in wanted.ladders for rung in rungs(base.case, ladder)
    ]
    steps = _shared(steps)
    for step in steps:
        what = step.omitted or f"predicted {step.predicted_s:.0f} s of one processor"
        say(f"{step.rung.ladder}, {step.rung.name}: {what}")
    _run(steps, wanted, say)
    second = [_made(wanted, common, step, steps, base) if _waits(step) else step for step in steps]
    _run([step for step in _shared(second) if step.rung.needs], wanted, say)
    return _shared(second)


def _waits(step: Step) -> bool:
    return bool(step.rung.needs) and not step.omitted


def _step(wanted: Wanted, common: Sequence[str], rung: Rung, base: LoadedCase) -> Step:
    """Checked, and within the budget."""
    if rung.needs:
        return Step(rung, None, predicted_s(base.case, 0))
    folder = wanted.out / f"{rung.ladder}-{rung.name}".replace(" ", "-")
    try:
        point = sweep.point(wanted.case, wanted.level, [*common, *rung.sets], rung.name, folder)
    except CaseError as error:
        return Step(rung, None, omitted=str(error.mistakes[0]))
    cost_s = predicted_s(point.loaded.case, particles_at_start(point.loaded.case))
    if cost_s > wanted.budget_s:
        why = f"predicted {cost_s:.0f} s, more than --budget {wanted.budget_s:g}"
        return Step(rung, None, cost_s, why)
    return Step(rung, point, cost_s)


def _shared(steps: Sequence[Step]) -> list[Step]:
    """Steps whose cases are the same share the first one's run."""
    first: dict[str, Point] = {}
    found = []
    for step in steps:
        if step.point is not None:
            key = json.dumps(resolved_case(step.point.loaded), sort_keys=True, default=str)
            step = replace(step, point=first.setdefault(key, step.point))
        found.append(step)
    return found


def _run(steps: Sequence[Step], wanted: Wanted, say: Callable[[str], None]) -> None:
    once = {step.point.folder: step.point for step in steps if step.point is not None}
    for line in sweep.run_points(list(once.values()), Crew(wanted.jobs)):
        say(line)


def _made(wanted: Wanted, common: Sequence[str], step: Step, steps: Sequence[Step], base: LoadedCase) -> Step:
    """A step that needs something from a run, with it; the source is named beside it."""
    source = source_of(steps)
    if source is None:
        return replace(step, omitted="no run to make it from was done")
    try:
        if step.rung.needs == "recording":
            file = wanted.out / RECORDING
            recording_file.write(file, record(source.folder, None).file)
            more = [f"panel.recording={file.resolve()}"]
        else:
            more = list(drives(source.folder))
    except CaseError as error:
        return replace(step, omitted=str(error.mistakes[0]))
    # by another name where it comes from another run
    name = f"{step.rung.name} from {source.folder.name}"
    rung = replace(step.rung, name=name, needs="", sets=(*step.rung.sets, *more))
    made = _step(wanted, common, rung, base)
    return replace(made, rung=replace(step.rung, sets=rung.sets))


def source_of(steps: Sequence[Step]) -> Point | None:
    """What is recorded, of panels and frames: the default sheet if it was run, else the highest
    that was."""
    done = [step for step in steps if step.done and step.point is not None]
    names = ("sheet", "exudyn", "strip", "sheet coarse", "sheet fine", "as it is", "two-mass")
    ordered = sorted(
        (step for step in done if step.rung.name in names), key=lambda step: names.index(step.rung.name)
    )
    return next(_points(ordered), None)


def _points(steps: Sequence[Step]) -> Iterator[Point]:
    return (step.point for step in steps if step.point is not None)
