"""The command line ``flipflow`` and its commands; each command imports its modules when it is called."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import (
    CONSOLE,
    ERRORS,
    FAILED,
    WRONG,
    check_or_report,
    find_all_problems_when_open,
    refuse,
    reported_errors,
)
from orchestrator.cli.new import new
from orchestrator.cli.options import CasePath, Level, Overrides
from orchestrator.cli.study import study
from orchestrator.output.loads import Format

if TYPE_CHECKING:
    from orchestrator.preflight.judge import JudgedCase
    from orchestrator.run.trials.pairs import TriedEffects
    from orchestrator.studies.accuracy.stored import StoredStudy

HELP = """Co-simulation of vibrating flip-flow screens: particles, panels and frames.

Examples:

  flipflow new mine                                    begin a machine of your own, in the folder mine

  flipflow list                                        what can be run

  flipflow check cases/quickstart                      is the case right, and what is in it?

  flipflow show cases/quickstart                       drawings, modes and a model to turn about

  flipflow materials limestone                         its numbers, with ranges and sources

  flipflow bushing loop-4mm.csv                        a spring fitted to a loop, and its picture

  flipflow surface chute.step                          size, faults and picture of a surface's file

  flipflow explain cases/quickstart                    which effects does it call for?

  flipflow run cases/quickstart                        run it, into a new folder under runs/

  flipflow run cases/quickstart --level draft          coarse and quick

  flipflow run cases/quickstart --set panel.solver=rigid --out runs/rigid

  mpirun -n 4 flipflow run cases/quickstart            on four processes; as root with --allow-run-as-root,
                                                       on a busy machine with --mca mpi_yield_when_idle 1


  flipflow resume runs/quickstart-1                    go on with it, if it was interrupted

  flipflow report runs/quickstart-1                    one HTML page about a run

  flipflow compare runs/a runs/b --out ab.html         what differs, and what is more than chance

  flipflow results runs/* --out results.parquet        the results of many runs as one table

  flipflow study sweep cases/empty-machine --vary screen.exciters.shaft.speed_rad_per_s=58:110:4

  flipflow study paper cases/ffs0827-empty             a published machine against its paper

  flipflow study accuracy cases/quickstart --dry       what accuracy costs, parameter by parameter

  flipflow plan cases/quickstart --tolerance 5% --budget 1h    settings for an error and a time

Exit codes: 0 done, 1 an internal error, 2 the case or the command is wrong, 3 a solver is
not installed, 4 a solver failed or the run became unstable, 5 the run is done but its own figures
say that it cannot be trusted, 6 it is done but its results could not be made, 130 interrupted
(129 by SIGHUP, 138 by SIGUSR1, 143 by SIGTERM).

Every key of a case is described in docs/case-format.md, what a run leaves behind in
docs/run-folder.md."""

app = typer.Typer(help=HELP, no_args_is_help=True, add_completion=False, rich_markup_mode=None)


def _print_versions(wanted: bool) -> None:
    """Print the versions of all programs and end the program, if they are ``wanted``."""
    if not wanted:
        return
    from orchestrator.case.provenance import commit, versions, warnings

    for name, number in versions().items():
        typer.echo(f"{name} {number or 'not installed'}")
    typer.echo(f"commit {commit() or 'unknown'}")
    for line in warnings():
        typer.echo(line)
    raise typer.Exit


@app.callback(help=HELP)
def program(
    version: Annotated[
        bool, typer.Option("--version", callback=_print_versions, is_eager=True, help="print the versions")
    ] = False,
) -> None:
    """Take the options that all commands share."""


RunPath = Annotated[Path, typer.Argument(metavar="RUN", help="folder of a run")]
RunPaths = Annotated[list[Path], typer.Argument(metavar="RUN...", help="folders of runs or studies")]
AsJson = Annotated[bool, typer.Option("--json", help="JSON on standard output")]
Out = Annotated[
    Path | None, typer.Option("--out", help="new folder for the results [default: runs/<case>-<number>]")
]


@app.command()
def run(
    case: CasePath,
    level: Level = None,
    out: Out = None,
    overrides: Overrides = None,
    trial_s: Annotated[
        float,
        typer.Option(
            min=0, help="time to try half the sync interval where a shorter one is advised; 0: none"
        ),
    ] = 60.0,
) -> None:
    """Run a case.

    The case is checked first; nothing is written if it is wrong. docs/run-folder.md says what the folder
    holds.

    Ctrl-C ends the run at the next sync point with all results, to be resumed; a second Ctrl-C ends it at
    once. mpirun wants SIGUSR1 instead (kill -USR1), as root --allow-run-as-root, and on a busy machine
    --mca mpi_yield_when_idle 1.
    """
    from orchestrator.cli.launch import run as launch

    raise typer.Exit(launch(case, level, out, overrides or [], trial_s))


@app.command()
def resume(
    run: RunPath,
    overrides: Overrides = None,
    checkpoint: Annotated[
        int | None, typer.Option(min=0, help="sync point of the checkpoint [default: the last]")
    ] = None,
) -> None:
    """Go on with a run from its last checkpoint.

    The resumed run is bit for bit the run that never stopped, on the same number of processes.  It may get a
    later end (--set duration_s=...) and other output at the same intervals; any other change is refused.
    """
    from orchestrator.cli.launch import resume as go_on

    raise typer.Exit(go_on(run, overrides or [], checkpoint))


@app.command()
def check(
    case: CasePath,
    level: Level = None,
    detail: Annotated[bool, typer.Option("--detail", help="all that limits the sync interval")] = False,
    ranks: Annotated[
        int | None, typer.Option(min=1, max=64, help="predict the wall time on up to so many MPI ranks")
    ] = None,
    as_json: AsJson = False,
    html: Annotated[
        Path | None, typer.Option("--html", metavar="PAGE", help="page to write, with drawings")
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Check a case without running it, and print what is in it.

    --ranks predicts the wall time of mpirun -n N flipflow run on more and more ranks of one computer, each
    on a core of its own, and says beyond how many they no longer pay.

    Exit code 2: the case cannot be run, and one message has every problem.
    """
    from orchestrator.cli.overview import overview
    from orchestrator.preflight.cost import particles_at_start
    from orchestrator.preflight.scaling import scaling_lines

    if as_json and ranks is not None:
        raise typer.BadParameter("--ranks prints a table: leave out --json", param_hint="--ranks")
    loaded = check_or_report(case, level, overrides, find_all_problems_when_open, as_json)
    with reported_errors():
        if as_json:
            from orchestrator.cli.json_forms import check_form, print_json

            print_json(check_form(loaded))
        parts = [overview(loaded, detail)] if html is not None or not as_json else []
        if ranks is not None:
            parts.append(scaling_lines(loaded.case, particles_at_start(loaded.case), ranks))
        lines = []
        for line in chain.from_iterable(parts):
            lines.append(line)
            if not as_json:
                CONSOLE.print(line)
        if html is not None:
            from orchestrator.cli.show import write_check_page

            write_check_page(loaded, lines, html)
            ERRORS.print(f"written: {html}")


@app.command()
def show(
    case: CasePath,
    level: Level = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="folder for the files [default: runs/<case>-machine]")
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Draw the machine of a case, without a solver.

    The files are views, openings (PNG and SVG), modes.svg (animated), model.html (to turn about) and
    machine.html (all of it).  Only problems in the tables matter: exit code 2.
    """
    from orchestrator.cli.show import show as write_views
    from orchestrator.preflight.check import find_table_problems

    loaded = check_or_report(case, level, overrides, find_table_problems)
    with reported_errors():
        files, found = write_views(loaded, out)
    for problem in found.problems:
        CONSOLE.print(f"problem: {problem}")
    for warning in found.warnings:
        CONSOLE.print(f"warning: {warning}")
    for file in files:
        CONSOLE.print(f"written: {file}")


@app.command()
def explain(
    case: CasePath,
    level: Level = None,
    study: Annotated[Path | None, typer.Option(help="accuracy.json [default: beside case.toml]")] = None,
    results: Annotated[
        str | None,
        typer.Option(
            "--for", metavar="NAMES", help="short names of results (efficiency,stroke,...) that decide"
        ),
    ] = None,
    budget: Annotated[
        float,
        typer.Option(min=0, help="with --for: processor time for all runs / s; one run gets a quarter of it"),
    ] = 300.0,
    as_json: AsJson = False,
    overrides: Overrides = None,
) -> None:
    """Print which effects a case calls for, by estimates, without a solver.

    A table has each effect, the number that decides, its threshold, the verdict and the key; lines name
    what is lacking or may be left out. flipflow study accuracy replaces estimates by measurements.

    With --for, short runs with and without an effect decide by the change of these results, unless an
    estimate is sure that it may be left out; of those the cheapest is tried, too.  The runs are remembered.
    """
    from orchestrator.cli.explain import print_explanation
    from orchestrator.preflight.check import find_table_problems

    loaded = check_or_report(case, level, overrides, find_table_problems)
    with reported_errors():
        measured = _stored(loaded, study)
        asked = tuple(word.strip() for word in (results or "").split(",") if word.strip())
        print_explanation(loaded, measured, _tried(loaded, asked, budget), asked, as_json)


@app.command()
def report(run: RunPath) -> None:
    """Make one HTML page about a run: RUN/report.html.

    It has all figures, tables and a film of the deck, and stands alone.
    """
    from orchestrator.output.report.page import report as make_report

    with reported_errors():
        CONSOLE.print(str(make_report(run)))


@app.command()
def results(
    runs: RunPaths,
    out: Annotated[
        Path | None, typer.Option("--out", help="file to write, .csv or .parquet [default: CSV is printed]")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Write the results of runs as a tidy table: one row for each result of each run.

    The columns are run, case, level, status, result, kind, value, half_width (95 %) and unit.
    """
    from orchestrator.cli.results import print_results

    print_results(runs, out, as_json)


@app.command()
def loads(
    run: RunPath,
    frame: Annotated[str, typer.Option("--frame", help="name of the frame")],
    out: Annotated[Path, typer.Option("--out", help="new folder for the files")],
    how: Annotated[Format, typer.Option("--format", help="of the loads")] = Format.CSV,
    from_s: Annotated[float, typer.Option("--from-s", help="first time of the run")] = 0.0,
    to_s: Annotated[float, typer.Option("--to-s", help="last time of the run [default: its end]")] = math.inf,
) -> None:
    """Write the loads on a frame over time, for a program that computes its strength.

    The run needs output.loads_s.  The forces of clamps, stops, walls, bushings and exciters with their
    places, gravity and inertia are in balance, in deck axes that move with the frame;
    README.txt explains them.  csv: one table; calculix: *AMPLITUDE and *CLOAD on node sets; apdl: tables and
    F on nodes.
    """
    from orchestrator.cli.loads import export

    with reported_errors():
        for line in export(run, frame, how, out, from_s, to_s):
            CONSOLE.print(line, soft_wrap=True)


@app.command()
def compare(
    runs: RunPaths,
    out: Annotated[Path | None, typer.Option("--out", help="HTML page to write")] = None,
    as_json: AsJson = False,
) -> None:
    """Compare runs with the first of them.

    Tables show keys that differ, and results with intervals, changes, and whether these are more than
    chance; the page has plots and pictures, too.
    """
    from orchestrator.cli.compare import print_comparison

    print_comparison(runs, out, as_json)


@app.command(name="list")
def list_cases(
    folder: Annotated[
        Path | None,
        typer.Argument(metavar="[FOLDER]", help="folder of cases [default: cases, and the program's]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List cases with their titles and levels.

    The program's own run by name from every folder: flipflow run quickstart.
    """
    if folder is not None and not folder.is_dir():
        refuse(f"{folder}: no such folder; name the one that holds your cases: flipflow list FOLDER")
    folders = [folder] if folder is not None else _usual_folders()
    if as_json:
        from orchestrator.cli.json_forms import cases_in, print_json

        print_json({"cases": [*chain.from_iterable(map(cases_in, folders))]})
        return
    for line in chain.from_iterable(map(_case_lines, folders)):
        CONSOLE.print(line)


@app.command()
def materials(
    name: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]", help="a material, such as moist limestone or rubber 60 Shore A"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the library of materials, or explain one: numbers, ranges, sources and contacts.

    A case takes a material by its name: material = "limestone".
    """
    from orchestrator.cli import materials as library

    named = library.find_or_refuse(" ".join(name)) if name else None
    if as_json:
        from orchestrator.cli.json_forms import print_json

        print_json(library.material_form(named) if named else library.list_form())
        return
    for part in library.explanation(named) if named else library.list_lines():
        CONSOLE.print(part)


@app.command()
def bushing(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="tables of tests, or loops")],
    out: Annotated[Path, typer.Option("--out", help="picture to write, .png or .svg")] = Path("bushing.png"),
    column: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=CLEAR NAME",
            help="what a column is, as curves.columns says it in a case; may be repeated",
        ),
    ] = None,
    decimal: Annotated[
        str, typer.Option(metavar="MARK", help="decimal mark, where files leave it open")
    ] = "",
    frequency: Annotated[
        str | None, typer.Option(metavar="F", help='of loops without a column of times, such as "12.5 Hz"')
    ] = None,
) -> None:
    """Fit a spring with friction and Maxwell elements to the tests of a bushing, and draw the fit.

    The files are those of screen.bushings.NAME.curves.file in a case: tables of stiffness and loss over
    amplitude and frequency, or loops of force over displacement.  The picture shows each measured loop with
    the fitted one, and stiffness and loss factor over the amplitude.

      flipflow bushing loop-1mm.csv loop-4mm.csv --out spring.png

    Exit code 0: done; 2: a file cannot be read, or leaves something open.
    """
    from orchestrator.cli.bushing import fit_files

    with reported_errors():
        for line in fit_files(files, column or [], decimal, frequency, out):
            CONSOLE.print(line, soft_wrap=True)


@app.command()
def surface(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="STEP, IGES, STL, OBJ, PLY, VTK or MSH")],
    unit: Annotated[str | None, typer.Option(help="unit of the file: m, cm, mm, in or ft")] = None,
    scale: Annotated[float | None, typer.Option(help="factor of all coordinates")] = None,
    tolerance: Annotated[
        str | None, typer.Option(metavar="D", help='of curved faces of STEP and IGES, such as "0.1 mm"')
    ] = None,
    out: Annotated[Path, typer.Option("--out", help="picture to write, .png or .svg")] = Path("surface.png"),
) -> None:
    """Print the size of a surface's file, its faults and what is healed, and draw it.

    The file is one of screen.surfaces.NAME.file in a case, before there is a case.

      flipflow surface chute.stl --unit mm --out chute.png

    Exit code 0: done; 2: the file cannot be read, or leaves its unit open.
    """
    from orchestrator.cli.surface import describe_file, surface_table

    with reported_errors():
        for line in describe_file(surface_table(file.name, unit, scale, tolerance), file.parent, out):
            CONSOLE.print(line, soft_wrap=True)


@app.command()
def plan(
    case: CasePath,
    tolerance: Annotated[
        str,
        typer.Option(
            metavar="SIZE", help='error, as 5% or 0.05 (relative); with --for of a share "2 points", too'
        ),
    ],
    budget: Annotated[str, typer.Option(metavar="TIME", help="wall time, as 90s, 30min, 1h or 2d")],
    level: Level = None,
    result: Annotated[
        str | None, typer.Option("--for", metavar="NAME", help="result (efficiency, ...) whose chance counts")
    ] = None,
    run: Annotated[
        Path | None,
        typer.Option("--from", metavar="RUN", help="with --for: measured run [default: the longest known]"),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option("--jobs", min=1, help="with --for: runs at a time [default: as the machine bears]"),
    ] = None,
    study: Annotated[
        Path | None,
        typer.Option("--study", help="accuracy.json [default: beside case.toml, or runs/<case>-accuracy]"),
    ] = None,
    write: Annotated[
        str | None, typer.Option(metavar="LEVEL", help="level to write into the case's folder")
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Choose settings for a tolerance and a time.

    A stored study of accuracy and a short run here give the cheapest settings within the tolerance, with
    their wall time and error, or what would fit the budget.

    With --for, the scatter of a measured run, or of a cheap pilot, says how many seconds, seeds and how
    wide a slice leave half the result's 95 % interval within the tolerance at the least processor time.

      flipflow plan cases/near-mesh --for efficiency --tolerance 5% --budget 2h

    Exit code 4: the time does not fit.
    """
    from orchestrator.cli.plan import choose_settings, parse_share, parse_time_s, print_choice

    budget_s = parse_time_s(budget)
    if result is not None:
        from orchestrator.cli.plan_result import Request, plan_result
        from orchestrator.studies.points import workers_that_fit

        if write is not None:
            refuse("--write: writes settings of a study, and goes without --for")
        loaded, sets, cores = (
            check_or_report(case, level, overrides),
            overrides or [],
            jobs or workers_that_fit(),
        )
        request = Request(loaded, case, sets, result, tolerance, budget_s, run, study, cores)
        if not plan_result(request):
            raise typer.Exit(FAILED)
        return
    for name, given in (("--from", run), ("--jobs", jobs)):
        if given is not None:
            refuse(f"{name}: goes with --for alone")
    largest_error = parse_share(tolerance)
    loaded, sets = check_or_report(case, level, overrides), overrides or []
    plan = choose_settings(loaded, case, level, study, largest_error, budget_s, sets)
    if not print_choice(plan, case, sets, loaded):
        raise typer.Exit(FAILED)
    if write is not None and plan.choice is not None:
        from orchestrator.preflight.cost import in_words
        from orchestrator.preflight.level_file import write_level

        about = f"planned: {100 * plan.choice.error.at_most:.2g} % in {in_words(plan.wall_s)}"
        with reported_errors():
            file = write_level(loaded, write, [*sets, *plan.choice.sets], about)
        CONSOLE.print(f"written: {file}")


app.command()(new)
app.add_typer(study, name="study")


def _stored(loaded: JudgedCase, given: Path | None) -> StoredStudy | None:
    """Return the given study of accuracy, or the study in the case's folder; None if there is none."""
    if given is None and not (loaded.folder / "accuracy.json").is_file():
        return None
    from orchestrator.studies.accuracy.stored import find_study
    from orchestrator.workbench import Case

    return find_study(Case(loaded), given)


def _tried(loaded: JudgedCase, asked: tuple[str, ...], budget_s: float) -> TriedEffects | None:
    """Return runs with and without effects for the results ``asked`` for; None if none are asked for."""
    from orchestrator.figures.short_names import named
    from orchestrator.run.trials.pairs import RUNS_IN_BUDGET, Pairs, try_all_effects

    try:
        for name in asked:
            named(name)
    except KeyError as error:
        refuse(f"--for: {error.args[0]}")
    if not asked:
        return None
    return try_all_effects(loaded, Pairs(budget_s / RUNS_IN_BUDGET, ERRORS.print, budget_s=budget_s))


def _usual_folders() -> list[Path]:
    """Return the folder "cases" here, if there is one, and that of the program's own cases."""
    from orchestrator.case.shipped import SHIPPED

    own = Path(SHIPPED.name)
    if not own.is_dir():
        return [SHIPPED]
    return [own] if own.resolve() == SHIPPED else [own, SHIPPED]


def _case_lines(folder: Path) -> Iterator[str]:
    """Yield a line for each case in a folder, followed by a line with its levels.

    A case that comes with the program has its name alone.
    """
    from orchestrator.case.file.errors import visible
    from orchestrator.case.shipped import SHIPPED
    from orchestrator.cli.json_forms import cases_in

    for case in cases_in(folder):
        name = Path(case["folder"]).name if folder == SHIPPED else case["folder"]
        title = case["title"] or f"(has problems: flipflow check {name})"
        names = [f"{n} (default)" if n == case["default_level"] else n for n in case["levels"]]
        yield visible(f"{name}  {title}")
        if case["base"]:
            yield visible(f"    over: {case['base']}")
        yield visible(f"    levels: {', '.join(names) or 'none'}")


def main() -> None:
    """Run the command line; this function is the entry point ``flipflow``.

    A word that is not UTF-8 is refused: tables and some libraries cannot have it.
    """
    for word in sys.argv[1:]:
        if word.encode(errors="ignore").decode() != word:
            ERRORS.print(f"{word!r} is not UTF-8; give it another name")
            sys.exit(WRONG)
    app()
