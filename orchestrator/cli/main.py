"""The command line ``flipflow``: its commands are in the files whose names end in _cli."""

from __future__ import annotations

from typing import Annotated

import typer

from orchestrator.cli import case_cli, run_cli
from orchestrator.cli.plan_cli import plan
from orchestrator.cli.study_cli import study

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


def _say_versions(wanted: bool) -> None:
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
        bool, typer.Option("--version", callback=_say_versions, is_eager=True, help="say the versions")
    ] = False,
) -> None:
    """Takes what all commands share."""


for command in (
    run_cli.run,
    run_cli.resume,
    case_cli.check,
    case_cli.explain,
    run_cli.report,
    run_cli.record,
):
    app.command()(command)
app.command(name="list")(case_cli.list_cases)
app.command()(plan)
app.add_typer(study, name="study")


@app.command(hidden=True, context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def ladder() -> None:
    """Say which command compares models now."""
    raise typer.BadParameter(
        "flipflow ladder is a part of study accuracy now: flipflow study accuracy CASE "
        "--parameters panel-mesh,panel-model,frames-model,particles-model,stiffness,number"
    )


def main() -> None:
    """Runs the command line; the entry point ``flipflow``."""
    app()
