"""``python -m tools.effect_bank``: try out the verdicts of ``flipflow explain`` on a bank of scenes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import CONSOLE, FAILED, reported_errors

if TYPE_CHECKING:
    from tools.effect_bank.trials import SceneTrials

WIDE = 150


def effects(
    bank: Annotated[Path, typer.Argument(help="file with the scenes")] = Path("cases/effects.toml"),
    scene: Annotated[
        list[str] | None, typer.Option("--scene", help="only this scene; may be repeated")
    ] = None,
    dry: Annotated[bool, typer.Option("--dry", help="say what would be run, and stop")] = False,
    out: Annotated[Path, typer.Option("--out", help="folder of the study")] = Path("runs/effects"),
    jobs: Annotated[
        int | None, typer.Option(min=1, help="runs at a time [default: as the machine bears]")
    ] = None,
) -> None:
    """Try out the verdicts of explain by scenes with and without each effect that can be left out.

    Each scene of the bank is run as it is and without one effect at a time.  The verdict before the
    run is compared with the change of the results that the scene asks for; a change counts from
    10 %.  Called again, the tool makes only the missing runs.  The folder gets effects.csv and
    effects.md.

    Exit code 4: an effect that may be left out by its verdict changes a result by more than 10 %, a
    fifth or more of the effects that matter by their verdicts do not, or a run is missing; 2: the
    bank is wrong.
    """
    from orchestrator.output.records.run_folder import study_folder
    from orchestrator.studies.points import Crew, run_points, workers_that_fit
    from tools.effect_bank import bank as banks
    from tools.effect_bank import tables
    from tools.effect_bank.confusion import confusion
    from tools.effect_bank.trials import Countdown, all_scenes, every_run, still_to_run

    with reported_errors():
        wanted = banks.select(banks.read(bank), scene or [])
        scenes = all_scenes(wanted, bank.parent, out)
        if dry:
            _list(scenes)
            return
        waiting = still_to_run(scenes)
        todo = [run for run, _ in every_run(scenes) if run.status() != "failed"]
        with study_folder(out):
            countdown = Countdown(waiting, CONSOLE.print)
            for line in run_points(todo, Crew(jobs or workers_that_fit())):
                countdown(line)
        table = confusion(scenes)
        files = tables.write(table, out)
    if not CONSOLE.is_terminal:
        CONSOLE.width = WIDE  # in a file, lines are as wide as the table
    CONSOLE.print(tables.confusion_table(table))
    for line in [*tables.lines(table), *(f"written: {file}" for file in files)]:
        CONSOLE.print(line)
    if not table.is_good:
        raise typer.Exit(FAILED)


def _list(scenes: list[SceneTrials]) -> None:
    """Print the runs that would be made, with their predicted times."""
    from tools.effect_bank.trials import in_time, still_to_run

    for one in scenes:
        CONSOLE.print(f"{one.name}: {one.scene.why}")
        for trial in one.trials:
            todo = [run for run in trial.runs if not run.ended(run.run)]
            what = f"without {trial.without}" if trial.without else "as it is"
            cost = f"{len(todo)} to be run, about {trial.predicted_s:.0f} s each"
            CONSOLE.print(f"  {what}: {trial.omitted or cost}")
    waiting = still_to_run(scenes)
    total = in_time(sum(waiting.values()))
    CONSOLE.print(f"in all {len(waiting)} runs, about {total} of processor time")


app = typer.Typer(add_completion=False, rich_markup_mode=None)
app.command()(effects)

if __name__ == "__main__":
    app()
