"""Sieve analyses: tables of a laboratory that a bed's ``curve.file`` names, read as cumulative curves.

A column has the sieves, and one or several others what passed or was retained, as shares, in per cent or
as masses.  Rows may be in any order (data_table.py reads them).  A sieve is a length ("4 mm", "63 µm"), or a
name of ASTM E11: "No. 4", "1/2 in".  The openings behind the names are those of ASTM E11-20, table 1 (metric
sizes are those of ISO 565 and ISO 3310-1).

What is finer than the finest sieve has no sizes of its own in such a table.  It is spread evenly over the
sizes from ``OPEN_END`` of that sieve up to it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

from orchestrator.case.file.data_file import read_with
from orchestrator.case.file.data_table import (
    IGNORE,
    Answers,
    Column,
    DataTable,
    TableError,
    answer,
    read_text,
)
from orchestrator.case.file.errors import CaseError, CaseProblem, Key, show_value
from orchestrator.case.file.units import parse_quantity

OPEN_END = 0.5
"""Smallest size of what passes the finest sieve, over that sieve's opening."""
ROUNDING = 0.01
"""Largest distance of a sum of rounded shares from 1."""
WHOLE = 5e-4
"""Largest distance of what passes the coarsest sieve from 1."""
NUMBERED_MM = {
    "3 1/2": 5.6, "4": 4.75, "5": 4.0, "6": 3.35, "7": 2.8, "8": 2.36, "10": 2.0, "12": 1.7, "14": 1.4,
    "16": 1.18, "18": 1.0, "20": 0.85, "25": 0.71, "30": 0.6, "35": 0.5, "40": 0.425, "45": 0.355,
    "50": 0.3, "60": 0.25, "70": 0.212, "80": 0.18, "100": 0.15, "120": 0.125, "140": 0.106, "170": 0.09,
    "200": 0.075, "230": 0.063, "270": 0.053, "325": 0.045, "400": 0.038, "450": 0.032, "500": 0.025,
    "635": 0.02,
}  # fmt: skip
"""Openings of the sieves that ASTM E11 numbers."""
INCHES_MM = {
    "5": 125.0, "4.24": 106.0, "4": 100.0, "3 1/2": 90.0, "3": 75.0, "2 1/2": 63.0, "2.12": 53.0, "2": 50.0,
    "1 3/4": 45.0, "1 1/2": 37.5, "1 1/4": 31.5, "1.06": 26.5, "1": 25.0, "7/8": 22.4, "3/4": 19.0,
    "5/8": 16.0, "0.53": 13.2, "1/2": 12.5, "7/16": 11.2, "3/8": 9.5, "5/16": 8.0, "0.265": 6.7, "1/4": 6.3,
}  # fmt: skip
"""Openings of the sieves that ASTM E11 names by inches, which are not 25.4 mm."""

NUMBERED = re.compile(r"(?:no\.?|nr\.?|#)\s*(\d+(?:[ -]1/2)?)", re.IGNORECASE)
INCHES = re.compile(
    r"(\d+(?:\.\d+)?(?:[ -]\d+/\d+)?|\d+/\d+|\.\d+)\s*-?(?:in\.?|inch(?:es)?|\"|”|″)", re.IGNORECASE
)
PAN = re.compile(r"pan|bottom|tray|receiver|boden|0|0[.,]0+", re.IGNORECASE)
NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)")
SIEVE_WORDS = (
    "sieve",
    "size",
    "opening",
    "aperture",
    "diameter",
    "screen",
    "siebweite",
    "maschenweite",
    "korngr",
)
PASSING_WORDS = ("passing", "passed", "finer", "undersize", "through", "durchgang")
RETAINED_WORDS = ("retained", "oversize", "coarser", "rückstand")
HEAD = 'its first line must be such as "sieve / mm; passing / %"'


@dataclass(frozen=True)
class _Column:
    """The column with what passed or was retained.

    ``unit`` is "%", "share", "mass", or "" if its head does not say; ``sums`` is "cumulative", "class" or "".
    """

    cells: Column
    is_passing: bool
    unit: str
    sums: str


def read_sieve_analyses(table: dict[str, Any], folder: Path, source: str) -> Iterator[CaseProblem]:
    """Put the points of each file that a block's or feed's curve names into a case's table, in its place.

    Yield all mistakes in the files; a table of another form is left to the check of the tables.
    """
    bed = table.get("bed")
    for kind in ("blocks", "feeds"):
        rows = bed.get(kind) if isinstance(bed, dict) else None
        for name, row in rows.items() if isinstance(rows, dict) else ():
            curve = row.get("curve") if isinstance(row, dict) else None
            if isinstance(curve, dict) and isinstance(curve.get("file"), str):
                key: Key = ("bed", kind, name, "curve", "file")
                try:
                    row["curve"] = read_with(curve_of, curve, folder, curve["file"], key, source)
                except CaseError as error:
                    yield from error.problems


def curve_of(text: str, answers: Answers | None = None) -> list[dict[str, float]]:
    """Return the points (``sieve_size_m``, ``passing``) of a table of a sieve analysis, from fine to coarse.

    Of several columns, what passes is taken, or else what is cumulative; the others must say the same.
    Raises TableError, whose message says what is wrong.
    """
    sieves, columns = _columns(read_text(text, answers))
    curves: list[list[dict[str, float]]] = []
    faults = []
    for column in columns:
        try:
            curves.append(_curve(sieves, column))
        except ValueError as error:
            faults.append(error)
    if not curves:
        raise faults[0]
    first, *others = ({point["sieve_size_m"]: point["passing"] for point in curve} for curve in curves)
    for other in others:
        if any(abs(other.get(size_m, passing) - passing) > ROUNDING for size_m, passing in first.items()):
            raise TableError("its columns of passing and retained contradict each other; keep one of them")
    return curves[0]


def _curve(sieves: Column, column: _Column) -> list[dict[str, float]]:
    """Return the points of the curve that one column gives.  Raises TableError."""
    values = column.cells.numbers()
    found: dict[float, float] = {}
    named: dict[float, str] = {}
    for line, cell, value in zip(sieves.lines, sieves.texts, values.tolist(), strict=True):
        if value < 0:
            raise TableError(f"line {line}: {show_value(f'{value:g}')} is negative")
        sieve_size_m = _opening_m(cell, sieves, line)
        if sieve_size_m in found:
            raise TableError(f"line {line}: {cell} is there twice, as {named[sieve_size_m]} before")
        found[sieve_size_m], named[sieve_size_m] = value, cell
    sizes_m = sorted(found)
    if len([size_m for size_m in sizes_m if size_m]) < 2:
        raise TableError(f"has less than two sieves; {HEAD}")
    passing = _passing(sizes_m, [found[size_m] for size_m in sizes_m], column)
    _refuse_wrong_course([named[size_m] for size_m in sizes_m], passing)
    return [*_with_lower_end(sizes_m, passing)]


def _columns(table: DataTable) -> tuple[Column, list[_Column]]:
    """Return the column of the sieves, and those of the shares, with what is best known first.

    Raises TableError for a head that leaves open what its columns are.
    """
    values = [column for column in table.columns if _value_words(column.head)]
    sieves = [column for column in table.columns if column not in values and _has(column.head, SIEVE_WORDS)]
    for column in table.columns:
        if column not in (*values, *sieves):
            passing, ignored = answer(column.head, "passing / %"), answer(column.head, IGNORE)
            raise TableError(
                f"is {show_value(column.head)} passing or retained, or no share? {passing} or {ignored}"
            )
    if any("both" in _value_words(column.head) for column in values):
        raise TableError("a column mixes passing and retained; keep one of the two")
    if len(sieves) != 1 or not values:
        raise TableError(f"has {len(sieves)} columns of sieves and {len(values)} of shares; {HEAD}")
    shares = [
        _Column(each, _value_words(each.head) == "passing", _unit_of_values(each), _sums(each.head))
        for each in values
    ]
    best = ("cumulative", "class", "")
    shares.sort(key=lambda each: (not each.is_passing, each.unit == "mass", best.index(each.sums)))
    return sieves[0], shares


def _has(cell: str, words: Sequence[str]) -> bool:
    return any(word in cell.lower() for word in words)


def _value_words(cell: str) -> str:
    """Return "passing", "retained" or "both" for a column of shares, "" for another one."""
    passing, retained = _has(cell, PASSING_WORDS), _has(cell, RETAINED_WORDS)
    return "both" if passing and retained else "passing" if passing else "retained" if retained else ""


def _unit_of_values(column: Column) -> str:
    """Return "%", "share" or "mass" as the head of a column of shares says, "" if it does not say.

    Raises TableError for another unit.
    """
    if column.unit in ("", "1"):
        return "share" if column.unit or _has(column.head, ("share", "fraction")) else ""
    if column.unit == "%":
        return "%"
    try:
        parse_quantity(f"1 {column.unit}", "mass_kg")
    except ValueError:
        raise TableError(
            f"column {show_value(column.head)} is in {column.unit}, not in %, shares or g"
        ) from None
    return "mass"


def _sums(cell: str) -> str:
    """Return whether a head says that its column is cumulative or by class."""
    if _has(cell, ("cum", "kumul", "summe", "total")):
        return "cumulative"
    return "class" if _has(cell, ("class", "individual", "each", "single", "differential", "klasse")) else ""


def _opening_m(text: str, column: Column, line: int) -> float:
    """Return the opening of a sieve, 0 for the pan.  Raises TableError for a name that no sieve has."""
    plain = " ".join(text.split())
    if PAN.fullmatch(plain):
        return 0.0
    if match := NUMBERED.fullmatch(plain):
        number = match[1].replace("-", " ")
        if number not in NUMBERED_MM:
            raise TableError(f"line {line}: ASTM E11 has no sieve {show_value(text)}; {_near(number)}")
        return NUMBERED_MM[number] * 1e-3
    in_inches = INCHES.fullmatch(f"{plain} in") if column.unit in ("in", "inch") else None
    if match := INCHES.fullmatch(plain) or in_inches:
        return _inches_m(match[1])
    if "mesh" in plain.lower():
        raise TableError(
            f'line {line}: {show_value(text)} may be of Tyler or of ASTM; write "No. 4" or "4.75 mm"'
        )
    given = plain.replace(",", ".") if column.comma else plain
    if NUMBER.fullmatch(plain):
        if not column.unit:
            unit = answer(column.head, "sieve / mm")
            raise TableError(
                f'line {line}: {show_value(text)} has no unit; name the column "sieve / mm", or {unit}'
            )
        given += f" {column.unit}"
    try:
        sieve_size_m = parse_quantity(given, "sieve_size_m")
    except ValueError:
        hint = 'such as "63 µm", "No. 4" or "1/2 in"'
        raise TableError(f"line {line}: {show_value(text)} is not a sieve, {hint}") from None
    if not 0 < sieve_size_m < math.inf:
        raise TableError(f"line {line}: {show_value(text)} is not an opening of a sieve")
    return sieve_size_m


def _near(number: str) -> str:
    """Return a hint at the numbered sieves on both sides."""
    wanted = float(Fraction(number.split()[0]))
    names = sorted(NUMBERED_MM, key=lambda name: abs(float(name.split()[0]) - wanted))[:2]
    return "it has " + " and ".join(f"No. {name} ({NUMBERED_MM[name]:g} mm)" for name in names)


def _inches_m(text: str) -> float:
    """Return the opening of a sieve of so many inches: that of ASTM E11, or else 25.4 mm to the inch."""
    inches = sum((Fraction(part) for part in re.split(r"[ -]", text)), Fraction(0))
    for name, opening_mm in INCHES_MM.items():
        if sum((Fraction(part) for part in name.split()), Fraction(0)) == inches:
            return opening_mm * 1e-3
    return float(inches) * 0.0254


def _passing(sizes_m: Sequence[float], values: Sequence[float], column: _Column) -> list[float]:
    """Return the share that passes each sieve, from fine to coarse.  Raises TableError."""
    if column.unit == "mass":
        if column.is_passing or column.sums == "cumulative":
            raise TableError("masses are wanted as retained on each sieve; or give shares or per cent")
        if sizes_m[0] != 0:
            raise TableError("masses without that in the pan have no sum; add a row such as pan;12.5")
        return _passing_of_classes(sizes_m, values, sum(values))
    if not column.is_passing and _is_by_class(sizes_m, values, column):
        whole = _whole(sum(values), column.unit)
        if sum(values) > whole * (1 + ROUNDING):
            raise TableError(f"what is retained adds up to {sum(values):g}, more than {whole:g}")
        closed = sizes_m[0] == 0
        if closed and abs(sum(values) / whole - 1) > ROUNDING:
            raise TableError(f"what is retained adds up to {sum(values):g} with the pan, not to {whole:g}")
        return _passing_of_classes(sizes_m, values, sum(values) if closed else max(whole, sum(values)))
    whole = _whole(max(values), column.unit)
    if max(values) > whole * (1 + 1e-9):
        raise TableError(f"{max(values):g} is more than {whole:g}")
    return [value / whole if column.is_passing else 1 - value / whole for value in values]


def _whole(largest: float, unit: str) -> float:
    """Return the number that stands for all of the mass: 1 or 100."""
    if unit:
        return 100.0 if unit == "%" else 1.0
    return 100.0 if largest > 1 + ROUNDING else 1.0


def _passing_of_classes(sizes_m: Sequence[float], values: Sequence[float], whole: float) -> list[float]:
    """Return the share that passes each sieve, from what is retained on each."""
    if whole <= 0:
        raise TableError("nothing is retained on any sieve")
    coarser, passing = 0.0, []
    for _, value in sorted(zip(sizes_m, values, strict=True), reverse=True):
        coarser += value
        passing.append(max(0.0, 1 - coarser / whole))
    return passing[::-1]


def _is_by_class(sizes_m: Sequence[float], values: Sequence[float], column: _Column) -> bool:
    """Return whether what is retained is given for each sieve by itself, and not with all coarser ones.

    Raises TableError if it may be either.
    """
    if column.sums:
        return column.sums == "class"
    whole = _whole(max(values), column.unit)
    rises = all(coarse <= fine for fine, coarse in pairwise(values))
    if not rises:
        return True
    if sum(values) > whole * (1 + ROUNDING):
        return False
    if sizes_m[0] == 0 and abs(sum(values) / whole - 1) <= ROUNDING:
        return True
    raise TableError(
        "may be retained on each sieve or on it and all coarser ones; name the column "
        '"retained per class / %" or "cumulative retained / %"'
    )


def _refuse_wrong_course(names: Sequence[str], passing: Sequence[float]) -> None:
    """Raise TableError for a curve that falls, or that does not reach the whole mass."""
    for (fine, less), (coarse, more) in pairwise(zip(names, passing, strict=True)):
        if more < less:
            raise TableError(
                f"the curve falls: {100 * more:.4g} % pass {coarse}, and {100 * less:.4g} % the finer {fine}"
            )
    if passing[-1] < 1 - WHOLE:
        raise TableError(
            f"{100 * (1 - passing[-1]):.3g} % are coarser than the coarsest sieve, {names[-1]}; "
            "add the sieve that all pass"
        )


def _with_lower_end(sizes_m: Sequence[float], passing: Sequence[float]) -> Iterator[dict[str, float]]:
    """Yield the points of a curve, from a size that nothing passes to the first one that all pass."""
    points = [(size_m, share) for size_m, share in zip(sizes_m, passing, strict=True) if size_m > 0]
    closed = [number for number, (_, share) in enumerate(points) if share == 0]
    if closed:
        points = points[closed[-1] :]
    else:
        points.insert(0, (OPEN_END * points[0][0], 0.0))
    last = next(number for number, (_, share) in enumerate(points) if share >= 1 - WHOLE)
    for number, (size_m, share) in enumerate(points[: last + 1]):
        yield {"sieve_size_m": size_m, "passing": 1.0 if number == last else share}
