"""The command line's commands that make a run or use one."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.console import CONSOLE, refuse, reported_errors
from orchestrator.cli.options import CasePath, Level, Overrides, RunPath

Out = Annotated[
    Path | None, typer.Option("--out", help="new folder for the results [default: runs/<case>-<number>]")
]


def run(case: CasePath, level: Level = None, out: Out = None, overrides: Overrides = None) -> None:
    """Run a case.

    The case is checked first; nothing is written if it is wrong.  The folder of the run holds
    the log, time series, files for ParaView, pictures and summary.json (docs/run-folder.md).

    Ctrl-C ends the run at the next sync point with all results written, to be resumed; twice, at
    once.  Under mpirun, kill -USR1 to mpirun gives it the time that takes.
    """
    from orchestrator.cli.launch import run as launch

    raise typer.Exit(launch(case, level, out, overrides or []))


def resume(
    run: RunPath,
    overrides: Overrides = None,
    save: Annotated[
        int | None, typer.Option("--save", min=0, help="sync point of the checkpoint [default: the last]")
    ] = None,
) -> None:
    """Go on with a run from its last checkpoint.

    Runs are saved every now and then ([checkpoint] in a case), at their end, and by Ctrl-C.  What goes
    on is, bit for bit, the run that never stopped; on as many processes as it was saved.  It may
    be given a later end (--set duration_s=...) and other output; any other change is refused.
    """
    from orchestrator.cli.resume import resume as go_on

    raise typer.Exit(go_on(run, overrides or [], save))


def report(run: RunPath) -> None:
    """Make one HTML page about a run: RUN/report.html.

    It holds everything in itself (figures, tables, a film of the deck) and can be sent to anybody.
    Works for interrupted and failed runs, too, and says what is missing.

    Exit code 0: made; 2: the folder is no run, or has not ended.
    """
    from orchestrator.output.report.page import report as made

    with reported_errors():
        CONSOLE.print(made(run))


def record(
    run: RunPath,
    out: Annotated[Path, typer.Option("--out", help="file to write")],
    cycles: Annotated[
        int | None, typer.Option(min=1, help="cycles to record [default: until the panels repeat, up to 8]")
    ] = None,
) -> None:
    """Record the panels of a run, to be played back by panel.solver = "recorded".

    The run must have been made with --set output.shapes_s=<time between rows>, and last until the
    machine moves steadily.  Another case plays the file back with --set panel.solver=recorded
    --set panel.recording=<file>, a path from that case's folder, if its panels have the same
    lengths.

    Exit code 0: written; 2: the folder does not hold what is needed.
    """
    from orchestrator.case import recording_file
    from orchestrator.output.records.run_folder import SUMMARY
    from orchestrator.output.records.trust import is_trusted
    from orchestrator.studies.points import status
    from orchestrator.studies.record import record as recorded

    with reported_errors():
        made = recorded(run, cycles)
    try:
        recording_file.write(out, made.file)
    except OSError as error:
        refuse(str(error))
    if not is_trusted(state := status(run)):
        CONSOLE.print(f"warning: the run is {state}: {run / SUMMARY} says why")
    for name, share in made.change.items():
        what = f"{made.cycles} cycles, {100 * share:.2g} % of its motion unlike those before"
        CONSOLE.print(f"{name}: {what}")
    CONSOLE.print(f"written: {out}")
