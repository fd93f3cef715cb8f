"""The command line's ``flipflow ladder``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import CONSOLE, FAILED, reported_errors
from orchestrator.cli.options import CasePath, Level, Overrides

if TYPE_CHECKING:
    from orchestrator.studies.ladder.climb import Wanted
    from orchestrator.studies.ladder.tables import Row


def ladder(
    case: CasePath,
    level: Level = None,
    only: Annotated[
        str, typer.Option("--ladder", help="which ladders, with commas")
    ] = "panel,frames,particles",
    duration: Annotated[
        float | None, typer.Option(min=1e-6, help="seconds to simulate [default: the case's]")
    ] = None,
    budget: Annotated[
        float, typer.Option(min=1, help="a rung predicted to take more processor seconds is left out")
    ] = 600.0,
    out: Annotated[Path | None, typer.Option("--out", help="folder [default: runs/<case>-ladder]")] = None,
    jobs: Annotated[int, typer.Option(min=1, help="runs at a time; times are best with one")] = 1,
    overrides: Overrides = None,
) -> None:
    """Run a case with every model of its panels, frames and particles, and compare.

    One key is changed at a time; errors are against the highest rung of each ladder that was run.
    Called again, only what is missing is run.  The folder gets ladder.csv, ladder.json, pictures
    and ladder.html; a ladder.json beside case.toml is used by flipflow explain.

    Exit code 4: a rung failed; 2: the case is wrong.
    """
    from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean
    from orchestrator.studies.ladder.climb import Wanted, climbed
    from orchestrator.studies.ladder.rungs import LADDERS
    from orchestrator.studies.ladder.tables import rows

    folder = out or Path("runs") / f"{case.resolve().name}-ladder"
    names = tuple(word.strip() for word in only.split(","))
    sets = [*(overrides or []), *([f"duration_s={duration!r}"] if duration else [])]
    with reported_errors():
        for name in names:
            if name not in LADDERS:
                hint = did_you_mean(name, LADDERS)
                raise CaseError([CaseProblem((), f'no ladder "{name}"', hint, "--ladder")])
        wanted = Wanted(case, level, tuple(sets), names, budget, folder, jobs)
        steps = climbed(wanted, CONSOLE.print)
    folder.mkdir(parents=True, exist_ok=True)
    _show(wanted, rows(steps))
    if any(step.point is not None and not step.done for step in steps):
        raise typer.Exit(FAILED)


def _show(wanted: Wanted, table: list[Row]) -> None:
    from orchestrator.preflight.levels import load
    from orchestrator.studies.ladder import pictures, tables

    if not CONSOLE.is_terminal:
        CONSOLE.width = 150  # into a file: as wide as the table
    for name in wanted.ladders:
        if any(row.step.rung.ladder == name for row in table):
            CONSOLE.print(tables.as_table(name, table), soft_wrap=False)
            if lines := tables.not_run(name, table):
                CONSOLE.print("\n".join(["not run:", *lines]))
    loaded = load(wanted.case, wanted.level, wanted.sets)
    case = loaded.name
    written = tables.write(case, loaded.level, table, wanted.out)
    drawn = pictures.draw(table, wanted.out)
    written += [*drawn.values(), pictures.page(case, table, drawn, wanted.out)]
    for file in written:
        CONSOLE.print(f"written: {file}")
