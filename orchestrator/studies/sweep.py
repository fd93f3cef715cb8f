"""The table and the picture of a sweep: runs of a case over the values of one key or of several keys."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from orchestrator.studies.points import Point, Vary
from orchestrator.studies.sweep_plan import SweepPlan
from orchestrator.studies.sweep_results import LOOKS, results_of, show_given_units
from orchestrator.workbench import Picture, Run, StudyFolder
from orchestrator.workbench.vocabulary import Cell

AXES = {0: "x", 2: "z"}
SETTLED, NOT_SETTLED = "yes", "no"
DRAWN = ("screening.efficiency_percent", "bed.velocity_m_per_s", "bed.largest_depth_m", "bed.on_deck_kg")
"""Results that are drawn beside the amplitudes, where a sweep has them."""

Row = dict[str, Cell]
Part = tuple[str, list[tuple[str, str]], float]
"""A part of the picture: its label, the columns with their names, and the scale."""


def write_sweep(vary: Vary, points: Sequence[Point], folder: Path, wanted: Sequence[str] = ()) -> list[Path]:
    """Write ``sweep.csv`` and ``sweep.png``, and return the files.

    There is a picture only where the values are numbers and two or more runs came to their end.
    """
    rows = sweep_rows(vary, points, wanted)
    files = [StudyFolder(folder).write_csv("sweep.csv", rows)]
    ended = [row for row, point in zip(rows, points, strict=True) if point.run.came_to_its_end()]
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
        run = point.run
        row: Row = {**vary.setting_of(point), "status": run.status}
        row |= {f"{key}.given": text for key, text in vary.given_of(point).items()}
        if run.came_to_its_end():
            row |= _motion(run) | run.single_numbers
            for name, value in results_of(run, wanted).items():
                row[name] = value.value
                row[f"{name}.half_width"] = value.half_width
        rows.append(row)
    return rows


def _motion(run: Run) -> Row:
    """Return the columns of the motion: whether it had settled, and the amplitudes with their half widths."""
    places = run.orbits
    if not places:
        return {"settled": f"unknown: {run.why_no_orbits}"}
    motion = run.entry("results.motion")
    row: Row = {"settled": SETTLED if motion["is_settled"] else NOT_SETTLED}
    row["speed_rad_per_s"] = motion.get("speed_rad_per_s", 2 * math.pi / run.summary["cycle_s"])
    if motion["drift"] is not None:
        row["drift"] = motion["drift"]
    for name, place in places.items():
        for axis, letter in AXES.items():
            for key, ending in (("amplitude_m", ""), ("half_width_m", ".half_width")):
                if (number := run.result(f"{place}.{key}.{axis}")) is not None:
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
    figures = {name: Run.named(f"results.{name}").figure for name in DRAWN if name in columns}
    return parts + [(each.label, [(name, "")], each.shown_scale) for name, each in figures.items()]


def _plot(
    rows: Sequence[Row], values: Sequence[float], parts: Sequence[Part], vary: Vary, file: Path
) -> Path:
    """Draw columns over the varied value, with intervals, and return the file.

    A line joins only good points that are neighbours.
    """
    drawn = Picture(len(parts), 2, 5.5, 4.5)
    for axes, (label, names, scale) in zip(drawn.parts, parts, strict=True):
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
    drawn.figure.suptitle(
        f"filled: settled; open: not settled (drift above {100 * Run.largest_drift:g} %; no steady "
        "state of the bed) or unknown; cross: the run is not to be trusted, or incomplete",
        fontsize=9,
        x=0.01,
        ha="left",
    )
    return drawn.save(file)


def _look(row: Row, column: str) -> str:
    """Return the look of a value's mark: "good", "open" where it has not settled, or "cross" without trust.

    Values of the bed count as settled in the steady state of the bed.
    """
    if row["status"] != "done":
        return "cross"
    steady = row.get("steady.is_steady") if column in DRAWN else row["settled"] == SETTLED
    return "good" if steady else "open"
