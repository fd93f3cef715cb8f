"""``flipflow study corners``: a case at the corners of the ranges of restitution and rolling friction."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Annotated, Any

import typer

from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.whole import write_json
from orchestrator.case.materials.library import look_up, restitution_range, rolling_friction_range, slug
from orchestrator.case.tables.case import Contact
from orchestrator.figures.short_names import unit_at, value_at
from orchestrator.output.records import trust
from orchestrator.output.report.corners import CENTRE, FILE, corner_lines
from orchestrator.output.report.formatting import interval
from orchestrator.preflight.cost import in_words, particles_at_start, predicted_s
from orchestrator.preflight.judge import JudgedCase
from orchestrator.studies.commands.sweep import check_results
from orchestrator.studies.options import StudyOutput
from orchestrator.studies.points import CaseStudy, Point, summary_of
from orchestrator.studies.report import console_table, write_csv

Range = tuple[float, float]
KEYS = ("restitution", "rolling_friction")
ENDS = ("low", "high")


@dataclass(frozen=True)
class Ranged:
    """A contact of grains with the ranges of its coefficients by key; what has none stays as it is given."""

    between: tuple[str, str]
    ranges: Mapping[str, Range]

    def at(self, ends: Mapping[str, int]) -> dict[str, Any]:
        """Return the row of ``contacts`` at some ends of the ranges: 0 the low one, 1 the high one."""
        return {"between": [*self.between]} | {key: values[ends[key]] for key, values in self.ranges.items()}


def command(
    study: CaseStudy,
    restitution: Annotated[
        str | None,
        typer.Option(metavar="LOW:HIGH", help="range for all contacts of grains, in place of the library's"),
    ] = None,
    rolling_friction: Annotated[
        str | None,
        typer.Option(metavar="LOW:HIGH", help="range for all contacts of grains, in place of the library's"),
    ] = None,
    result: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME",
            help="result by its short name or path; may be repeated [default: efficiency, velocity]",
        ),
    ] = None,
    dry: Annotated[bool, typer.Option("--dry", help="list the runs, predict their time, and stop")] = False,
) -> StudyOutput:
    """Run a case at the corners of the ranges of its grains' restitution and rolling friction.

    The ranges are those of the library of materials and of the shapes of grains, until the coefficients are
    measured.  All contacts of grains are at their low or at their high ends together: five runs with the case
    as it is given.  What has no range stays as it is.  corners.csv has a row for each run, and the page of
    the run as-given says what was found.
    """
    given = {"restitution": restitution, "rolling_friction": rolling_friction}
    own = {key: _parse_range(key, text) for key, text in given.items() if text is not None}
    wanted = check_results(result or ["efficiency", "velocity"])
    loaded = study.check()
    contacts = [*_ranged(loaded, own)]
    if not any(each.ranges for each in contacts):
        hint = "give --restitution LOW:HIGH and --rolling-friction LOW:HIGH"
        raise CaseError(
            [CaseProblem(("contacts",), "the library has no range of any contact of grains", hint)]
        )
    points = [study.point(CENTRE), *_corners(study, loaded, contacts)]
    if dry:
        times_s = [predicted_s(point.loaded.case, particles_at_start(point.loaded.case)) for point in points]
        for point, time_s in zip(points, times_s, strict=True):
            yield f"{point.value}: {in_words(time_s)} of one processor"
        yield f"{len(points)} runs, {in_words(sum(times_s))} of one processor; nothing was run"
        return True
    yield from study.run(points)
    found = {point.value: _results(point, wanted) for point in points}
    yield console_table(
        "corners of the materials' ranges",
        ["run", *(f"{name} / {unit_at(name)}" for name in wanted), "status"],
        (
            [point.value, *(interval(found[point.value][name]) for name in wanted), point.status()]
            for point in points
        ),
    )
    rows = [
        {"run": point.value, "status": point.status()}
        | {name: None if value is None else value.value for name, value in found[point.value].items()}
        for point in points
    ]
    yield write_csv(rows, study.folder / "corners.csv")
    yield _write(study, contacts, points, found)
    yield from corner_lines(study.folder / CENTRE)
    return all(point.status() == trust.DONE for point in points)


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


def _ranged(loaded: JudgedCase, own: Mapping[str, Range]) -> Iterator[Ranged]:
    """Yield the contacts of grains that have a range."""
    case, grains = loaded.case, set(smallest_grains(loaded.case))
    for row in case.contacts:
        ranges = {key: own.get(key) or _library_range(loaded, row, key) for key in KEYS}
        if row.rebound and "restitution" not in own:
            ranges["restitution"] = None  # the case knows better
        known = {key: values for key, values in ranges.items() if values is not None}
        if grains & set(row.between):
            yield Ranged(row.between, known)


def _library_range(loaded: JudgedCase, row: Contact, key: str) -> Range | None:
    if key == "rolling_friction":
        return rolling_friction_range(*(loaded.case.materials[name].shape for name in row.between))
    given = loaded.layers.merged.get("materials", {})
    one, other = (look_up(str(given.get(name, {}).get("like", name))) for name in row.between)
    return None if one is None or other is None else restitution_range(one, other)


def _corners(study: CaseStudy, loaded: JudgedCase, contacts: Sequence[Ranged]) -> Iterator[Point]:
    keys = [key for key in KEYS if any(key in each.ranges for each in contacts)]
    for ends in product((0, 1), repeat=len(keys)):
        at = dict(zip(keys, ends, strict=True))
        name = "-".join(f"{ENDS[end]}-{key.replace('_', '-')}" for key, end in at.items())
        changed = [each.at(at) for each in contacts if each.ranges]
        yield study.point(name, [f"contacts={_inline(_rows(loaded, changed))}"])


def _rows(loaded: JudgedCase, changed: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows of ``contacts`` as the user gave them, with other coefficients, and added ones."""
    left = {frozenset(row["between"]): row for row in changed}
    rows = []
    for row in loaded.layers.merged.get("contacts", []):
        names = frozenset(name if name in loaded.case.materials else slug(name) for name in row["between"])
        rows.append({**row, **left.pop(names, {}), "between": row["between"]})
    return [*rows, *map(dict, left.values())]


def _inline(value: Any) -> str:
    """Return a value as TOML in one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_inline(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return json.dumps(value)


def _results(point: Point, wanted: Sequence[str]) -> dict[str, Any]:
    summary = summary_of(point.folder)
    return {name: value_at(summary, name) for name in wanted}


def _write(
    study: CaseStudy,
    contacts: Sequence[Ranged],
    points: Sequence[Point],
    found: Mapping[str, Mapping[str, Any]],
) -> Any:
    """Write what the page of the centre says, and return the file."""
    values = {
        name: [found[point.value][name].value for point in points if found[point.value][name] is not None]
        for name in found[CENTRE]
    }
    doubtful = [point.value for point in points if point.status() != trust.DONE]
    table = {
        "results": {
            name: {"unit": unit_at(name), "from": min(each), "to": max(each), "runs": len(each)}
            for name, each in values.items()
            if each
        },
        "ranges": [
            {"between": [*contact.between], **{key: [*span] for key, span in contact.ranges.items()}}
            for contact in contacts
        ],
        "doubtful": doubtful,
    }
    file = study.folder / FILE
    write_json(file, table)
    return file
