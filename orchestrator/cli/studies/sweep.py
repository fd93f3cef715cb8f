"""``flipflow study sweep``: runs of a case over the values of one key or of several keys."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Annotated

import typer

from orchestrator.cli.options import StudyOutput, WriteJobs
from orchestrator.preflight.cost import in_words
from orchestrator.studies import jobs
from orchestrator.studies.points import MOST_VALUES, CaseStudy, Point, Vary, parse_vary
from orchestrator.studies.sweep import sweep_rows, write_sweep
from orchestrator.studies.sweep_plan import Arrangement, SweepPlan, check_names, plan_sweep
from orchestrator.studies.sweep_results import (
    SweptSetting,
    draw_results,
    results_of,
    results_table,
    transient_words,
)
from orchestrator.workbench import CaseError, CaseProblem, FolderUnusable, Run, StudyFolder


def command(
    study: CaseStudy,
    vary: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=VALUES", help="values as a,b,c or first:last:step (both ends); may be repeated"
        ),
    ],
    plan: Annotated[
        Arrangement,
        typer.Option(
            help="grid: all combinations; list: the keys' first values, second values and so on; "
            "random: between first:last, or of a list"
        ),
    ] = Arrangement.GRID,
    number: Annotated[int, typer.Option(min=1, max=MOST_VALUES, help="number of runs of a random plan")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="of a random plan")] = 1,
    result: Annotated[
        list[str] | None, typer.Option(metavar="NAME", help="result to print and draw; may be repeated")
    ] = None,
    dry: Annotated[bool, typer.Option("--dry", help="list the runs, predict their time, and stop")] = False,
    write_jobs: WriteJobs = False,
) -> StudyOutput:
    """Run a case over values of one key, or of several keys.

    Called again, only missing runs are made; --dry lists and predicts them. sweep.csv and sweep.parquet
    have amplitudes, drift and all results of each setting.  In pictures, open marks have not settled, and
    crosses cannot be trusted.
    """
    wanted = check_results(result)
    single = len(vary) == 1 and plan is not Arrangement.RANDOM
    settings = parse_vary(vary[0]) if single else plan_sweep(vary, plan, number, seed)
    study = replace(study, name=settings.name)
    table, head = study.folder / "sweep.csv", ",".join((*settings.keys, "status"))
    if table.exists() and not table.read_text(encoding="utf-8").startswith(head):
        raise FolderUnusable(f"{table}: is of a sweep over other keys; give another folder with --out")
    check_names(study, [key.rpartition(".")[0] for key in settings.keys], "--vary")
    points = settings.points(study)
    if dry:
        yield from _predictions(settings, points, study.crew.workers)
        return True
    if write_jobs:
        yield from jobs.write_jobs(points, study.folder)
        return True
    yield from study.run(points)
    rows, folder = sweep_rows(settings, points, wanted), StudyFolder(study.folder)
    if isinstance(settings, Vary):
        yield from write_sweep(settings, points, study.folder, wanted)
    else:
        yield folder.write_csv("sweep.csv", rows)
    yield folder.write_parquet("sweep.parquet", rows)
    if wanted:
        measured = [
            SweptSetting(
                settings.setting_of(p),
                p.status(),
                results_of(p.run, wanted),
                transient_words(p.run),
                settings.given_of(p),
            )
            for p in points
        ]
        yield results_table(settings.keys, measured, wanted)
        yield from draw_results(settings.keys, measured, wanted, study.folder / "results.png")
    return all(point.status() == "done" for point in points)


def _predictions(settings: Vary | SweepPlan, points: Sequence[Point], workers: int) -> Iterator[str]:
    """Yield a line for each run with its predicted processor time, and one for those that are left."""
    left_s = []
    for point in points:
        texts = settings.setting_of(point) | settings.given_of(point)
        what = ", ".join(f"{key} = {text}" for key, text in texts.items())
        if point.done():
            yield f"{what}: done before"
        else:
            left_s.append(point.loaded.predicted_s)
            yield f"{what}: {in_words(left_s[-1])} of processor time"
    yield (
        f"{len(left_s)} of {len(points)} runs are to be made, {in_words(sum(left_s))} of processor time, "
        f"{workers} at a time (predicted, good to a factor of three); nothing was run"
    )


def check_results(names: Sequence[str] | None) -> tuple[str, ...]:
    """Return the names of the wanted results.  Raises CaseError for a name that is none."""
    problems = []
    for name in names or ():
        try:
            Run.named(name)
        except KeyError as error:
            problems.append(CaseProblem((), str(error.args[0]), file=f"--result {name}", kind="unknown-name"))
    if problems:
        raise CaseError(problems)
    return tuple(names or ())
