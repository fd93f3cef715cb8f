"""The errors of the headline figures: the table ``accuracy`` of ``summary.json``, and the lines that tell it.

A figure has the error of a quantity that studies of accuracy compare where the quantity is that figure.
Where a bound of the monitor was passed, or the run is doubtful, no error is told: the study says nothing of
such a run.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from orchestrator.figures.accuracy import Accuracy
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.figure import to_json
from orchestrator.figures.results import Summary, parse_results
from orchestrator.figures.short_names import SHORT_NAMES, value_at
from orchestrator.output.report.formatting import duration, number
from orchestrator.output.report.headline import Tile, headline
from orchestrator.output.results.quantities import NAMED, QUANTITIES

SHORT_NAME = {"efficiency_percent": "efficiency", "velocity_m_per_s": "velocity"}
SHORT_NAME |= {name: names[0] for name, names in NAMED.items()}
"""The short names of the results that are quantities."""
UNKNOWN, PASSED = "error not known", "no error told: a bound was passed"
DIGITS = 2
LIKE = 0.1
"""The relative difference of two durations up to which a study speaks of a run without naming its own."""


def errors_table(accuracy: Accuracy, summary: Summary) -> dict[str, Any]:
    """Return the table ``accuracy`` of a run's summary, which has its monitor, doubts and results."""
    passed = [*passed_bounds(summary)]
    tiles = [tile for tile in headline(parse_results(summary)) if tile.path]
    first = {name: tile.path for tile in reversed(tiles) if (name := quantity_of(tile, summary))}
    quantities = {path: name for name, path in first.items()}
    figures = {tile.path: _figure(tile, quantities.get(tile.path), accuracy, passed) for tile in tiles}
    table: dict[str, Any] = to_json({**accuracy.as_json(), "passed": passed, "figures": figures})
    return table


def _figure(tile: Tile, quantity: str | None, accuracy: Accuracy, passed: list[str]) -> dict[str, Any]:
    """Return what is known of the error of a headline figure that is a ``quantity``."""
    error = accuracy.errors.get(quantity) if quantity and not passed else None
    return {
        "name": tile.name,
        "quantity": quantity,
        "error": error and error.value,
        "error_half_width": error and error.half_width,
        "interval": relative_interval(tile.estimate),
    }


def passed_bounds(summary: Summary) -> Iterator[str]:
    """Yield a sentence for each bound of the monitor that the run passed, and each doubt."""
    for name, item in summary.get("monitor", {}).get("figures", {}).items():
        if item["times"]:
            yield (
                f"{name} was {item['worst']:.3g}, its bound {item['limit']:g}: "
                f"{item['times']} times from {item['first_s']:g} s on"
            )
    yield from summary.get("doubts", [])


def quantity_of(tile: Tile, summary: Summary) -> str:
    """Return the quantity that is the figure of a tile; "" where there is none.

    Several panels have one quantity, which is the figure only where both have the same value.
    """
    if tile.estimate is None or tile.estimate.value is None:
        return ""
    last, size = tile.path.rpartition(".")[2], tile.estimate.value
    named = ((quantity, short) for quantity, short in SHORT_NAME.items() if _last_key(short) == last)
    values = ((quantity, value_at(summary, short_name)) for quantity, short_name in named)
    same = (name for name, value in values if value and math.isclose(value.value, size, rel_tol=1e-9))
    return next(same, "")


def _last_key(short_name: str) -> str:
    return SHORT_NAMES[short_name].figure.path.rpartition(".")[2]


def relative_interval(estimate: Estimate | None) -> float | None:
    """Return the half width of an estimate's interval over its size; None where either is not known."""
    if estimate is None or not estimate.value or estimate.half_width is None:
        return None
    return abs(estimate.half_width / estimate.value)


def error_of(summary: Summary, path: str) -> str:
    """Return the error of the headline figure at a path, in words; "" where the run knows of none at all."""
    table = summary.get("accuracy", {})
    figure = table.get("figures", {}).get(path)
    if figure is None or table["basis"] == "not known":
        return ""
    if table["passed"]:
        return PASSED
    if figure["error"] is None:
        return UNKNOWN
    return f"error {_size(figure['error'], figure['error_half_width'])}, {table['basis']}"


def about_errors(summary: Summary) -> list[str]:
    """Return what is said below the headline about its errors, a sentence each."""
    if "accuracy" not in summary:  # of an older run
        return []
    table = summary["accuracy"]
    if table["passed"] or table["basis"] == "not known":
        line = closing_line(summary)
        return [f"{line[0].upper()}{line[1:]}."]
    lasting = duration(table["study_s"])
    words = [f"Errors are {table['why']} ({table['study']}), whose runs lasted {lasting}."]
    if table["reference_error"] is None:
        words.append("How far its reference is off itself is not known.")
    else:
        own = percent(table["reference_error"])
        words.append(f"Its reference is itself off by an estimated {own}, which is in them.")
    if table["chance"] is None:
        words.append("How much of them is chance is not known.")
    elif table["chance"]:
        words.append(f"Chance moves them by up to {percent(table['chance'])}.")
    if others := _others(table):
        words.append(f"It also compared: {', '.join(others)}.")
    return [" ".join(words)]


def closing_line(summary: Summary) -> str:
    """Return one line about the errors of a run, for the console."""
    table = summary["accuracy"]
    if table["passed"]:
        more = f" (and {len(table['passed']) - 1} more)" if len(table["passed"]) > 1 else ""
        return f"how far off: not known, as a bound was passed: {table['passed'][0]}{more}".rstrip(".")
    if table["basis"] == "not known":
        tells = f"; `{table['command']}` measures it" if table["command"] else ""
        return f"how far off: not known: {table['why']}{tells}"
    known = [
        f"{QUANTITIES[figure['quantity']].short} {_size(figure['error'], figure['error_half_width'])}"
        for figure in table["figures"].values()
        if figure["error"] is not None
    ]
    is_as_long = math.isclose(table["study_s"], summary["simulated_s"], rel_tol=LIKE)
    lasting = "" if is_as_long else f", whose runs lasted {duration(table['study_s'])}"
    errors = ", ".join(known or _others(table)) or "nothing was compared"
    return f"how far off, {table['why']}{lasting}: {errors}"


def _others(table: Mapping[str, Any]) -> list[str]:
    """Return the errors of the quantities that are no headline figure."""
    headed = {figure["quantity"] for figure in table["figures"].values()}
    return [
        f"{QUANTITIES[name].short} {_size(error['value'], error['half_width'])}"
        for name, error in table["errors"].items()
        if name in QUANTITIES and name not in headed
    ]


def _size(value: float, half_width: float | None) -> str:
    """Return an error with its chance, such as "1.2 ± 3.0 %"."""
    return percent(value) + (f" ± {percent(half_width)}" if half_width else "")


def percent(share: float) -> str:
    """Return a share in per cent."""
    return f"{number(share, 100.0, DIGITS)} %"
