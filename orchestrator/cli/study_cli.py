"""The command line's ``flipflow study``: many runs, and what they say together."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.accuracy_cli import accuracy
from orchestrator.cli.console import CONSOLE, FAILED, reported_errors
from orchestrator.cli.options import CasePath, Level, Overrides
from orchestrator.cli.stability_cli import stability

study = typer.Typer(help="Many runs, and what they say together.", no_args_is_help=True)

study.command()(accuracy)
study.command()(stability)

Out = Annotated[Path | None, typer.Option("--out", help="folder of the study [default: runs/<case>-<study>]")]
Jobs = Annotated[
    int | None, typer.Option("--jobs", min=1, help="runs at a time [default: one per processor]")
]


@study.command()
def sweep(
    case: CasePath,
    vary: Annotated[
        str, typer.Option(metavar="KEY=VALUES", help="values as a,b,c or first:last:step (both ends)")
    ],
    level: Level = None,
    out: Out = None,
    jobs: Jobs = None,
    overrides: Overrides = None,
) -> None:
    """Run a case over values of one key.

    Each value has a run of its own in a folder of its own.  Called again, only what is missing is
    run.  sweep.csv has a row for each value: amplitudes of the first harmonic along (x) and normal
    to the deck (z) of frames, probes on them, and of the frames against each other, drift, how
    much they still changed, and every single number of the results with its interval.  sweep.png
    draws what has not settled open, and what is not to be trusted as a cross.
    """
    from orchestrator.output.records import run_folder
    from orchestrator.studies import sweep as sweeps
    from orchestrator.studies import sweep_table
    from orchestrator.studies.points import parsed
    from orchestrator.studies.workers import Crew

    with reported_errors():
        wanted = parsed(vary)
        folder = out or Path("runs") / f"{case.resolve().name}-{wanted.name}"
        points = sweeps.points(case, level, overrides or [], wanted, folder)
        with run_folder.study_folder(folder):
            sweeps.run(points, Crew(jobs or os.cpu_count() or 1), CONSOLE.print)
    for file in sweep_table.write(sweep_table.rows(wanted, points), wanted, folder):
        CONSOLE.print(f"written: {file}")
    if any(point.status() != "done" for point in points):
        raise typer.Exit(FAILED)


@study.command()
def paper(
    case: CasePath, level: Level = None, out: Out = None, jobs: Jobs = None, overrides: Overrides = None
) -> None:
    """Compare a case with the paper it comes from: what is printed there, ours, and the error.

    The case's paper.toml has the paper's values, their acceptance bands, and the runs they need;
    finished runs are not run again.  What the case was fitted to is marked: it proves nothing.

    Exit code 4: a run failed, or a value that was not fitted is out of its band.
    """
    from orchestrator.output.records import run_folder
    from orchestrator.studies import paper as papers
    from orchestrator.studies import sweep as sweeps
    from orchestrator.studies import sweep_table
    from orchestrator.studies.workers import Crew

    folder = out or Path("runs") / f"{case.resolve().name}-paper"
    with reported_errors():
        wanted = papers.read(case)
        found = papers.runs(wanted, case, level, overrides or [], folder)
        points = [point for sweep in found.values() for point in sweep.points]
        with run_folder.study_folder(folder):
            sweeps.run(points, Crew(jobs or os.cpu_count() or 1), CONSOLE.print)
        compared = papers.compared(wanted, found)
    if not CONSOLE.is_terminal:
        CONSOLE.width = 150  # into a file: as wide as the table
    CONSOLE.print(papers.table(wanted, compared))
    for name, runs in found.items():
        rows = sweep_table.rows(runs.vary, runs.points)
        for file in sweep_table.write(rows, runs.vary, folder / name):
            CONSOLE.print(f"written: {file}")
    CONSOLE.print(f"written: {papers.write(compared, folder)}")
    if not all(line.good or line.row.fitted for line in compared):
        raise typer.Exit(FAILED)
