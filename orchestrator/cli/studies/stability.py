"""``flipflow study stability``: benchmarks (cases that are hard to couple) and the map of stability."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.options import StudyOutput
from orchestrator.studies.points import Crew, run_points
from orchestrator.studies.stability import draw_map, find_benchmarks, map_spots, write_stability_page
from orchestrator.studies.verdicts import verdict_table, write_verdicts
from orchestrator.workbench import CaseError, CaseProblem, StudyFolder


def command(
    crew: Crew,
    cases: Annotated[Path, typer.Argument(metavar="[FOLDER]", help="folder with the benchmarks")] = Path(
        "cases/hard"
    ),
    part: Annotated[str, typer.Option("--part", help="hard, map, or both with a comma between")] = "hard,map",
    base: Annotated[
        str, typer.Option("--map", help="the case of that folder whose map.toml is drawn")
    ] = "interval",
    out: Annotated[Path, typer.Option("--out", help="folder of the study")] = Path("runs/stability"),
) -> StudyOutput:
    """Run all hard cases, and draw the map of stability.

    Part "hard" judges every case by its criteria.toml.  Part "map" runs one case over schemes, intervals and
    masses of the bed: stable, warned, stopped, or idle without contact.  Called again, only missing runs are
    made. stability.html shows all.

    Exit code 4: a criterion is not met, a known failure is, or a run of the map is missing or idle.
    """
    parts = {word.strip() for word in part.split(",")}
    if unknown := parts - {"hard", "map"}:
        raise CaseError(
            [CaseProblem((), f"no part {sorted(unknown)[0]}", "hard or map", "--part", kind="unknown-name")]
        )
    benchmarks = find_benchmarks(cases, out / "hard") if "hard" in parts else []
    spots = map_spots(cases / base, out / "map") if "map" in parts else []
    points = [*(p for each in benchmarks for p in each.points), *(spot.point for spot in spots)]
    with StudyFolder(out).lock():
        yield from run_points(points, crew)
    results = {each.name: each.results() for each in benchmarks}
    every = [result for of_case in results.values() for result in of_case]
    picture = None
    if every:
        yield verdict_table("hard cases", every)
        yield from write_verdicts(every, out, "hard")
    if spots:
        picture = draw_map(spots, out / "stability-map.png")
        yield from (StudyFolder(out).write_csv("map.csv", [spot.words for spot in spots]), picture)
    yield write_stability_page([(each, results[each.name]) for each in benchmarks], spots, picture, out)
    return all(each.is_good for each in every) and all(
        spot.outcome not in ("not run", "idle") for spot in spots
    )
