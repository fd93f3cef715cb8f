"""``flipflow study accuracy``: the cost of accuracy."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean
from orchestrator.cli.options import StudyOutput
from orchestrator.preflight.refinement import PARAMETERS
from orchestrator.studies.accuracy.combinations import COMPARED, DECISIVE, StudyRequest, afford
from orchestrator.studies.accuracy.layers import marks_of, read_marks
from orchestrator.studies.accuracy.report import advice, cost_table, warnings, write_layers, write_study
from orchestrator.studies.accuracy.scenes import find_scenes, is_case
from orchestrator.studies.accuracy.study import AccuracyStudy, plan_study, run_study
from orchestrator.studies.points import CaseStudy
from orchestrator.workbench import StudyFolder

QUICK_VALUES, QUICK_SEEDS = 3, 1
MOST_SEEDS = 100  # each run is checked first, in some hundredths of a second


def command(
    study: CaseStudy,
    parameters: Annotated[
        str, typer.Option(help="which, with commas; scheme=aitken+robin: only these variants [default: all]")
    ] = "",
    values: Annotated[int, typer.Option("--points", min=2, max=7, help="values of each parameter")] = 4,
    seeds: Annotated[
        int, typer.Option(min=1, max=MOST_SEEDS, help="runs of each point, with other random numbers")
    ] = 3,
    quick: Annotated[bool, typer.Option("--quick", help="as --points 3 --seeds 1")] = False,
    duration: Annotated[
        float | None, typer.Option(min=1e-6, help="seconds to simulate [default: the case's]")
    ] = None,
    budget: Annotated[
        float, typer.Option(min=1, help="a run predicted to take more processor s is left out")
    ] = 600.0,
    quantities: Annotated[
        str, typer.Option(help="which errors decide, with commas [default: what repeats itself]")
    ] = "",
    dry: Annotated[bool, typer.Option("--dry", help="list the runs, predict their time, and stop")] = False,
    recorded: Annotated[
        Path | None, typer.Option("--recorded", help="make no run, draw this layers.csv")
    ] = None,
) -> StudyOutput:
    """Measure the cost of accuracy: run a case over its refinement parameters.

    One parameter is changed at a time.  Then the proposed joint settings are run: the reference, and for
    each tolerance the cheapest.  Called again, only missing runs are made. accuracy.html shows all; flipflow
    plan uses accuracy.json.

    Of a folder of cases, each one with an accuracy.toml is studied, and layers.csv has all.  That file has
    title, level, and the options sets, parameters, quantities, points, seeds and budget_s; its table [quick]
    has those that differ with --quick.

    Exit code 4: a run failed.
    """
    duration_sets = [f"duration_s={duration!r}"] if duration else []
    asked = StudyRequest(
        replace(study, sets=(*study.sets, *duration_sets)),
        _names("--parameters", parameters, [*PARAMETERS], [*PARAMETERS]),
        QUICK_VALUES if quick else values,
        QUICK_SEEDS if quick else seeds,
        budget,
        _names("--quantities", quantities, [name for name in COMPARED if name != "shape"], DECISIVE),
    )
    if recorded is not None:
        with StudyFolder(study.folder).lock():
            yield from write_layers(read_marks(recorded), study.folder)
        return True
    requests = {"": asked} if is_case(study.case) else dict(_scenes(asked, quick))
    studies = {}
    for title, request in requests.items():
        if title:
            yield f"{title}:"
        if dry:
            yield from _predictions(request)
        else:
            studies[title] = yield from _study(request)
    if studies and not is_case(study.case):
        marks = [mark for title, each in studies.items() for mark in marks_of(each, title)]
        with StudyFolder(study.folder).lock():
            yield from write_layers(marks, study.folder)
    return not any(row.why and not row.point.omitted for each in studies.values() for row in each.rows)


def _scenes(asked: StudyRequest, quick: bool) -> Iterator[tuple[str, StudyRequest]]:
    """Yield the requests of the scenes below a folder by their titles.  Raises CaseError."""
    for scene, study in find_scenes(asked.study):
        sized = scene.sized(quick)
        yield (
            scene.title,
            StudyRequest(
                replace(study, sets=(*study.sets, *sized.sets)),
                _names("--parameters", ",".join(scene.parameters), [*PARAMETERS], []),
                sized.points or asked.values,
                sized.seeds or asked.seeds,
                sized.budget_s or asked.budget_s,
                _names("--quantities", ",".join(scene.quantities), COMPARED, []),
                keeps_model=True,
            ),
        )


def _study(request: StudyRequest) -> Generator[str | Table | Path, None, AccuracyStudy]:
    """Make the study of a case, yield what it says and writes, and return it."""
    folder = request.study.folder
    with StudyFolder(folder).lock():
        completed = yield from run_study(request)
    yield cost_table(completed)
    yield from (f"not compared: {row.point.label}: {row.why}" for row in completed.rows if row.why)
    yield from advice(completed)
    yield from warnings(completed)
    yield from write_study(completed, folder)
    return completed


def _names(option: str, given: str, known: Sequence[str], usual: Sequence[str]) -> tuple[str, ...]:
    """Return the names in a text with commas, or the usual names.  Raises CaseError for an unknown name."""
    names = dict.fromkeys(word.strip() for word in given.split(",")) if given else usual
    for name in names:
        word = name.partition("=")[0] if option == "--parameters" else name  # scheme=aitken+robin
        if word not in known:
            raise CaseError(
                [CaseProblem((), f'no "{name}"', did_you_mean(name, known), option, kind="unknown-name")]
            )
    return tuple(names)


def _predictions(request: StudyRequest) -> Iterator[str]:
    """Yield the points that would be run, with predicted times, as lines for the console."""
    study = plan_study(request)
    yield from (f"not offered: {name}: {why}" for name, why in study.offer.missing.items())
    start = [one.with_metrics() for one in study.points[:2]]
    total_s = 0.0
    for each in afford([*start, *study.points[2:]], request.budget_s):
        todo = [run for run in each.runs if not run.run.is_over()]
        total_s += each.predicted_s * len(todo)
        what = each.omitted or f"predicted {each.predicted_s:.0f} s each, {len(todo)} to be run"
        yield f"{each.name}: {what}"
    by = "by what was measured here" if any(one.metrics for one in start) else "good to a factor of three"
    yield (
        f"in all {total_s:.0f} s of processor time ({by}), {request.study.crew.workers} at a time; "
        "then up to six points, each within the budget, that these propose"
    )
