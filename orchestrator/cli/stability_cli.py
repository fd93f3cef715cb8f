"""The command line's ``flipflow study stability``."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import CONSOLE, FAILED, reported_errors

if TYPE_CHECKING:
    from orchestrator.studies.hard.stability_map import Spot
    from orchestrator.studies.hard.verdicts import Line

Part = Annotated[str, typer.Option("--part", help="hard, map, or both with a comma between")]


def stability(
    cases: Annotated[Path, typer.Argument(help="folder with the hard cases")] = Path("cases/hard"),
    part: Part = "hard,map",
    base: Annotated[
        str, typer.Option("--map", help="the case of that folder whose map.toml is drawn")
    ] = "interval",
    out: Annotated[Path, typer.Option("--out", help="folder of the study")] = Path("runs/stability"),
    jobs: Annotated[
        int | None, typer.Option(min=1, help="runs at a time [default: one per processor]")
    ] = None,
) -> None:
    """Run all hard cases, and draw the map of what stays stable.

    hard: every run of every case with expected.toml, and its criteria.  map: one case over coupling
    schemes, sync intervals and masses of the bed: stable, warned or stopped.  Called again, only
    what is missing is run; a run that was stopped with a reason is not missing.  The folder gets
    hard.csv, hard.md, map.csv, stability-map.png and stability.html.

    Exit code 4: a criterion is not met, or a known failure is met; 2: a case is wrong.
    """
    from orchestrator.case.file.errors import CaseError, CaseProblem
    from orchestrator.output.records import run_folder
    from orchestrator.studies import sweep
    from orchestrator.studies.hard import cases as hard
    from orchestrator.studies.hard import stability_map, verdicts
    from orchestrator.studies.workers import Crew

    parts = {word.strip() for word in part.split(",")}
    with reported_errors():
        if unknown := parts - {"hard", "map"}:
            raise CaseError([CaseProblem((), f"no part {sorted(unknown)[0]}", "hard or map", "--part")])
        found = hard.found(cases, out / "hard") if "hard" in parts else []
        spots = stability_map.spots(cases / base, out / "map") if "map" in parts else []
        points = [*hard.all_points(found), *(spot.run for spot in spots)]
        with run_folder.study_folder(out):
            sweep.run(points, Crew(jobs or os.cpu_count() or 1), CONSOLE.print)
    lines = verdicts.judged(found)
    _show(lines, spots, out)
    if not all(line.good for line in lines) or any(spot.outcome == "not run" for spot in spots):
        raise typer.Exit(FAILED)


def _show(lines: list[Line], spots: list[Spot], out: Path) -> None:
    from orchestrator.studies.hard import pictures, stability_map, verdicts

    if not CONSOLE.is_terminal:
        CONSOLE.width = 150  # into a file: as wide as the table
    written, picture = [], None
    if lines:
        CONSOLE.print(verdicts.table(lines))
        written += verdicts.write(lines, out)
    if spots:
        picture = pictures.draw(spots, out / "stability-map.png")
        written += [stability_map.write(spots, out), picture]
    written.append(pictures.page(lines, spots, picture, out))
    for file in written:
        CONSOLE.print(f"written: {file}")
