"""Pictures of a study of accuracy: convergence of each parameter, models, and error against cost."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from matplotlib.lines import Line2D
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter

from orchestrator.studies.accuracy import layers
from orchestrator.studies.accuracy.combinations import ALONE, BASE, REFERENCE, TOGETHER, Error
from orchestrator.studies.accuracy.convergence import MeasuredSeries
from orchestrator.studies.accuracy.layers import Mark, scenes_of
from orchestrator.studies.accuracy.study import RECOMMENDED, AccuracyStudy, ComparedSetting, Row
from orchestrator.workbench import Metrics, Picture

DEEP = 1e4  # the ratio of the largest error to the least error that is drawn
LEAST = 1e-6  # smaller errors are drawn at this value
TOO_SHORT = 0.3  # error of a shorter run from which on it is not drawn: it says nothing of the longer one
BESIDE = 1.6  # ratio of the errors of bands whose names would lie over each other
MARKS = "os^vDPX<>"
RED, BLACK, GREY, GREEN = "#c1443c", "#111111", "#888888", "#0f8a8a"


def _words(name: str) -> str:
    if name == "energy_defect":
        return "energy created by the coupling"
    return Metrics.quantities[name].words.split(" / ")[0] if name in Metrics.quantities else name


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
    drawn = Picture(len(shown), 1, 8.4, 4.2)
    lowest = max(min(heights), max(heights) / DEEP) / 2
    for axis, (one, lines) in zip(drawn.parts, shown, strict=True):
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
        axis.set_title(one.series.variant or one.series.title)
        axis.xaxis.set_major_locator(FixedLocator(lengths))
        axis.xaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
        axis.tick_params(axis="x", rotation=30)
        if lines:
            axis.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8.5)
    return drawn.save(file)


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
    drawn = Picture(len(names), columns, 5.6, 4.2)
    parts = drawn.parts
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
    return drawn.save(file)


def _look(number: int) -> dict[str, str]:
    return {"marker": MARKS[number % len(MARKS)], "color": Picture.colours[number % len(Picture.colours)]}


def draw_layers(marks: Sequence[Mark], file: Path) -> Path:
    """Draw the layers of every scene: numerics in decades over cost, and bands that no numerics change."""
    scenes = scenes_of(marks)
    columns = min(3, len(scenes))
    drawn = Picture(len(scenes), columns, 5.2, 4.6, margin=0.0 if len(scenes) > 1 else 2.4)
    curves = list(dict.fromkeys(mark.curve for mark in marks if mark.layer == layers.NUMERICS))
    looks = {curve: _look(number) for number, curve in enumerate(curves)}
    for axis, (title, of_scene) in zip(drawn.parts, scenes.items(), strict=True):
        _draw_scene(axis, title, of_scene, looks)
    keys = [
        Line2D([], [], ms=6, label=curve, marker=look["marker"], color=look["color"])
        for curve, look in looks.items()
    ]
    keys += [
        Line2D([], [], marker="*", color=BLACK, ls="", ms=9, label="several together"),
        Line2D([], [], marker="o", color=RED, ls="", ms=10, mfc="none", label="the case as it is"),
        Line2D([], [], marker="o", color=GREY, ls="", mfc="white", label="within chance"),
        Line2D([], [], marker="x", color=RED, ls="", ms=7, label="doubtful, or ended early"),
        Line2D([], [], color=BLACK, ls="--", lw=0.9, label="no numerics change it"),
    ]
    free = drawn.grid.flat[len(scenes)] if len(scenes) < drawn.grid.size else None
    if free is not None:
        free.legend(handles=keys, loc="center left", fontsize=9.5)
    else:
        drawn.parts[columns - 1].legend(
            handles=keys, loc="upper left", bbox_to_anchor=(1.01, 1.0), fontsize=8.5
        )
    return drawn.save(file)


def _draw_scene(axis: Any, title: str, marks: Sequence[Mark], looks: Mapping[str, dict[str, str]]) -> None:
    shown = [m for m in marks if m.layer in (layers.NUMERICS, layers.TOGETHER) and m.error and m.s_per_s]
    bands = [m for m in marks if m.layer not in (layers.NUMERICS, layers.TOGETHER, layers.LOST) and m.error]
    bands = [m for m in bands if m.layer != layers.STATISTICS or (m.error or 0.0) < TOO_SHORT]
    for curve, look in looks.items():
        of_curve = [mark for mark in shown if mark.curve == curve]  # from coarse to fine
        axis.plot(*_spots(of_curve), color=look["color"], lw=1.1, alpha=0.8)
    for mark in shown:
        look = looks.get(mark.curve, {"marker": "*", "color": BLACK})
        size = 9.0 if mark.layer == layers.TOGETHER else 5.5
        grey = {"color": GREY, "mfc": "white"} if mark.is_chance else {"color": look["color"]}
        axis.plot(mark.s_per_s, mark.error, look["marker"], ms=size, **grey)
        if mark.is_own:
            axis.plot(mark.s_per_s, mark.error, "o", ms=11, color=RED, mfc="none")
    _scales(axis, "processor time per simulated second / s", "error")
    axis.set_title(title)
    axis.margins(x=0.08, y=0.08)
    for mark in bands:
        colour = GREY if mark.layer == layers.CHANCE else BLACK
        axis.axhline(mark.error, color=colour, ls="--", lw=0.9, zorder=0)
        if mark.layer == layers.CHANCE:
            axis.axhspan(axis.get_ylim()[0] / 1e3, mark.error, color=GREY, alpha=0.10, lw=0, zorder=0)
    heights = [m.error for m in (*shown, *bands) if m.error]
    if heights:
        axis.set_ylim(min(heights) / 2, 6 * max(heights))
    for mark in marks:
        if mark.layer == layers.LOST and mark.s_per_s:
            axis.plot(mark.s_per_s, 0.97, "x", color=RED, ms=7, transform=axis.get_xaxis_transform())
    near = {"fontsize": 7.5, "color": BLACK, "ha": "right", "va": "bottom"}
    for error, names in _band_names(bands):
        axis.text(0.995, error, names, transform=axis.get_yaxis_transform(), **near)


def _band_names(bands: Sequence[Mark]) -> Iterator[tuple[float, str]]:
    """Yield where names of bands stand, and the names; those of bands too near to each other are joined."""
    groups: list[list[Mark]] = []
    for mark in sorted(bands, key=lambda mark: -(mark.error or 0.0)):
        if groups and BESIDE * (mark.error or 0.0) >= (groups[-1][0].error or 0.0):
            groups[-1].append(mark)
        else:
            groups.append([mark])
    for group in groups:
        labels: dict[str, list[str]] = {}
        for mark in group:
            labels.setdefault(mark.curve, []).append(mark.label)
        yield group[0].error or 0.0, "; ".join(f"{curve}: {', '.join(of)}" for curve, of in labels.items())


def _spots(marks: Sequence[Mark]) -> tuple[list[float], list[float]]:
    return [m.s_per_s or 0.0 for m in marks], [m.error or 0.0 for m in marks]


def draw_costs(study: AccuracyStudy, file: Path) -> Path:
    """Draw the error of all points over their cost, with a line through the points that no other beats."""
    drawn = Picture(1, 1, 9.6, 5.6)
    (axis,) = drawn.parts
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
            size, (x, y) = 90 if look["marker"] == "*" else 34, _places(rows)
            sure, unsure = ([r for r in rows if r.error and r.error.is_certain is it] for it in (True, False))
            axis.scatter(*_places(sure), s=size, label=label, zorder=3, **look)
            by_chance = {"marker": look["marker"], "facecolors": "white", "edgecolors": GREY}
            axis.scatter(*_places(unsure), s=size, zorder=3, **by_chance)
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
    return drawn.save(file)


def _places(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    heights = [max(row.error.value if row.error else 0.0, LEAST) for row in rows]
    return [row.point.processor_s for row in rows], heights


def _width(row: Row) -> float:
    return (row.error.half_width or 0.0) if row.error else 0.0
