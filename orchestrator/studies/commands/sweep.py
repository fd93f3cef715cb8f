"""``flipflow study sweep``: runs of a case over the values of one key or of several keys."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

import typer

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.figures.results import FIGURES, entry_at, orbit_places, why_no_orbits
from orchestrator.figures.short_names import named, value_at
from orchestrator.output.records import trust
from orchestrator.output.results.machine import LARGEST_DRIFT
from orchestrator.output.results.tidy import single_numbers
from orchestrator.preflight.cost import in_words, particles_at_start, predicted_s
from orchestrator.studies.options import StudyOutput
from orchestrator.studies.points import MOST_VALUES, CaseStudy, Point, Vary, parse_vary, summary_of
from orchestrator.studies.report import Cell, figure_parts, write_csv, write_parquet
from orchestrator.studies.sweep_plan import Arrangement, SweepPlan, check_names, plan_sweep
from orchestrator.studies.sweep_results import (
    LOOKS,
    SweptSetting,
    draw_results,
    results_of,
    results_table,
    show_given_units,
    transient_words,
)
from orchestrator.views.style import save

AXES = {0: "x", 2: "z"}
SETTLED, NOT_SETTLED = "yes", "no"
DRAWN = ("screening.efficiency_percent", "bed.velocity_m_per_s", "bed.largest_depth_m", "bed.on_deck_kg")
"""Results that are drawn beside the amplitudes, where a sweep has them."""

Row = dict[str, Cell]
Part = tuple[str, list[tuple[str, str]], float]
"""A part of the picture: its label, the columns with their names, and the scale."""


def command(
    study: CaseStudy,
    vary: Annotated[
        list[str],
        typer.Option(
            metavar="KEY=VALUES",
            help="values as a,b,c or first:last:step (both ends); may be repeated for several keys",
        ),
    ],
    plan: Annotated[
        Arrangement,
        typer.Option(
            help="grid: all combinations; list: the first values of all keys, the second, and so on; "
            "random: values between first:last, or of a list"
        ),
    ] = Arrangement.GRID,
    number: Annotated[int, typer.Option(min=1, max=MOST_VALUES, help="number of runs of a random plan")] = 10,
    seed: Annotated[int, typer.Option(min=0, help="of a random plan")] = 1,
    result: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help="result to be printed and drawn, by its short name or path; may be repeated"
        ),
    ] = None,
    dry: Annotated[
        bool, typer.Option("--dry", help="check and list the runs, predict their time, and stop")
    ] = False,
) -> StudyOutput:
    """Run a case over values of one key, or of several keys.

    Each setting has a run of its own in a folder of its own.  Called again, the command makes only the
    missing runs; --dry lists and predicts them.  sweep.csv and sweep.parquet have a row for each setting:
    amplitudes of the first harmonic along (x) and normal to the deck (z) of the frames, of probes on frames,
    and of the frames against each other; their drift; every single number of the results with its interval;
    and each --result.  In sweep.png, a value that has not settled has an open mark, and a value that cannot
    be trusted is a cross.  results.png has each --result with its interval, and the same marks.
    """
    wanted = _check_results(result)
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
    yield from study.run(points)
    rows = sweep_rows(settings, points, wanted)
    if isinstance(settings, Vary):
        yield from write_sweep(settings, points, study.folder, wanted)
    else:
        yield write_csv(rows, study.folder / "sweep.csv")
    yield write_parquet(rows, study.folder / "sweep.parquet")
    if wanted:
        measured = [
            SweptSetting(
                settings.setting_of(p),
                p.status(),
                results_of(p, wanted),
                transient_words(p),
                settings.given_of(p),
            )
            for p in points
        ]
        yield results_table(settings.keys, measured, wanted)
        yield from draw_results(settings.keys, measured, wanted, study.folder / "results.png")
    return all(point.status() == trust.DONE for point in points)


def _predictions(settings: Vary | SweepPlan, points: Sequence[Point], workers: int) -> Iterator[str]:
    """Yield a line for each run with its predicted processor time, and one for those that are left."""
    left_s = []
    for point in points:
        texts = settings.setting_of(point) | settings.given_of(point)
        what = ", ".join(f"{key} = {text}" for key, text in texts.items())
        if point.done():
            yield f"{what}: done before"
        else:
            case = point.loaded.case
            left_s.append(predicted_s(case, particles_at_start(case)))
            yield f"{what}: {in_words(left_s[-1])} of one processor"
    yield (
        f"{len(left_s)} of {len(points)} runs are to be made, {in_words(sum(left_s))} of one processor, "
        f"{workers} at a time (predicted, good to a factor of three); nothing was run"
    )


def _check_results(names: Sequence[str] | None) -> tuple[str, ...]:
    """Return the names of the wanted results.  Raises CaseError for a name that is none."""
    problems = []
    for name in names or ():
        try:
            named(name)
        except KeyError as error:
            problems.append(CaseProblem((), str(error.args[0]), file=f"--result {name}", kind="unknown-name"))
    if problems:
        raise CaseError(problems)
    return tuple(names or ())


def write_sweep(vary: Vary, points: Sequence[Point], folder: Path, wanted: Sequence[str] = ()) -> list[Path]:
    """Write ``sweep.csv`` and ``sweep.png``, and return the files.

    There is a picture only where the values are numbers and two or more runs came to their end.
    """
    rows = sweep_rows(vary, points, wanted)
    files = [write_csv(rows, folder / "sweep.csv")]
    ended = [row for row in rows if trust.came_to_its_end(str(row["status"]))]
    try:
        values = [float(str(row[vary.key])) for row in ended]
    except ValueError:
        return files
    parts = _parts_of_the_picture(ended)
    if len(values) > 1 and parts:
        files.append(_plot(ended, values, parts, vary, folder / "sweep.png"))
    return files


def sweep_rows(vary: Vary | SweepPlan, points: Sequence[Point], wanted: Sequence[str] = ()) -> list[Row]:
    """Return a row for each point.

    The first columns are the varied keys, in their own units.  ``status`` is the state of the run,
    ``<key>.given`` a value with the unit in which it was given, ``settled`` says whether its motion had
    settled, and ``drift`` how much the amplitudes still changed.
    There are amplitudes of the first harmonic along (x) and normal to the deck (z) of every frame, of every
    probe on a frame, and of the frames against each other, with their half widths.  Every single number of
    the run's results follows, with the half width of its interval, and the results ``wanted`` by name.
    """
    rows: list[Row] = []
    for point in points:
        summary = summary_of(point.folder)
        row: Row = {**vary.setting_of(point), "status": point.status()}
        row |= {f"{key}.given": text for key, text in vary.given_of(point).items()}
        if trust.came_to_its_end(str(summary.get("status"))):
            row |= _motion(summary) | dict(single_numbers(summary.get("results") or {}))
            for name, value in results_of(point, wanted).items():
                row[name] = value.value
                row[f"{name}.half_width"] = value.half_width
        rows.append(row)
    return rows


def _motion(summary: Mapping[str, Any]) -> Row:
    """Return the columns of the motion: whether it had settled, and the amplitudes with their half widths."""
    places = orbit_places(summary)
    if not places:
        return {"settled": f"unknown: {why_no_orbits(summary)}"}
    motion = entry_at(summary, "results.motion")
    row: Row = {"settled": SETTLED if motion["is_settled"] else NOT_SETTLED}
    row["speed_rad_per_s"] = motion.get("speed_rad_per_s", 2 * math.pi / summary["cycle_s"])
    if motion["drift"] is not None:
        row["drift"] = motion["drift"]
    for name, place in places.items():
        for axis, letter in AXES.items():
            for key, ending in (("amplitude_m", ""), ("half_width_m", ".half_width")):
                if (number := value_at(summary, f"{place}.{key}.{axis}")) is not None:
                    row[f"{name}.{letter}_m{ending}"] = number.value
    return row


def _parts_of_the_picture(rows: Sequence[Row]) -> list[Part]:
    columns = list(dict.fromkeys(name for row in rows for name in row if name.count(".") == 1))
    parts: list[Part] = []
    for letter, where in (("x", "along"), ("z", "normal to")):
        ending = f".{letter}_m"
        names = [(name, name.removesuffix(ending)) for name in columns if name.endswith(ending)]
        if names:
            parts.append((f"amplitude {where} the deck / mm", names, 1e3))
    figures = {name: FIGURES[f"results.{name}"] for name in DRAWN if name in columns}
    return parts + [(each.label, [(name, "")], each.shown_scale) for name, each in figures.items()]


def _plot(
    rows: Sequence[Row], values: Sequence[float], parts: Sequence[Part], vary: Vary, file: Path
) -> Path:
    """Draw columns over the varied value, with intervals, and return the file.

    A line joins only good points that are neighbours.
    """
    drawn, every = figure_parts(len(parts), 2, 5.5, 4.5)
    for axes, (label, names, scale) in zip(every, parts, strict=True):
        for number, (column, name) in enumerate(names):
            colour, line = f"C{number}", []
            axes.plot([], [], "o-", ms=4, lw=1, color=colour, label=name)
            for value, row in sorted(zip(values, rows, strict=True), key=lambda pair: pair[0]):
                if column in row:
                    keys = (column, f"{column}.half_width")
                    height, width = (scale * float(row.get(key) or 0.0) for key in keys)
                    look = _look(row, column)
                    line.append((value, height if look == "good" else math.nan))
                    axes.errorbar(value, height, width, color=colour, capsize=2, ls="", **LOOKS[look])
            axes.plot([x for x, _ in line], [y for _, y in line], lw=1, color=colour)
        axes.set(xlabel=vary.key, ylabel=label, ylim=(0, 1.05 * axes.get_ylim()[1]))
        show_given_units(
            axes, {x: str(row.get(f"{vary.key}.given", "")) for x, row in zip(values, rows, strict=True)}
        )
        if any(name for _, name in names):
            axes.legend(fontsize=8)
    drawn.suptitle(
        f"filled: settled; open: not settled (drift above {100 * LARGEST_DRIFT:g} %; no steady "
        "state of the bed) or unknown; cross: the run is not to be trusted, or incomplete",
        fontsize=9,
        x=0.01,
        ha="left",
    )
    save(drawn, file)
    return file


def _look(row: Row, column: str) -> str:
    """Return the look of a value's mark: "good", "open" where it has not settled, or "cross" without trust.

    Values of the bed count as settled in the steady state of the bed.
    """
    if not trust.is_trusted(str(row["status"])):
        return "cross"
    steady = row.get("steady.is_steady") if column in DRAWN else row["settled"] == SETTLED
    return "good" if steady else "open"
