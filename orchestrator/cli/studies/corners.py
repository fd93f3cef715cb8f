"""``flipflow study corners``: a case at the corners of the ranges of restitution and rolling friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.cli.options import StudyOutput
from orchestrator.cli.studies.sweep import check_results
from orchestrator.figures.short_names import Value, unit_at
from orchestrator.output.report.corners import CENTRE, FILE, corner_lines
from orchestrator.output.report.formatting import interval
from orchestrator.output.tables import console_table
from orchestrator.preflight.cost import in_words
from orchestrator.preflight.material_ranges import Range, RangedContact, corner_sets, ranged_contacts
from orchestrator.studies.points import CaseStudy, Point
from orchestrator.workbench import StudyFolder

Found = Mapping[str, Mapping[str, Value | None]]
"""The results of each run by their names."""


def command(
    study: CaseStudy,
    restitution: Annotated[
        str | None, typer.Option(metavar="LOW:HIGH", help="LOW:HIGH, in place of the library's")
    ] = None,
    rolling_friction: Annotated[
        str | None, typer.Option(metavar="LOW:HIGH", help="LOW:HIGH, in place of the library's")
    ] = None,
    result: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help="result; may be repeated [default: efficiency, velocity]"),
    ] = None,
    dry: Annotated[bool, typer.Option("--dry", help="list the runs, predict their time, and stop")] = False,
) -> StudyOutput:
    """Run a case at the corners of the ranges of its grains' restitution and rolling friction.

    The ranges are the library's.  All contacts of grains are at their low or high ends together: five runs
    with the case as given.  The page of as-given says what was found.
    """
    given = {"restitution": restitution, "rolling_friction": rolling_friction}
    own = {key: _parse_range(key, text) for key, text in given.items() if text is not None}
    wanted = check_results(result or ["efficiency", "velocity"])
    judged = study.check().judged
    contacts = [*ranged_contacts(judged, own)]
    if not any(each.ranges for each in contacts):
        hint = "give --restitution LOW:HIGH and --rolling-friction LOW:HIGH"
        raise CaseError(
            [CaseProblem(("contacts",), "the library has no range of any contact of grains", hint)]
        )
    corners = corner_sets(judged, contacts).items()
    points = [study.point(CENTRE), *(study.point(name, [overlay]) for name, overlay in corners)]
    if dry:
        for point in points:
            yield f"{point.value}: {in_words(point.loaded.predicted_s)} of processor time"
        all_s = sum(point.loaded.predicted_s for point in points)
        yield f"{len(points)} runs, {in_words(all_s)} of processor time; nothing was run"
        return True
    yield from study.run(points)
    found: Found = {point.value: {name: point.run.result(name) for name in wanted} for point in points}
    yield console_table(
        "corners of the materials' ranges",
        ["run", *(f"{name} / {unit_at(name)}" for name in wanted), "status"],
        (
            [point.value, *(interval(found[point.value][name]) for name in wanted), point.status()]
            for point in points
        ),
    )
    yield from write_corners(study.folder, contacts, points, found)
    yield from corner_lines(study.folder / CENTRE)
    return all(point.run.is_trusted for point in points)


def _parse_range(key: str, text: str) -> Range:
    """Return the two numbers of "LOW:HIGH".  Raises CaseError."""
    try:
        low, high = (float(each) for each in text.split(":"))
    except ValueError:
        low, high = 1.0, 0.0
    if not 0.0 <= low < high:
        option = f"--{key.replace('_', '-')} {text}"
        raise CaseError(
            [CaseProblem((), "two numbers from low to high are wanted, such as 0.1:0.5", file=option)]
        )
    return low, high


def write_corners(
    folder: Path, contacts: Sequence[RangedContact], points: Sequence[Point], found: Found
) -> list[Path]:
    """Write the table of the runs and what the page of the centre says, and return the files."""
    rows = [
        {"run": point.value, "status": point.status()}
        | {name: None if value is None else value.value for name, value in found[point.value].items()}
        for point in points
    ]
    results = {}
    for name in found[CENTRE]:
        values = [value.value for run in found.values() if (value := run[name]) is not None]
        if values:
            span = {"from": min(values), "to": max(values)}
            results[name] = {"unit": unit_at(name), **span, "runs": len(values)}
    ranges = [
        {"between": [*contact.between], **{key: [*span] for key, span in contact.ranges.items()}}
        for contact in contacts
    ]
    doubtful = [point.value for point in points if not point.run.is_trusted]
    table = {"results": results, "ranges": ranges, "doubtful": doubtful}
    return [StudyFolder(folder).write_csv("corners.csv", rows), StudyFolder(folder).write_json(FILE, table)]
