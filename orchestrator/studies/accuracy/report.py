"""The output of a study of accuracy: tables for other programs, ``accuracy.json`` for ``flipflow plan``,
pictures, and ``accuracy.html``, which has everything on one page."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter
from rich.table import Table

from orchestrator.case.file.whole import write_json
from orchestrator.studies.accuracy.combinations import (
    ALONE,
    BASE,
    CALIBRATION,
    REFERENCE,
    TOGETHER,
    Combination,
    Error,
)
from orchestrator.studies.accuracy.convergence import MeasuredSeries
from orchestrator.studies.accuracy.plan import FORMAT, NAME
from orchestrator.studies.accuracy.refinement import PARAMETERS
from orchestrator.studies.accuracy.study import RECOMMENDED, AccuracyStudy, ComparedSetting, Row
from orchestrator.studies.quantities import QUANTITIES
from orchestrator.studies.report import (
    Cell,
    align_rows,
    console_table,
    figure_parts,
    percent,
    write_csv,
    write_page,
    write_parquet,
)
from orchestrator.views.style import LINES, figure, save

AXES_OF_MODELS = ("panel", "frames", "particles", "stiffness", "number")
DEEP = 1e4  # the ratio of the largest error to the least error that is drawn
LEAST = 1e-4  # smaller errors are drawn at this value
MARKS = "os^vDPX<>"
RED, BLACK, GREY, GREEN = "#c1443c", "#111111", "#888888", "#0f8a8a"


def write_study(study: AccuracyStudy, folder: Path) -> list[Path]:
    """Write the tables, the pictures and the page of a study, and return their files."""
    lines, stored = entries(study), folder / NAME
    tables = [write_csv(lines, folder / "accuracy.csv"), write_parquet(lines, folder / "accuracy.parquet")]
    write_json(stored, as_json(study))
    plot = draw_costs(study, folder / "work-precision.png")
    axes = [_axis(study, axis, folder) for axis in study.offer.titles]
    known = {name: each for name, each in QUANTITIES.items() if not each.is_defect}
    page = write_page(
        "accuracy/page.html",
        folder / "accuracy.html",
        study=study,
        lacking=[row for row in study.rows if row.why],
        front={row.point.name: number for number, row in enumerate(study.front(), 1)},
        advice=[study.recommend(tolerance) for tolerance in RECOMMENDED],
        warnings=[*warnings(study)],
        quantities={k: q for k, q in known.items() if any(k in row.errors for row in study.rows)},
        every=QUANTITIES,
        defects={name: each for name, each in QUANTITIES.items() if each.is_defect},
        answers={row.what: row for row in study.known},
        titles={name: parameter.title for name, parameter in PARAMETERS.items()},
        percent=percent,
        error=_error_in_words,
        plot=plot,
        axes=axes,
    )
    return [*tables, stored, plot, *(file for each in axes for file in each["files"]), page]


def _axis(study: AccuracyStudy, axis: str, folder: Path) -> dict[str, Any]:
    """Return the page's entry for an axis: its series, its models if it has several, and their pictures."""
    series = [one for one in study.measured_series if one.series.axis == axis]
    every = study.compare_settings(axis)
    models = every if len({each.series.variant for each in every}) > 1 else []
    files = [
        draw_convergence(series, study.judged_by, folder / f"accuracy-{axis}.png"),
        draw_models(models, study.judged_by, folder / f"accuracy-{axis}-models.png"),
    ]
    shown = [file for file in files if file is not None]
    return {"title": study.offer.titles[axis], "series": series, "models": models, "files": shown}


def entries(study: AccuracyStudy) -> list[dict[str, Cell]]:
    """Return the rows of the study's table, all with the same columns; unknown cells are None."""
    every = []
    for row in study.rows:
        point = row.point
        entry: dict[str, Cell] = {
            "point": point.name,
            "kind": REFERENCE if point.name == study.reference else point.kind.replace(REFERENCE, TOGETHER),
            "settings": point.label,
            "sets": shlex.join(point.sets),
            "status": row.why or "done",
            "predicted_processor_s": point.predicted_s,
            "predicted_error": row.proposal.error if row.proposal else None,
            "error": row.error.value if row.error else None,
            "error_half_width": row.error.half_width if row.error else None,
            "error_of": row.worst[0] if row.worst else None,
        }
        if point.metrics:
            entry |= {"seeds": len(point.metrics), **point.cost}
        for name in QUANTITIES:
            if point.values(name):
                entry[name] = point.mean(name)
            if name in row.errors:
                entry[f"{name}_error"] = row.errors[name].value
                entry[f"{name}_error_half_width"] = row.errors[name].half_width
        every.append(entry | {f"against {name}": error for name, error in row.answers.items()})
    return align_rows(every)


def as_json(study: AccuracyStudy) -> dict[str, Any]:
    """Return the content of ``accuracy.json``, which ``flipflow plan`` needs."""
    base, seeds = study.base, len(study.base.metrics)
    chance = (study.spread.half_width(name, (seeds, seeds)) for name in study.judged_by)

    def costs(point: Combination) -> dict[str, Any]:
        simulated_s = point.metrics[0].summary["simulated_s"]
        return {"simulated_s": simulated_s, **point.cost, "processor_by_part_s": point.processor_by_part_s}

    return {
        "format_version": FORMAT,
        "case": study.loaded.name,
        "level": study.loaded.level,
        "read": study.loaded.origin.read(),
        "sets": list(study.request.study.sets),
        "shared": list(study.shared),
        "duration_s": base.metrics[0].summary["simulated_s"],
        "judged_by": study.judged_by,
        "reference": study.reference,
        "seeds": seeds,
        # the largest half width of an error that decides; None where a single seed tells nothing
        "chance": max((width for width in chance if width is not None), default=None),
        "base": costs(base),
        "short": {
            name: costs(one) | {"sets": list(one.sets)}
            for name, one in study.measured.items()
            if one.kind == CALIBRATION
        },
        "remaining": study.remaining_errors,
        "reference_error": study.reference_error,
        "warnings": [*warnings(study)],
        "options": {
            axis: [
                {
                    "label": one.setting.label,
                    "sets": list(one.setting.sets),
                    "error": one.error,
                    "ratio": one.ratio,
                }
                for one in options
            ]
            for axis, options in study.options().items()
        },
        "models": [row for axis in AXES_OF_MODELS for row in _model_rows(study.compare_settings(axis))],
        "points": entries(study),
    }


def _model_rows(models: Sequence[ComparedSetting]) -> Iterator[dict[str, Any]]:
    best = next((each for each in models if each.is_best), None)
    for each in models:
        assert best is not None  # one of the measured settings is always the best
        yield {
            "axis": each.series.axis,
            "variant": each.series.variant,
            "label": each.setting.label,
            "sets": list(each.setting.sets),
            "error": {name: error.value for name, error in each.errors.items()},
            "half_width": {name: error.half_width for name, error in each.errors.items()},
            "processor_s": each.point.processor_s,
            "reference": best.setting.label,
            "reference_processor_s": best.point.processor_s,
        }


def cost_table(study: AccuracyStudy) -> Table:
    """Return a table of the cost and the error of every point for the console, cheap points first."""
    lines = []
    for row in study.by_cost:
        error = ("reference" if row.point.name == study.reference else "", "")
        if row.error is not None:
            error = (percent(row.error.value), percent(row.error.half_width))
        cost = (f"{row.point.processor_s:.1f}", f"{row.point.cost['peak_memory_MiB']:.0f}")
        lines.append((row.point.label, *cost, *error, row.worst[0] if row.worst else ""))
    head = ("settings", "processor / s", "MiB", "error", "+-", "of")
    return console_table(f"error against {study.reference}", head, lines, left=("of",))


def advice(study: AccuracyStudy) -> Iterator[str]:
    """Yield the recommendation for each tolerance as a line for the console."""
    for each in map(study.recommend, RECOMMENDED):
        if each.row is None:
            why = "no point of this study is so good and no dearer than the reference"
            yield f"{100 * each.tolerance:g} %: {why}"
            continue
        sure = "" if each.is_proven else f" (as far as chance lets one see: {study.would_tell} would tell)"
        if each.row.error is None:
            sure = f" (the reference, by the estimate of its own error, {percent(study.reference_error)})"
        words = " ".join(f"--set {one}" for one in each.row.point.sets) or "the case as it is"
        yield f"{100 * each.tolerance:g} %: {words}, {each.row.point.processor_s:.1f} s{sure}"


def warnings(study: AccuracyStudy) -> Iterator[str]:
    """Yield what the reference lacks, as sentences without a full stop."""
    if lost := [row for row in study.rows if row.point.kind == REFERENCE and row.why]:
        yield f"The proposed reference gave no result, and another point serves as reference ({lost[0].why})"
    if study.reference_error is None:
        yield "How far the reference is itself off is unknown: the parameters do not compare all its settings"
    elif study.reference_error:
        left = percent(study.reference_error)
        yield f"The reference is itself off by an estimated {left}, which is in none of the errors"
    for row in study.rows:
        for name, error in row.answers.items() if row.point.name == study.reference else ():
            if error > min(RECOMMENDED):
                yield f"The reference is off by {percent(error)} from a known answer: {name}"


def _error_in_words(errors: Mapping[str, Error], name: str) -> str:
    if name not in errors:
        return ""
    width = errors[name].half_width
    return percent(errors[name].value) + (f" ± {percent(width)}" if width else "")


def _words(name: str) -> str:
    if name == "energy_defect":
        return "energy created by the coupling"
    return QUANTITIES[name].words.split(" / ")[0] if name in QUANTITIES else name


def _scales(axis: Any, across: str, upward: str) -> None:
    """Make both scales of a picture logarithmic, with the errors upward in per cent."""
    axis.set(xscale="log", yscale="log", xlabel=across, ylabel=upward)
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
    axis.yaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    for part in (axis.xaxis, axis.yaxis):
        part.set_minor_formatter(NullFormatter())


Line = tuple[str, list[float], list[float], list[bool], str]
"""The label, lengths and errors of a line, whether each error is more than chance, and the style."""
CHANCE = " (open: chance)"


def draw_convergence(every: Sequence[MeasuredSeries], judged_by: Sequence[str], file: Path) -> Path | None:
    """Draw the convergence of the series of one axis; return the file, or None where nothing converges."""
    shown = [(one, _lines(one, judged_by)) for one in every if len(one.settings) > 1 and one.lengths]
    heights = [y for _, lines in shown for _, _, line_y, *_ in lines for y in line_y]
    if not heights:
        return None
    drawn, parts = figure_parts(len(shown), 1, 8.4, 4.2)
    lowest = max(min(heights), max(heights) / DEEP) / 2
    for axis, (one, lines) in zip(parts, shown, strict=True):
        for (label, x, y, certain, style), mark in zip(lines, MARKS, strict=False):
            (line,) = axis.plot(x, y, style, marker=mark, ms=5, label=label)
            by_chance = [
                (h, size) for h, size, is_certain in zip(x, y, certain, strict=True) if not is_certain
            ]
            for place in by_chance:
                axis.plot(*place, marker=mark, ms=5, color=line.get_color(), mfc="white")
        lengths = one.lengths
        if lines and one.series.expected:
            top = 1.5 * max(y for _, _, line_y, *_ in lines for y in line_y)
            expected = [top * (h / max(lengths)) ** one.series.expected for h in lengths]
            label = f"expected order {one.series.expected:g}"
            axis.plot(lengths, expected, color="#999999", lw=3, alpha=0.5, label=label)
        all_certain = all(each for _, _, _, certain, _ in lines for each in certain)
        _scales(axis, one.series.length, "error" + CHANCE * (not all_certain))
        axis.set_ylim(lowest, 3 * max(heights))
        axis.set_title(one.series.variant or PARAMETERS[one.series.parameter].title)
        axis.xaxis.set_major_locator(FixedLocator(lengths))
        axis.xaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
        axis.tick_params(axis="x", rotation=30)
        if lines:
            axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8.5)
    save(drawn, file)
    return file


def _lines(one: MeasuredSeries, judged_by: Sequence[str]) -> list[Line]:
    """Return the lines of a series: errors against the finest setting solid, against exact answers dashed."""
    lines: list[Line] = []
    finest = one.errors[:-1]
    every = [(name, [e.get(name, Error(0.0)) for e in finest], "-") for name in (*judged_by, "shape")]
    every += [(name, [Error(each.get(name, 0.0)) for each in one.exact], "--") for name in one.exact[0]]
    for name, found, style in every:
        places = [(h, e.value, e.is_certain) for h, e in zip(one.lengths, found, strict=False) if e.value]
        if places:
            x, y, certain = zip(*places, strict=True)
            lines.append((_words(name) + _seen(one, name), [*x], [*y], [*certain], style))
    return lines


def _seen(one: MeasuredSeries, name: str) -> str:
    order = one.orders.get(name)
    return f", order {order.order:.1f}{'' if one.is_clean(name) else '?'}" if order else ""


def draw_models(models: Sequence[ComparedSetting], judged_by: Sequence[str], file: Path) -> Path | None:
    """Draw the error of every model over its cost, with a part for each quantity.

    Numbers beside the marks stand for the settings, whose names would lie over each other.  Return the file,
    or None where there are no errors.
    """
    others = [each for each in models if not each.is_best]
    names = [name for name in (*judged_by, "shape") if any(name in each.errors for each in others)]
    if not names:
        return None
    columns = min(len(names), 2)
    drawn, parts = figure_parts(len(names), columns, 5.6, 4.2)
    variants = list(dict.fromkeys(each.series.variant for each in models))
    looks = [_look(variants.index(each.series.variant)) for each in others]
    for axis, name in zip(parts, names, strict=True):
        for number, (each, look) in enumerate(zip(others, looks, strict=True), 1):
            if name in each.errors:
                place = each.point.processor_s, max(each.errors[name].value, LEAST)
                open_mark = {} if each.errors[name].is_certain else {"facecolors": "none"}
                axis.scatter(*place, s=38, **look, **open_mark)
                beside = ((6, 4), (6, -11), (-12, 4), (-12, -11))[number % 4]
                axis.annotate(str(number), place, beside, textcoords="offset points", fontsize=8)
        all_certain = all(each.errors[name].is_certain for each in others if name in each.errors)
        upward = "error against the best model" + CHANCE * (not all_certain)
        _scales(axis, "processor time of one run / s", upward)
        axis.set_title(_words(name))
        axis.margins(x=0.1, y=0.15)
    keys = [parts[columns - 1].scatter([], [], s=38, **look) for look in looks]
    labels = [f"{number}  {each.setting.label}" for number, each in enumerate(others, 1)]
    parts[columns - 1].legend(keys, labels, loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8.5)
    save(drawn, file)
    return file


def _look(number: int) -> dict[str, str]:
    return {"marker": MARKS[number % len(MARKS)], "color": LINES[number % len(LINES)]}


def draw_costs(study: AccuracyStudy, file: Path) -> Path:
    """Draw the error of all points over their cost, with a line through the points that no other beats."""
    drawn, ((axis,),) = figure(width=9.6, height=5.6)
    front, shown = study.front(), [row for row in study.rows if row.error is not None]
    if front:
        axis.plot(*_places(front), color=GREY, lw=1.2, zorder=1, label="nothing is better in both")
    groups = [
        (
            [r for r in shown if r.point.kind == ALONE and name in r.point.settings],
            f"{title} only",
            _look(number),
        )
        for number, (name, title) in enumerate(study.offer.titles.items())
    ]
    together = [row for row in shown if row.point.kind in (TOGETHER, REFERENCE)]
    groups.append((together, "several together", {"marker": "*", "color": BLACK}))
    own = [row for row in shown if row.point.kind == BASE]
    groups.append((own, "the case as it is", {"marker": "o", "color": RED}))
    for rows, label, look in groups:
        if rows:
            x, y = _places(rows)
            axis.scatter(x, y, s=90 if look["marker"] == "*" else 34, label=label, zorder=3, **look)
            widths = [_width(row) for row in rows]
            low, high = (
                [max(h + sign * w, LEAST) for h, w in zip(y, widths, strict=True)] for sign in (-1, 1)
            )
            axis.vlines(x, low, high, color=look["color"], lw=0.9, alpha=0.6, zorder=2)
    for number, place in enumerate(zip(*_places(front), strict=True), 1):
        near = {"textcoords": "offset points", "fontsize": 9, "weight": "bold"}
        axis.annotate(str(number), place, (6, 5), **near)
    if any(_width(row) for row in study.rows):
        axis.plot([], [], color=GREY, lw=0.9, label="where chance leaves it (95 %)")
    _scales(axis, "processor time of one run / s", "largest error of what decides, against the reference")
    reference_s = study.measured[study.reference].processor_s
    axis.axvline(reference_s, color=GREY, ls=":", lw=1)
    note = {"rotation": 90, "ha": "right", "va": "top", "fontsize": 8.5, "color": GREY}
    axis.text(reference_s, 0.98, "the reference ", transform=axis.get_xaxis_transform(), **note)
    for tolerance in RECOMMENDED:
        axis.axhline(tolerance, color=GREEN, lw=0.8, ls="--", zorder=0)
    axis.set_ylim(bottom=LEAST / 2 if axis.get_ylim()[0] < LEAST else None)
    axis.margins(x=0.12, y=0.12)
    axis.set_title(f"What accuracy costs: {study.loaded.name}, down and left is better")
    axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8.5)
    save(drawn, file)
    return file


def _places(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    heights = [max(row.error.value if row.error else 0.0, LEAST) for row in rows]
    return [row.point.processor_s for row in rows], heights


def _width(row: Row) -> float:
    return (row.error.half_width or 0.0) if row.error else 0.0
