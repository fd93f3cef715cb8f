"""Sieve analyses: tables of a laboratory that a bed's ``curve.file`` names, read as cumulative curves.

The first line names two columns: the sieves, and what passed or was retained, as shares, in per cent or as
masses.  Rows may be in any order.  Cells are separated by commas, semicolons or tabs; with the latter two,
numbers may have decimal commas.  A sieve is a length ("4 mm", "63 µm"), or a name of ASTM E11: "No. 4",
"1/2 in".  The openings behind the names are those of ASTM E11-20, table 1 (metric sizes are those of ISO 565
and ISO 3310-1).

What is finer than the finest sieve has no sizes of its own in such a table.  It is spread evenly over the
sizes from ``OPEN_END`` of that sieve up to it.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

from orchestrator.case.file.data_file import read_data_file
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
PAN = re.compile(r"pan|bottom|tray|receiver|0|0[.,]0+", re.IGNORECASE)
NUMBER = re.compile(r"[-+]?(?:\d+[.,]?\d*|[.,]\d+)")
SIEVE_WORDS = ("sieve", "size", "opening", "aperture", "diameter", "screen")
PASSING_WORDS = ("passing", "passed", "finer", "undersize", "through")
RETAINED_WORDS = ("retained", "oversize", "coarser")
HEAD = 'its first line must be such as "sieve / mm; passing / %"'


@dataclass(frozen=True)
class _Column:
    """The column with what passed or was retained.

    ``unit`` is "%", "share", "mass", or "" if its head does not say; ``sums`` is "cumulative", "class" or "".
    """

    number: int
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
                    row["curve"] = read_sieve_analysis(folder, curve["file"], key, source)
                except CaseError as error:
                    yield from error.problems


def read_sieve_analysis(folder: Path, name: str, key: Key, source: str) -> list[dict[str, float]]:
    """Return the points of the curve that a sieve analysis in a folder gives, from fine to coarse.

    ``key`` names the file, and ``source`` is the file or option that gave the key.  Raises CaseError with
    what is wrong in the file.
    """
    text = read_data_file(folder, name, key, source)
    try:
        return curve_of(text)
    except ValueError as error:
        raise CaseError([CaseProblem(key, str(error), file=name, kind="file")]) from None


def curve_of(text: str) -> list[dict[str, float]]:
    """Return the points (``sieve_size_m``, ``passing``) of a table of a sieve analysis, from fine to coarse.

    Raises ValueError, whose message says what is wrong.
    """
    rows = _rows(text)
    sieve, unit, column = _columns(rows[0])
    found: dict[float, float] = {}
    named: dict[float, str] = {}
    for line, row in enumerate(rows[1:], start=2):
        if len(row) != len(rows[0]):
            raise ValueError(f"row {line}: {len(row)} cells instead of {len(rows[0])}")
        sieve_size_m = _opening_m(row[sieve], unit, line)
        if sieve_size_m in found:
            raise ValueError(f"row {line}: {row[sieve]} is there twice, as {named[sieve_size_m]} before")
        found[sieve_size_m], named[sieve_size_m] = _number(row[column.number], line), row[sieve]
    sizes_m = sorted(found)
    if len([size_m for size_m in sizes_m if size_m]) < 2:
        raise ValueError(f"has less than two sieves; {HEAD}")
    passing = _passing(sizes_m, [found[size_m] for size_m in sizes_m], column)
    _refuse_wrong_course([named[size_m] for size_m in sizes_m], passing)
    return [*_with_lower_end(sizes_m, passing)]


def _rows(text: str) -> list[list[str]]:
    """Return the cells of all rows that are not empty.  Raises ValueError if there is no row but the head."""
    lines = [line for line in text.splitlines() if line.strip()]
    separator = next((mark for mark in ";\t" if lines and mark in lines[0]), ",")
    try:
        rows = [*csv.reader(lines, delimiter=separator)]
    except csv.Error as error:
        raise ValueError(f"cannot be read: {error}") from None
    rows = [[cell.strip() for cell in row] for row in rows]
    if len(rows) < 2:
        raise ValueError(f"has no rows; {HEAD}")
    return rows


def _columns(head: Sequence[str]) -> tuple[int, str, _Column]:
    """Return the number of the sieves' column, their unit, and the column of the shares.

    Raises ValueError for a head that names other columns or more of them.
    """
    sieves = [n for n, cell in enumerate(head) if _has(cell, SIEVE_WORDS) and not _value_words(cell)]
    values = [n for n, cell in enumerate(head) if _value_words(cell)]
    if other := [cell for n, cell in enumerate(head) if n not in (*sieves, *values)]:
        raise ValueError(f"no column {show_value(other[0])}; {HEAD}")
    if len({_value_words(head[n]) for n in values}) > 1 or any(
        "both" in _value_words(head[n]) for n in values
    ):
        raise ValueError("mixes passing and retained; keep one of the two columns")
    if len(sieves) != 1 or len(values) != 1:
        raise ValueError(
            f"has {len(sieves)} columns of sieves and {len(values)} of shares, not one each; {HEAD}"
        )
    cell = head[values[0]]
    unit = re.search(r"(?:^|[\s_(\[/])(mm|cm|m|µm|μm|um|in)[)\]]?\s*$", head[sieves[0]])
    return (
        sieves[0],
        unit[1] if unit else "",
        _Column(values[0], _value_words(cell) == "passing", _unit_of_values(cell), _sums(cell)),
    )


def _has(cell: str, words: Sequence[str]) -> bool:
    return any(word in cell.lower() for word in words)


def _value_words(cell: str) -> str:
    """Return "passing", "retained" or "both" for a column of shares, "" for another one."""
    passing, retained = _has(cell, PASSING_WORDS), _has(cell, RETAINED_WORDS)
    return "both" if passing and retained else "passing" if passing else "retained" if retained else ""


def _unit_of_values(cell: str) -> str:
    """Return "%", "share" or "mass" as the head of a column of shares says, "" if it does not say."""
    if re.search(r"%|per ?cent|pct", cell.lower()):
        return "%"
    if re.search(r"(?:^|[\s_(\[/])(k?g|t)[)\]]?\s*$", cell):
        return "mass"
    return "share" if _has(cell, ("share", "fraction")) else ""


def _sums(cell: str) -> str:
    """Return whether a head says that its column is cumulative or by class."""
    if "cum" in cell.lower():
        return "cumulative"
    return "class" if _has(cell, ("class", "individual", "each", "single", "differential")) else ""


def _opening_m(text: str, unit: str, line: int) -> float:
    """Return the opening of a sieve, 0 for the pan.  Raises ValueError for a name that no sieve has."""
    plain = " ".join(text.split())
    if PAN.fullmatch(plain):
        return 0.0
    if match := NUMBERED.fullmatch(plain):
        number = match[1].replace("-", " ")
        if number not in NUMBERED_MM:
            raise ValueError(f"row {line}: ASTM E11 has no sieve {show_value(text)}; {_near(number)}")
        return NUMBERED_MM[number] * 1e-3
    if (match := INCHES.fullmatch(plain)) or (unit == "in" and (match := INCHES.fullmatch(f"{plain} in"))):
        return _inches_m(match[1])
    if "mesh" in plain.lower():
        raise ValueError(
            f'row {line}: {show_value(text)} may be of Tyler or of ASTM; write "No. 4" or "4.75 mm"'
        )
    given = plain.replace(",", ".")
    if NUMBER.fullmatch(plain):
        if not unit:
            raise ValueError(f'row {line}: {show_value(text)} has no unit; name the column "sieve / mm"')
        given += f" {unit}"
    try:
        sieve_size_m = parse_quantity(given, "sieve_size_m")
    except ValueError:
        hint = 'such as "63 µm", "No. 4" or "1/2 in"'
        raise ValueError(f"row {line}: {show_value(text)} is no sieve, {hint}") from None
    if not 0 < sieve_size_m < math.inf:
        raise ValueError(f"row {line}: {show_value(text)} is no opening of a sieve")
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


def _number(text: str, line: int) -> float:
    """Return the number in a cell, which may have a decimal comma and a % sign."""
    plain = text.removesuffix("%").strip()
    if not NUMBER.fullmatch(plain):
        raise ValueError(f"row {line}: {show_value(text)} is no number")
    value = float(plain.replace(",", "."))
    if value < 0:
        raise ValueError(f"row {line}: {show_value(text)} is negative")
    return value


def _passing(sizes_m: Sequence[float], values: Sequence[float], column: _Column) -> list[float]:
    """Return the share that passes each sieve, from fine to coarse.  Raises ValueError."""
    if column.unit == "mass":
        if column.is_passing or column.sums == "cumulative":
            raise ValueError("masses are wanted as retained on each sieve; or give shares or per cent")
        if sizes_m[0] != 0:
            raise ValueError("masses without that in the pan have no sum; add a row such as pan;12.5")
        return _passing_of_classes(sizes_m, values, sum(values))
    if not column.is_passing and _is_by_class(sizes_m, values, column):
        whole = _whole(sum(values), column.unit)
        if sum(values) > whole * (1 + ROUNDING):
            raise ValueError(f"what is retained adds up to {sum(values):g}, more than {whole:g}")
        closed = sizes_m[0] == 0
        if closed and abs(sum(values) / whole - 1) > ROUNDING:
            raise ValueError(f"what is retained adds up to {sum(values):g} with the pan, not to {whole:g}")
        return _passing_of_classes(sizes_m, values, sum(values) if closed else max(whole, sum(values)))
    whole = _whole(max(values), column.unit)
    if max(values) > whole * (1 + 1e-9):
        raise ValueError(f"{max(values):g} is more than {whole:g}")
    return [value / whole if column.is_passing else 1 - value / whole for value in values]


def _whole(largest: float, unit: str) -> float:
    """Return the number that stands for all of the mass: 1 or 100."""
    if unit:
        return 100.0 if unit == "%" else 1.0
    return 100.0 if largest > 1 + ROUNDING else 1.0


def _passing_of_classes(sizes_m: Sequence[float], values: Sequence[float], whole: float) -> list[float]:
    """Return the share that passes each sieve, from what is retained on each."""
    if whole <= 0:
        raise ValueError("nothing is retained on any sieve")
    coarser, passing = 0.0, []
    for _, value in sorted(zip(sizes_m, values, strict=True), reverse=True):
        coarser += value
        passing.append(max(0.0, 1 - coarser / whole))
    return passing[::-1]


def _is_by_class(sizes_m: Sequence[float], values: Sequence[float], column: _Column) -> bool:
    """Return whether what is retained is given for each sieve by itself, and not with all coarser ones.

    Raises ValueError if it may be either.
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
    raise ValueError(
        "may be retained on each sieve or on it and all coarser ones; name the column "
        '"retained per class / %" or "cumulative retained / %"'
    )


def _refuse_wrong_course(names: Sequence[str], passing: Sequence[float]) -> None:
    """Raise ValueError for a curve that falls, or that does not reach the whole mass."""
    for (fine, less), (coarse, more) in pairwise(zip(names, passing, strict=True)):
        if more < less:
            raise ValueError(
                f"the curve falls: {100 * more:.4g} % pass {coarse}, and {100 * less:.4g} % the finer {fine}"
            )
    if passing[-1] < 1 - WHOLE:
        raise ValueError(
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
