"""``accuracy.html``: a study on one page that holds everything in itself, with its pictures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
from matplotlib.ticker import FixedLocator, LogLocator, NullFormatter

from orchestrator.output.records.run_folder import write_text
from orchestrator.output.report.drawing import LINES, data_uri, figure, fill_template, save
from orchestrator.studies.accuracy.combinations import ALONE, BASE, REFERENCE, TOGETHER
from orchestrator.studies.accuracy.convergence import Compared, Converged, Order, compare_axis
from orchestrator.studies.accuracy.measured import Error
from orchestrator.studies.accuracy.refinement import PARAMETERS
from orchestrator.studies.accuracy.study import Study
from orchestrator.studies.accuracy.tables import RECOMMENDED, Row, pareto, recommended
from orchestrator.studies.metrics import DEFECTS, QUANTITIES
from orchestrator.studies.tables import percent

DEEP = 1e4  # what is so much smaller than the largest error is not shown
ABREAST = 2
MARKS = "os^vDPX<>"
WORDS = {name: quantity.words for name, quantity in QUANTITIES.items()}
WORDS["energy_defect"] = "energy created by the coupling"


def convergence(families: Sequence[Converged], judged_by: Sequence[str], path: Path) -> Path | None:
    """Of the families of one axis; None where nothing converges."""
    shown = [one for one in families if len(one.found) > 1 and one.found[0][0].h is not None]
    every = [_lines(one, judged_by) for one in shown]
    heights = [y for lines in every for _, _, line_y, _ in lines for y in line_y]
    if not heights:
        return None
    drawn, parts = _parts(len(shown), 5.2)
    lowest = max(min(heights), max(heights) / DEEP) / 2
    for axis, one, lines in zip(parts, shown, every, strict=True):
        _draw(axis, one, lines)
        axis.set_ylim(lowest, 3 * max(heights))
    save(drawn, path)
    return path


def _parts(count: int, width: float) -> tuple[Any, list[Any]]:
    """Returns a figure of so many parts, each so wide in inches, and its axes."""
    rows, columns = -(-count // ABREAST), min(count, ABREAST)
    drawn, grid = figure(rows, columns, width * columns, 4.2 * rows)
    for axis in grid.flat[count:]:
        axis.axis("off")
    return drawn, list(grid.flat[:count])


Line = tuple[str, list[float], list[float], str]


def _lines(one: Converged, judged_by: Sequence[str]) -> list[Line]:
    """Label, h, error and style of each quantity: against the finest setting, or dashed, against
    what is known exactly."""
    lengths = [setting.h or 0.0 for setting, _ in one.found]
    found: list[Line] = []
    for name in (*judged_by, "shape"):
        sizes = [each[name].value if name in each else 0.0 for each in one.errors[:-1]]
        found.append((_label(name, one.orders.get(name)), lengths[:-1], sizes, "-"))
    for name in one.exact[0]:
        sizes = [each.get(name, 0.0) for each in one.exact]
        found.append((_label(name, one.orders.get(name)), lengths, sizes, "--"))
    return [
        (label, [x for x, y in zip(h, sizes, strict=True) if y], [y for y in sizes if y], style)
        for label, h, sizes, style in found
        if any(sizes)
    ]


def _label(name: str, order: Order | None) -> str:
    seen = f", order {order.order:.1f}{'' if order.clean else '?'}" if order else ""
    return WORDS.get(name, name).split(" / ")[0] + seen


def _draw(axis: Any, one: Converged, lines: Sequence[Line]) -> None:
    for (label, x, y, style), mark in zip(lines, MARKS, strict=False):
        axis.plot(x, y, style, marker=mark, ms=5, label=label)
    lengths = [setting.h or 0.0 for setting, _ in one.found]
    if lines and one.series.expected:
        top = 1.5 * max(y for _, _, line_y, _ in lines for y in line_y)
        expected = [top * (h / max(lengths)) ** one.series.expected for h in lengths]
        label = f"expected order {one.series.expected:g}"
        axis.plot(lengths, expected, color="#999999", lw=3, alpha=0.5, label=label)
    axis.set(xscale="log", yscale="log", xlabel=one.series.length, ylabel="error")
    axis.set_title(one.series.variant or PARAMETERS[one.series.parameter].title)
    axis.xaxis.set_major_locator(FixedLocator(lengths))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:.3g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axis.tick_params(axis="x", rotation=30)
    if lines:
        axis.legend(fontsize=7.5)


LEAST = 1e-4  # errors below are drawn here
RED, BLACK, GREY, GREEN = "#c1443c", "#111111", "#888888", "#0f8a8a"
BESIDE = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "fontsize": 8.5}


def work_precision(study: Study, table: Sequence[Row], path: Path) -> Path:
    """All points, and a line through those that nothing beats."""
    drawn, axes = figure(width=9.6, height=5.6)
    axis = axes[0, 0]
    front = pareto(table)
    axis.plot(*_line(front), color=GREY, lw=1.2, zorder=1, label="nothing is better in both")
    for rows, mark, colour, label in _groups(study, table):
        _scatter(axis, rows, mark, colour, label)
    for number, row in enumerate(front, 1):
        near = {"textcoords": "offset points", "fontsize": 9, "weight": "bold"}
        axis.annotate(str(number), _place(row), (6, 5), **near)
    if any(_width(row.error) for row in table):
        axis.plot([], [], color=GREY, lw=0.9, label="where chance leaves it (95 %)")
    _guides(axis, study.measured[study.reference].processor_s)
    axis.set_title(f"What accuracy costs: {study.listed.loaded.name}, down and left is better")
    axis.legend(**BESIDE)
    drawn.savefig(path, dpi=120)
    plt.close(drawn)
    return path


def _groups(study: Study, table: Sequence[Row]) -> list[tuple[list[Row], str, str, str]]:
    """Rows with their mark, colour and name."""
    shown = [row for row in table if row.error is not None]
    found = []
    for number, (axis, title) in enumerate(study.listed.offer.titles.items()):
        mine = [r for r in shown if r.point.kind == ALONE and axis in r.point.settings]
        mark, colour = MARKS[number % len(MARKS)], LINES[number % len(LINES)]
        found.append((mine, mark, colour, f"{title} only"))
    together = [r for r in shown if r.point.kind in (TOGETHER, REFERENCE)]
    own = [r for r in shown if r.point.kind == BASE]
    return [*found, (together, "*", BLACK, "several together"), (own, "o", RED, "the case as it is")]


def _scatter(axis: Any, rows: Sequence[Row], mark: str, colour: str, label: str) -> None:
    if not rows:
        return
    x, y = _line(rows)
    size = 90 if mark == "*" else 34
    axis.scatter(x, y, marker=mark, s=size, color=colour, label=label, zorder=3)
    ends = [(y - _width(row.error), y + _width(row.error)) for y, row in zip(y, rows, strict=True)]
    low, high = ([max(end, LEAST) for end in each] for each in zip(*ends, strict=True))
    axis.vlines(x, low, high, color=colour, lw=0.9, alpha=0.6, zorder=2)


def _guides(axis: Any, reference_s: float) -> None:
    """Axes, tolerances, and where the reference is."""
    axis.set(xscale="log", yscale="log", xlabel="processor time of one run / s")
    axis.set_ylabel("largest error of what decides, against the reference")
    axis.axvline(reference_s, color=GREY, ls=":", lw=1)
    note = {"rotation": 90, "ha": "right", "va": "top", "fontsize": 8.5, "color": GREY}
    axis.text(reference_s, 0.98, "the reference ", transform=axis.get_xaxis_transform(), **note)
    for tolerance in RECOMMENDED:
        axis.axhline(tolerance, color=GREEN, lw=0.8, ls="--", zorder=0)
    axis.set_ylim(bottom=LEAST / 2 if axis.get_ylim()[0] < LEAST else None)
    axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 3.0, 5.0)))
    axis.xaxis.set_major_formatter(lambda value, _: f"{value:g}")
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.margins(x=0.12, y=0.12)


def _line(rows: Sequence[Row]) -> tuple[list[float], list[float]]:
    pairs = [_place(row) for row in rows]
    return [x for x, _ in pairs], [y for _, y in pairs]


def _place(row: Row) -> tuple[float, float]:
    assert row.measured is not None
    assert row.error is not None
    return row.measured.processor_s, max(row.error.value, LEAST)


def _width(error: Error | None) -> float:
    return (error.half_width or 0.0) if error else 0.0


def write(study: Study, table: Sequence[Row], folder: Path) -> list[Path]:
    """The pictures and the page."""
    plot = work_precision(study, table, folder / "work-precision.png")
    axes = _axes(study, folder)
    text = fill_template(
        "studies/accuracy/page.html",
        title=study.listed.loaded.name,
        level=study.listed.loaded.level,
        study=study,
        rows=sorted((r for r in table if r.measured), key=lambda r: r.measured.processor_s),
        lacking=[row for row in table if row.measured is None],
        front={row.point.name: number for number, row in enumerate(pareto(table), 1)},
        advice=[recommended(table, tolerance) for tolerance in RECOMMENDED],
        names={name: WORDS[name] for name in QUANTITIES if any(name in row.errors for row in table)},
        short={name: quantity.short for name, quantity in QUANTITIES.items()},
        defects=DEFECTS,
        answers={row.what: row for row in study.listed.known},
        titles={name: parameter.title for name, parameter in PARAMETERS.items()},
        percent=percent,
        error=_error,
        plot=_embedded(plot),
        knobs=[each | {"pictures": [_embedded(file) for file in each["files"]]} for each in axes],
    )
    write_text(folder / "accuracy.html", text)
    return [plot, *(file for each in axes for file in each["files"]), folder / "accuracy.html"]


def _axes(study: Study, folder: Path) -> list[dict[str, Any]]:
    """Returns of each axis its series, its models if it has several, and their pictures."""
    axes = []
    for axis in study.listed.offer.axes:
        families = [one for one in study.families if one.series.axis == axis]
        every = compare_axis(axis, study.families, study.spread)
        models = every if len({each.series.variant for each in every}) > 1 else []
        files = [
            convergence(families, study.judged_by, folder / f"accuracy-{axis}.png"),
            draw_models(models, study.judged_by, folder / f"accuracy-{axis}-models.png"),
        ]
        title = study.listed.offer.titles[axis]
        shown = [file for file in files if file is not None]
        axes.append({"title": title, "families": families, "models": models, "files": shown})
    return axes


def draw_models(models: Sequence[Compared], judged_by: Sequence[str], path: Path) -> Path | None:
    """Draws the error of every model against its cost, a part for each quantity; None without any
    error."""
    names = [
        n for n in (*judged_by, "shape") if any(n in each.errors and not each.is_best for each in models)
    ]
    if not names:
        return None
    drawn, parts = _parts(len(names), 5.6)
    variants = list(dict.fromkeys(each.series.variant for each in models))
    for axis, name in zip(parts, names, strict=True):
        for number, variant in enumerate(variants):
            mine = [m for m in models if m.series.variant == variant and name in m.errors and not m.is_best]
            places = [(m.measured.processor_s, max(m.errors[name].value, LEAST)) for m in mine]
            if places:
                look = {"marker": MARKS[number % len(MARKS)], "color": LINES[number % len(LINES)], "s": 38}
                axis.scatter(*zip(*places, strict=True), **look)
            for model, place in zip(mine, places, strict=True):
                near = {"textcoords": "offset points", "fontsize": 8}
                axis.annotate(model.setting.label, place, (6, 4), **near)
        axis.set(xscale="log", yscale="log", xlabel="processor time of one run / s")
        axis.set_ylabel("error against the best model")
        axis.set_title(WORDS[name].split(" / ")[0])
        axis.yaxis.set_major_formatter(lambda value, _: f"{100 * value:g} %")
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.margins(x=0.3, y=0.15)
    save(drawn, path)
    return path


def _error(errors: Mapping[str, Error], name: str) -> str:
    """With its uncertainty."""
    one = errors.get(name)
    if one is None:
        return ""
    return percent(one.value) + (f" ± {percent(one.half_width)}" if one.half_width else "")


def _embedded(file: Path) -> str:
    return data_uri(file.read_bytes(), "image/png")
