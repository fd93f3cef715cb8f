"""The results that a user wants of a sweep: a table for the terminal, and a picture, both with intervals."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from textwrap import fill
from typing import Any

from rich.table import Table

from orchestrator.workbench import Picture, Run
from orchestrator.workbench.vocabulary import Value, console_table, in_unit, interval

LOOKS: dict[str, dict[str, Any]] = {
    "good": {"marker": "o", "ms": 4},
    "open": {"marker": "o", "ms": 5, "mfc": "white"},
    "cross": {"marker": "x", "ms": 6},
}
MOST_LABELS = 6  # of values, such as "700 rpm", below an axis
LABEL = 42  # characters of a line beside an axis of 4 inches


@dataclass(frozen=True)
class SweptSetting:
    """A setting of a sweep, by key, with the state of its run and the wanted results that the run has.

    ``transient`` has words for a machine that has not settled and for a bed that is not steady.
    ``given`` has by key the values that were given with a unit.
    """

    setting: Mapping[str, str]
    status: str
    results: Mapping[str, Value]
    transient: tuple[str, ...] = ()
    given: Mapping[str, str] = field(default_factory=dict)

    @property
    def look(self) -> str:
        """The look of its marks."""
        return "cross" if self.status != "done" else "open" if self.transient else "good"

    def text(self, key: str) -> str:
        """Return the value of a key for people, as it was given, or a number with up to six digits."""
        number = self.number(key)
        return self.given.get(key) or (self.setting[key] if math.isnan(number) else f"{number:.6g}")

    def number(self, key: str) -> float:
        """Return the value of a key; NaN for a value that is no number."""
        try:
            return float(self.setting[key])
        except ValueError:
            return math.nan


def results_of(run: Run, wanted: Sequence[str]) -> dict[str, Value]:
    """Return the wanted results that a run has, by name."""
    values = {name: run.result(name) for name in wanted}
    return {name: value for name, value in values.items() if value is not None}


def transient_words(run: Run) -> tuple[str, ...]:
    """Return words for a machine that has not settled, and for a bed that is not steady."""
    unsteady, unsettled = run.why_transient
    return tuple(words for words, why in (("not settled", unsettled), ("not steady", unsteady)) if why)


def short_keys(keys: Sequence[str]) -> list[str]:
    """Return the last words of dotted keys, as many of them as tell all keys apart."""
    words = [key.split(".") for key in keys]
    longer = ([".".join(each[-count:]) for each in words] for count in range(1, max(map(len, words)) + 1))
    return next((names for names in longer if len(set(names)) == len(names)), list(keys))


def results_table(keys: Sequence[str], rows: Sequence[SweptSetting], wanted: Sequence[str]) -> Table:
    """Return a table for the terminal with a row for each setting."""

    def cells(row: SweptSetting) -> Iterator[str]:
        yield from (row.text(key) for key in keys)
        for name in wanted:
            value = row.results.get(name)
            yield interval(value)
        yield ", ".join((row.status, *row.transient))

    head = [*short_keys(keys), *(name + in_unit(Run.named(name).figure.unit) for name in wanted), "state"]
    return console_table("", head, (list(cells(row)) for row in rows), left=("state",))


def draw_results(
    keys: Sequence[str], rows: Sequence[SweptSetting], wanted: Sequence[str], file: Path
) -> list[Path]:
    """Draw each wanted result over each varied key with its interval, and return the file.

    Over the first key of a grid, lines join the runs whose other keys are equal.  Where the values of no key
    are numbers, the settings stand below each other by their words.  Nothing is drawn where fewer than two
    runs have results.  Runs that are transient have open marks, and those that are not to be trusted are
    crosses.
    """
    drawn = [row for row in rows if row.results and row.status in Run.at_the_end]
    numeric = [key for key in keys if all(math.isfinite(row.number(key)) for row in drawn)]
    if len(drawn) < 2:
        return []
    lines = _lines(keys, drawn)
    over = (numeric[:1] if lines else numeric) or [""]
    picture = Picture(len(wanted) * len(over), max(len(over), min(2, len(wanted))), 5.5, 4.0)
    for number, (name, key) in enumerate((name, key) for name in wanted for key in over):
        if key:
            _draw_result(picture.parts[number], name, key, keys, lines or {"": drawn})
        else:
            _draw_in_words(picture.parts[number], name, keys, drawn)
    note = "open: not settled, or not steady; cross: not to be trusted"
    picture.figure.suptitle(note, fontsize=9, x=0.01, ha="left")
    return [picture.save(file)]


def _draw_in_words(axes: Any, name: str, keys: Sequence[str], rows: Sequence[SweptSetting]) -> None:
    """Draw a result of settings without numbers, the first setting on top."""
    for place, row in enumerate(rows):
        if (value := row.results.get(name)) is not None:
            width = value.half_width or 0.0
            axes.errorbar(value.value, place, xerr=width, capsize=3, color="C0", **LOOKS[row.look])
    words = [fill(", ".join(row.text(key) for key in keys), LABEL // 2) for row in rows]
    axes.set_yticks(range(len(rows)), words, fontsize=7)
    axes.set(xlabel=fill(Run.named(name).words, LABEL), xlim=(0.0, None), ylim=(len(rows) - 0.5, -0.5))


def show_given_units(axes: Any, given: Mapping[float, str]) -> None:
    """Label the values of a key below the ``axes`` with the texts, such as "700 rpm", that were given for
    them, if all were given with a unit and so few that the texts have room."""
    if given and all(given.values()) and len(given) <= MOST_LABELS:
        axes.set_xticks([*given], [*given.values()])
    else:
        axes.locator_params(axis="x", nbins=5)


def _lines(keys: Sequence[str], rows: Sequence[SweptSetting]) -> dict[str, list[SweptSetting]]:
    """Return the runs with equal other keys, by these; {} where no line would join two of them."""
    lines: dict[str, list[SweptSetting]] = {}
    for row in rows:
        others = ", ".join(f"{key.rpartition('.')[2]} = {row.text(key)}" for key in keys[1:])
        lines.setdefault(others, []).append(row)
    return lines if max(map(len, lines.values())) > 1 else {}


def _draw_result(
    axes: Any, name: str, key: str, keys: Sequence[str], lines: Mapping[str, Sequence[SweptSetting]]
) -> None:
    for number, (label, rows) in enumerate(lines.items()):
        some = sorted((row for row in rows if name in row.results), key=lambda row: row.number(key))
        colour, joined = f"C{number}", len(lines) > 1 or len(keys) == 1
        x, y = [row.number(key) for row in some], [row.results[name].value for row in some]
        axes.plot(x, y, lw=1 if joined else 0, color=colour, label=label or None)
        for place, height, row in zip(x, y, some, strict=True):
            width = row.results[name].half_width or 0.0
            axes.errorbar(place, height, width, capsize=3, color=colour, **LOOKS[row.look])
    axes.set(xlabel=key, ylabel=fill(Run.named(name).words, LABEL))
    show_given_units(
        axes, {row.number(key): row.given.get(key, "") for each in lines.values() for row in each}
    )
    if len(lines) > 1:
        axes.legend(fontsize=8)
