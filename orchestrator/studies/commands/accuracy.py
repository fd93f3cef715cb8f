"""``flipflow study accuracy``: what accuracy costs."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean
from orchestrator.output.records import trust
from orchestrator.output.records.run_folder import study_folder
from orchestrator.studies.accuracy import page, tables
from orchestrator.studies.accuracy.combinations import Asked
from orchestrator.studies.accuracy.measured import read
from orchestrator.studies.accuracy.refinement import PARAMETERS
from orchestrator.studies.accuracy.study import afford, listed, studied
from orchestrator.studies.accuracy.tables import rows
from orchestrator.studies.metrics import DECISIVE, QUANTITIES
from orchestrator.studies.options import CasePath, Level, Overrides, Scheduler, Told, Workers, crew, folder_of

QUICK_VALUES, QUICK_SEEDS = 3, 1


def command(
    case: CasePath,
    level: Level = None,
    knobs: Annotated[
        str, typer.Option(help="which, with commas; scheme=aitken+robin: only these variants [default: all]")
    ] = "",
    values: Annotated[int, typer.Option("--points", min=2, max=7, help="values of each knob")] = 4,
    seeds: Annotated[int, typer.Option(min=1, help="runs of each point, with other random numbers")] = 3,
    quick: Annotated[bool, typer.Option("--quick", help="as --points 3 --seeds 1")] = False,
    duration: Annotated[
        float | None, typer.Option(min=1e-6, help="seconds to simulate [default: the case's]")
    ] = None,
    budget: Annotated[
        float, typer.Option(min=1, help="a run predicted to take more processor s is left out")
    ] = 600.0,
    quantities: Annotated[
        str, typer.Option(help="which errors decide, with commas [default: what repeats itself]")
    ] = "",
    workers: Workers = None,
    scheduler: Scheduler = "",
    dry: Annotated[bool, typer.Option("--dry", help="say what would be run, and stop")] = False,
    out: Annotated[Path | None, typer.Option("--out", help="folder [default: runs/<case>-accuracy]")] = None,
    overrides: Overrides = None,
) -> Told:
    """Measure what accuracy costs: a case over the knobs that buy it.

    One knob is turned at a time; then what these propose together is run: the reference, and for
    each tolerance the cheapest settings that should meet it.  Errors are against the reference,
    costs in processor time.  Called again, only what is missing is run.  The folder gets
    accuracy.csv, .parquet, .json, pictures and accuracy.html; accuracy.json is used by
    flipflow plan.

    Exit code 4: a run failed; 2: the case is wrong.
    """
    asked = Asked(
        case,
        level,
        (*(overrides or []), *([f"duration_s={duration!r}"] if duration else [])),
        _names("--knobs", knobs, [*PARAMETERS], [*PARAMETERS]),
        QUICK_VALUES if quick else values,
        QUICK_SEEDS if quick else seeds,
        budget,
        folder_of(case, "accuracy", out),
        crew(workers, scheduler),
        _names("--quantities", quantities, [*QUANTITIES], DECISIVE),
    )
    if dry:
        yield from _predictions(asked)
        return True
    with study_folder(asked.out):
        study = yield from studied(asked)
    table = rows(study)
    yield tables.as_table(study, table)
    yield from (f"not compared: {row.point.label}: {row.why}" for row in table if row.measured is None)
    yield from tables.advice(table)
    yield from tables.write(study, table, asked.out)
    yield from page.write(study, table, asked.out)
    return not any(row.measured is None and not row.point.omitted for row in table)


def _names(option: str, given: str, known: list[str], usual: list[str] | tuple[str, ...]) -> tuple[str, ...]:
    """Returns names that are known, as they are given with commas.  Raises CaseError."""
    names = tuple(word.strip() for word in given.split(",")) if given else tuple(usual)
    for name in names:
        if name.partition("=")[0] not in known:
            raise CaseError([CaseProblem((), f'no "{name}"', did_you_mean(name, known), option)])
    return names


def _predictions(asked: Asked) -> Iterator[str]:
    """Yields what would be run, with predictions."""
    there = listed(asked)
    measured = read(there.points[:2])
    yield from (f"not offered: {name}: {why}" for name, why in there.offer.missing.items())
    total_s = 0.0
    for each in afford(there.points, asked, measured):
        todo = [run for run in each.runs if run.status() not in (*trust.AT_THE_END, "failed")]
        total_s += each.predicted_s * len(todo)
        what = each.omitted or f"predicted {each.predicted_s:.0f} s each, {len(todo)} to be run"
        yield f"{each.name}: {what}"
    by = "by what was measured here" if measured else "good to a factor of three"
    yield (
        f"in all {total_s:.0f} s of processor time ({by}), {asked.crew.workers} at a time; "
        "then up to six points, each within the budget, that these propose"
    )
