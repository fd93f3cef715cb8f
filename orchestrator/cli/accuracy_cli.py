"""The command line's ``flipflow study accuracy``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import CONSOLE, FAILED, refuse, reported_errors
from orchestrator.cli.options import CasePath, Level, Overrides

if TYPE_CHECKING:
    from orchestrator.studies.accuracy.points import Asked
    from orchestrator.studies.accuracy.study import Study

QUICK_VALUES, QUICK_SEEDS = 3, 1


def accuracy(
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
    workers: Annotated[
        int | None, typer.Option(min=1, help="runs at a time [default: as the machine bears]")
    ] = None,
    scheduler: Annotated[str, typer.Option(help="address of a Dask scheduler with workers elsewhere")] = "",
    dry: Annotated[bool, typer.Option("--dry", help="say what would be run, and stop")] = False,
    out: Annotated[Path | None, typer.Option("--out", help="folder [default: runs/<case>-accuracy]")] = None,
    overrides: Overrides = None,
) -> None:
    """Measure what accuracy costs: a case over the knobs that buy it.

    One knob is turned at a time; then what these propose together is run: the reference, and for
    each tolerance the cheapest settings that should meet it.  Errors are against the reference,
    costs in processor time.  Called again, only what is missing is run.  The folder gets
    accuracy.csv, .parquet, .json, pictures and accuracy.html; accuracy.json is used by
    flipflow plan.

    Exit code 4: a run failed; 2: the case is wrong.
    """
    from orchestrator.studies.accuracy.points import Asked
    from orchestrator.studies.workers import Crew, fitting

    with reported_errors():
        asked = Asked(
            case,
            level,
            (*(overrides or []), *([f"duration_s={duration!r}"] if duration else [])),
            _words("--knobs", knobs),
            QUICK_VALUES if quick else values,
            QUICK_SEEDS if quick else seeds,
            budget,
            out or Path("runs") / f"{case.resolve().name}-accuracy",
            Crew(workers or fitting(), scheduler),
            _words("--quantities", quantities),
        )
        if dry:
            _list(asked)
            return
        study = _run(asked)
    _show(study)


def _words(option: str, given: str) -> tuple[str, ...]:
    """Names that are known.  Raises CaseError."""
    from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean
    from orchestrator.studies.accuracy.knobs import KNOBS
    from orchestrator.studies.figures import DECISIVE, QUANTITIES

    known, usual = ([*KNOBS], [*KNOBS]) if option == "--knobs" else ([*QUANTITIES], [*DECISIVE])
    names = tuple(word.strip() for word in given.split(",")) if given else tuple(usual)
    for name in names:
        if name.partition("=")[0] not in known:
            raise CaseError([CaseProblem((), f'no "{name}"', did_you_mean(name, known), option)])
    return names


def _list(asked: Asked) -> None:
    """What would be run, with predictions."""
    from orchestrator.output.records.trust import AT_THE_END
    from orchestrator.studies.accuracy.measured import read
    from orchestrator.studies.accuracy.study import afford, listed

    there = listed(asked)
    measured = {name: one.processor_s for name, one in read(there.points[:2]).items()}
    for name, why in there.offer.missing.items():
        CONSOLE.print(f"not offered: {name}: {why}")
    total_s = 0.0
    for one in afford(there.points, asked, read(there.points[:2])):
        todo = [run for run in one.runs if run.status() not in (*AT_THE_END, "failed")]
        what = one.omitted or f"predicted {one.predicted_s:.0f} s each, {len(todo)} to be run"
        total_s += one.predicted_s * len(todo)
        CONSOLE.print(f"{one.name}: {what}")
    by = "by what was measured here" if measured else "good to a factor of three"
    CONSOLE.print(
        f"in all {total_s:.0f} s of processor time ({by}), {asked.crew.workers} at a time; "
        "then up to six points, each within the budget, that these propose"
    )


def _run(asked: Asked) -> Study:
    from orchestrator.output.records import run_folder
    from orchestrator.studies.accuracy.study import Unmeasured, studied

    with run_folder.study_folder(asked.out):
        try:
            return studied(asked, CONSOLE.print)
        except Unmeasured as error:
            refuse(str(error))


def _show(study: Study) -> None:
    from orchestrator.studies.accuracy import page, tables
    from orchestrator.studies.accuracy.rows import rows

    asked = study.listed.asked
    if not CONSOLE.is_terminal:
        CONSOLE.width = 150  # into a file: as wide as the table
    table = rows(study)
    CONSOLE.print(tables.as_table(study, table), soft_wrap=False)
    for row in table:
        if row.measured is None:
            CONSOLE.print(f"not compared: {row.point.label}: {row.why}")
    for line in tables.advice(table):
        CONSOLE.print(line)
    for file in [*tables.write(study, table, asked.out), *page.write(study, table, asked.out)]:
        CONSOLE.print(f"written: {file}")
    if any(row.measured is None and not row.point.omitted for row in table):
        raise typer.Exit(FAILED)
