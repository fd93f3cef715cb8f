"""The command line ``flipflow``; its commands ``study ...`` are in study_cli.py."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer
from rich.console import Console

from orchestrator.commands.ladder_cli import ladder as climb
from orchestrator.commands.study_cli import study

if TYPE_CHECKING:
    from orchestrator.casefile.errors import Mistake
    from orchestrator.casefile.levels import LoadedCase

HELP = """Co-simulation of vibrating flip-flow screens: particles, panels and frames.

Examples:

  flipflow list                                        what can be run

  flipflow check cases/quickstart                      is the case right, and what is in it?

  flipflow explain cases/quickstart                    which effects does it call for?

  flipflow run cases/quickstart                        run it, into a new folder under runs/

  flipflow run cases/quickstart --level draft          coarse and quick

  flipflow run cases/quickstart --set panel.solver=rigid --out runs/rigid

  mpirun -n 4 flipflow run cases/quickstart            on four processes

  flipflow record RUN --out panels.h5                  its panels, to be played back

  flipflow resume runs/quickstart-1                    go on with it, if it was interrupted

  flipflow report runs/quickstart-1                    one HTML page about a run

  flipflow ladder cases/empty-machine --duration 0.6   every model of its parts: cost, error

  flipflow study sweep cases/empty-machine --vary screen.exciters.shaft.speed_rad_s=58:110:4

  flipflow study paper cases/ffs0827-empty             a published machine against its paper

Exit codes: 0 done, 1 a mistake in flipflow, 2 the case or the command is wrong, 3 a solver is
not installed, 4 a solver failed or the run became unstable, 130 interrupted (143 by SIGTERM).

Every key of a case is described in docs/case-format.md, what a run leaves behind in
docs/run-folder.md."""

app = typer.Typer(help=HELP, no_args_is_help=True, add_completion=False, rich_markup_mode=None)

CasePath = Annotated[Path, typer.Argument(metavar="CASE", help="folder of the case")]
Level = Annotated[
    str | None,
    typer.Option("--level", help="one of the case's levels [default: the case's default_level]"),
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="gives a key another value, for example panel.solver=rigid; may be repeated",
    ),
]
Out = Annotated[
    Path | None,
    typer.Option("--out", help="new folder for the results [default: runs/<case>-<number>]"),
]


def _say_versions(wanted: bool) -> None:
    if not wanted:
        return
    from orchestrator.records.provenance import commit, versions

    for name, number in versions().items():
        typer.echo(f"{name} {number or 'not installed'}")
    typer.echo(f"commit {commit() or 'unknown'}")
    raise typer.Exit


@app.callback(help=HELP)
def program(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_say_versions, is_eager=True, help="say the versions"),
    ] = False,
) -> None:
    """What all commands share."""


@app.command()
def run(case: CasePath, level: Level = None, out: Out = None, overrides: Overrides = None) -> None:
    """Run a case.

    The case is checked first; nothing is written if it is wrong.  The folder of the run holds
    the log, time series, files for ParaView, pictures and summary.json (docs/run-folder.md).

    Ctrl-C ends the run at the next sync point with all results written, to be resumed; twice, at
    once.
    """
    from orchestrator.commands.launch import run as launch

    raise typer.Exit(launch(case, level, out, overrides or []))


@app.command()
def resume(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="folder of a run")],
    overrides: Overrides = None,
) -> None:
    """Go on with a run from its last save.

    Runs are saved every now and then ([save] in a case), at their end, and by Ctrl-C.  What goes
    on is, bit for bit, the run that never stopped; on as many processes as it was saved.  It may
    be given a later end (--set duration_s=...) and other output; any other change is refused.
    """
    from orchestrator.commands.resume import resume as go_on

    raise typer.Exit(go_on(run, overrides or []))


@app.command()
def check(case: CasePath, level: Level = None, overrides: Overrides = None) -> None:
    """Check a case without running it, and say what is in it.

    Exit code 0: it can be run; 2: it cannot, with every mistake in one message.
    """
    from orchestrator.commands.overview import overview

    console = Console(highlight=False, markup=False, soft_wrap=True)
    for line in overview(_checked(case, level, overrides)):
        console.print(line)


@app.command()
def explain(
    case: CasePath,
    level: Level = None,
    ladder: Annotated[
        Path | None,
        typer.Option(help="ladder.json of flipflow ladder [default: the one beside case.toml]"),
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Say which effects a case calls for, by estimates before any run.

    For each effect: whether the case has it at this level, the dimensionless number that decides,
    the threshold, what follows, and which key changes it.  At the end: what matters and is
    lacking, and what could be left out.  No solver is started or needed.  Where flipflow ladder has
    measured what an effect amounts to, its figures take the estimate's place.

    Exit code 0: said, whatever the verdicts; 2: the case has mistakes.
    """
    from orchestrator.casefile.errors import CaseError
    from orchestrator.checks import table_mistakes
    from orchestrator.commands.explain import show
    from orchestrator.ladder.stored import stored

    loaded = _checked(case, level, overrides, table_mistakes)
    try:
        found = stored(loaded, ladder)
    except CaseError as error:
        _refuse(str(error), 2)
    show(loaded, found)


@app.command()
def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="folder of a run")],
) -> None:
    """Make one HTML page about a run: RUN/report.html.

    It holds everything in itself (figures, tables, a film of the deck) and can be sent to anybody.
    Works for interrupted and failed runs, too, and says what is missing.

    Exit code 0: made; 2: the folder is no run, or has not ended.
    """
    from orchestrator.records.run_folder import FolderUnusable
    from orchestrator.report.command import report as made

    try:
        Console(highlight=False, markup=False, soft_wrap=True).print(made(run))
    except FolderUnusable as error:
        _refuse(str(error), 2)


@app.command()
def record(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="folder of a run")],
    out: Annotated[Path, typer.Option("--out", help="file to write")],
    cycles: Annotated[
        int | None,
        typer.Option(min=1, help="cycles to record [default: until the panels repeat, up to 8]"),
    ] = None,
) -> None:
    """Record the panels of a run, to be played back by panel.solver = "recorded".

    The run must have been made with --set output.shapes_s=<time between rows>, and last until the
    machine moves steadily.  Another case plays the file back with --set panel.solver=recorded
    --set panel.recording=<file>, a path from that case's folder, if its panels have the same
    lengths.

    Exit code 0: written; 2: the folder does not hold what is needed.
    """
    from orchestrator.casefile.errors import CaseError
    from orchestrator.records import recording_file
    from orchestrator.studies.record import record as recorded

    try:
        made = recorded(run, cycles)
        recording_file.write(out, made.file)
    except (CaseError, OSError) as error:
        _refuse(str(error), 2)
    console = Console(highlight=False, markup=False, soft_wrap=True)
    for name, share in made.change.items():
        what = f"{made.cycles} cycles, {100 * share:.2g} % of its motion unlike those before"
        console.print(f"{name}: {what}")
    console.print(f"written: {out}")


@app.command(name="list")
def list_cases(
    folder: Annotated[Path, typer.Argument(help="folder that holds cases")] = Path("cases"),
) -> None:
    """List cases with their titles and levels."""
    from orchestrator.commands.overview import case_lines

    if not folder.is_dir():
        _refuse(
            f"{folder}: no such folder; name the one that holds your cases: flipflow list FOLDER", 2
        )
    console = Console(highlight=False, markup=False, soft_wrap=True)
    for line in case_lines(folder):
        console.print(line)


@app.command()
def bench(
    case: CasePath,
    level: Level = None,
    intervals: Annotated[int, typer.Option(min=1, help="sync intervals to time")] = 2000,
    settling: Annotated[int, typer.Option(help="sync intervals before them, untimed")] = 0,
    effects: Annotated[
        bool, typer.Option("--effects", help="time the case without each of its effects instead")
    ] = False,
    overrides: Overrides = None,
) -> None:
    """Time a case against its particles alone on a rigid, still surface (one process).

    With --effects: what each effect that can be left out costs, part by part, that it costs nothing
    when it is left out, and what is not loaded then.
    """
    from orchestrator.casefile.contents import has_particles
    from orchestrator.commands import bench_effects
    from orchestrator.commands.bench import bench as timed
    from orchestrator.plans import SolverFailed, SolverMissing

    loaded = _checked(case, level, overrides)
    if not effects and not has_particles(loaded.case):
        _refuse("the case has no particles: there is nothing to compare", 2)
    try:
        console = Console(markup=False)
        if not console.is_terminal:
            console.width = 180 if effects else 120  # into a file: as wide as the table
        if effects:
            asked = bench_effects.Asked(case, level, tuple(overrides or ()))
            console.print(bench_effects.bench(asked, intervals))
        else:
            console.print(timed(loaded, intervals, settling))
    except SolverMissing as missing:
        _refuse(str(missing), 3)
    except SolverFailed as failed:
        _refuse(str(failed), 4)


def _checked(
    case: Path,
    level: str | None,
    overrides: list[str] | None,
    rule: Callable[[LoadedCase], list[Mistake]] | None = None,
) -> LoadedCase:
    """The case, if it has no mistake (by default, of any kind); else all of them are said and the
    program ends."""
    from orchestrator.casefile.errors import CaseError
    from orchestrator.casefile.levels import load
    from orchestrator.checks import mistakes

    try:
        loaded = load(case, level, overrides or [])
        if found := (rule or mistakes)(loaded):
            raise CaseError(found)
    except CaseError as error:
        _refuse(str(error), 2)
    return loaded


def _refuse(why: str, code: int) -> NoReturn:
    Console(stderr=True, highlight=False, markup=False, soft_wrap=True).print(why)
    raise typer.Exit(code)


app.add_typer(study, name="study")
app.command(name="ladder")(climb)


def main() -> None:
    """The entry point ``flipflow``."""
    app()
