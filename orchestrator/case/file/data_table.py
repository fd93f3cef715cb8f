"""Tables of measured data, as spreadsheets, laboratories, testing machines and particle codes write them.

One reader finds the encoding, the line with the columns' names, the separator (``sep=``, semicolon, tab,
comma or blanks), the decimal mark and the units (``Amplitude [mm]``, ``amplitude_mm``, a line of units below
the names, or a unit in a cell).  What cannot be known from the file is asked for and never guessed.
"""

from __future__ import annotations

import codecs
import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from itertools import pairwise

import numpy as np

from orchestrator.case.file.errors import did_you_mean, show_value
from orchestrator.case.file.units import is_unit, parse_quantity
from orchestrator.case.tables.quantities import same_unit, unit_of
from orchestrator.ports import Array

NUMBER = r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?"
MARKED = re.compile(r"[-+]?[\d.,]*[.,][\d.,]*(?:[eE][-+]?\d+)?")
THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(?:[.,]\d{3})+")
MANY_MARKS = re.compile(r"[-+]?\d+(?:[.,]\d+){2,}")
CELL = re.compile(rf"({NUMBER})\s*(\S.*)?")
COMMENT = re.compile(r"\s*(?:#(?!\s*\d+\s*[;,\t])|//)")
INLINE_COMMENT = re.compile(r"\s#\s.*")
NO_TEXT = re.compile(r"[\x00-\x08\x0e-\x1f\x7f]")
WORKBOOKS = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0")
COMPRESSED = (b"\x1f\x8b", b"BZh", b"\xfd7zXZ")
PERCENT = re.compile(r"(?:wt|mass|m|vol|gew|ma)?[.\- ]*%|percent|per cent|pct", re.IGNORECASE)
PURE = ("-", "–", "1")
SPELLED = {
    r"\bN(s|m)\b": r"N \1",
    r"\bkN(s|m)\b": r"kN \1",
    r"[*·]": " ",
    r"\bsec\b": "s",
    r"\bdegrees?\b": "deg",
}
IGNORE = "ignore"
MOST_PROBLEMS = 20


class TableError(ValueError):
    """An error for a table that cannot be read, or not for certain, with a sentence for each fault."""

    def __init__(self, *reasons: str) -> None:
        self.reasons = reasons[:MOST_PROBLEMS]
        super().__init__("; ".join(self.reasons))


@dataclass(frozen=True)
class Column:
    """A column of a table.

    ``head`` is its name as written, ``name`` the words of it in small letters without the unit, ``unit`` what
    the file says ("%", "1" for a pure number, "" for nothing).  ``cells`` are texts, or numbers (n,) of a
    binary file, of the ``lines`` of the file; ``comma`` tells whether numbers have decimal commas.
    """

    head: str
    name: str
    unit: str
    cells: Sequence[str] | Array
    lines: Sequence[int]
    comma: bool = False

    @property
    def texts(self) -> list[str]:
        """The cells as texts; whole numbers have no decimals."""
        if isinstance(self.cells, np.ndarray):
            return [f"{value:g}" if isinstance(value, float) else str(value) for value in self.cells.tolist()]
        return [*self.cells]

    def numbers(self, key: str = "", unit: str = "", empty: bool = False) -> Array:
        """Return the cells (n,) in the unit of ``key``; NaN for an empty cell where ``empty`` allows it.

        ``unit`` is that of a column without one.  A key without unit takes plain numbers, with or without a
        "%" sign.  Raises TableError with all cells that are no finite numbers, and for a wrong unit.
        """
        own = unit_of(key, "") if key else ""
        unit = self.unit or unit
        try:
            factor = Decimal(repr(parse_quantity(f"1 {unit}", key))) if own and unit else Decimal(1)
        except ValueError as error:
            raise TableError(f"column {show_value(self.head)}, in {unit}, {error}") from None
        if isinstance(self.cells, np.ndarray):
            values = self.cells.astype(float) * float(factor)
        elif (fast := self._plain() if factor == 1 and not self.comma else None) is not None:
            return fast
        else:
            values = np.array([self._number(cell, key if own else "", factor) for cell in self.cells])
        wrong = ~np.isfinite(values)
        if empty:
            wrong &= np.array([cell != "" for cell in self.texts], dtype=bool)
        if wrong.any():
            raise TableError(*(self._no_number(int(row)) for row in np.flatnonzero(wrong)))
        return values

    def _plain(self) -> Array | None:
        """Return the cells as numbers if all are plain ones."""
        try:
            values = np.array([*map(float, self.cells)])
        except ValueError:
            return None
        return (
            values if np.isfinite(values).all() and not any("_" in str(cell) for cell in self.cells) else None
        )

    def _number(self, cell: str, key: str, factor: Decimal) -> float:
        match = CELL.fullmatch(cell)
        if match is None:
            return np.nan
        number, unit = match[1].replace(",", ".") if self.comma else match[1], match[2]
        try:
            if unit and not (unit == "%" and not key):
                return parse_quantity(f"{number} {plain_unit(unit)}", key) if key else np.nan
            return float(Decimal(number) * factor)
        except (ValueError, ArithmeticError):
            return np.nan

    def _no_number(self, row: int) -> str:
        cell = self.texts[row]
        return (
            f"line {self.lines[row]}: {self.head} = {show_value(cell)} is not a number"
            if cell
            else (f"line {self.lines[row]}: {self.head} is empty")
        )


@dataclass(frozen=True)
class DataTable:
    """The columns of a table, all of one length.

    ``form`` is "table", or "particles" for a kind of file that a particle code writes, which names no units;
    ``note`` is what else a user should know of the reading.
    """

    columns: tuple[Column, ...]
    form: str = "table"
    note: str = ""

    def __len__(self) -> int:
        return len(self.columns[0].cells) if self.columns else 0

    def meanings(self, patterns: Mapping[str, str]) -> tuple[dict[str, Column], list[Column]]:
        """Return the column of each meaning whose pattern is its name, and the columns of none.

        Raises TableError if two columns have one meaning.
        """
        known: dict[str, Column] = {}
        others = []
        for column in self.columns:
            meaning = next(
                (key for key, pattern in patterns.items() if re.fullmatch(pattern, column.name)), None
            )
            if meaning is None:
                others.append(column)
            elif meaning in known:
                both = f"{show_value(known[meaning].head)} and {show_value(column.head)}"
                raise TableError(
                    f"columns {both} may be the same; {answer(column.head, IGNORE)} leaves one out"
                )
            else:
                known[meaning] = column
        return known, others


@dataclass(frozen=True)
class Answers:
    """What a user says of a table beyond the file: ``columns`` has a head to be taken in place of each head
    (``IGNORE`` leaves the column out), ``decimal`` is the decimal mark."""

    columns: Mapping[str, str] = field(default_factory=dict)
    decimal: str = ""

    def check(self, heads: Sequence[str]) -> None:
        """Raise TableError for answers about columns that a table with these heads does not have."""
        if unknown := [name for name in self.columns if name not in heads]:
            raise TableError(*(f'columns has "{name}"; {did_you_mean(name, heads)}' for name in unknown))


def answer(head: str, as_if: str) -> str:
    """Return the key, as a user writes it, that answers what a column is."""
    return f'columns."{head}" = "{as_if}"'


def decode(data: bytes) -> str:
    """Return the text that the bytes of a file are: UTF-8, UTF-16, or what Windows writes in Western Europe.

    Raises TableError for workbooks of spreadsheets, for compressed files and for what is no text.
    """
    if data.startswith(WORKBOOKS):
        raise TableError("is a workbook of a spreadsheet or a ZIP; save the sheet as CSV, or unpack it")
    if data.startswith(COMPRESSED):
        raise TableError("is compressed; unpack it")
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        codes = ["utf-16"]
    elif b"\0" in data[:2]:
        codes = ["utf-16-be" if data[:1] == b"\0" else "utf-16-le"]
    else:
        codes = ["utf-8-sig", "cp1252"]
    for code in codes:
        try:
            text = data.decode(code)
        except UnicodeDecodeError:
            continue
        if not NO_TEXT.search(text):
            return text
    raise TableError("is not text")


def plain_unit(text: str) -> str:
    """Return a unit as ``units`` knows it: "%" for all kinds of per cent, "1" for "-", "" for none."""
    text = text.strip(" []()")
    if PERCENT.fullmatch(text):
        return "%"
    if text in PURE:
        return "1"
    for written, spelled in SPELLED.items():
        text = re.sub(written, spelled, text)
    return text if is_unit(text) else ""


def split_head(head: str) -> tuple[str, str]:
    """Return the words of a column's name, in small letters, and its unit, which is "" if it has none."""
    text = " ".join(head.strip("#\"' ").split())
    component = re.search(r"[:_](?:\d|[xyz]|magnitude)$", text, re.IGNORECASE)
    end = component[0] if component else ""
    text = text.removesuffix(end)
    for pattern in (
        r"(.+?)\s*\[([^\]]*)\]()",
        r"(.+?)\s*\(([^)]*)\)(.*)",
        r"(.+?)(?:\s*/\s*|,\s*|\sin\s)(.+)()",
    ):
        for match in [re.fullmatch(pattern, text)]:
            if match and (unit := plain_unit(match[2])):
                return words(match[1] + match[3] + end), unit
    for match in (re.fullmatch(r"(.+?)\s(.+)", text), re.fullmatch(r"(.+)\s(\S+)", text)):
        if match and (unit := _bare_unit(match[2])):
            return words(match[1] + end), unit
    for place in (match.start() for match in re.finditer("_", text)):
        if place and (unit := _bare_unit(text[place + 1 :].replace("_per_", "/").replace("_", " "))):
            return words(text[:place] + end), unit
    if match := re.fullmatch(r"(%|percent|per cent|pct)\s*(.+)", text, re.IGNORECASE):
        return words(match[2] + end), "%"
    return words(text + end), ""


def _bare_unit(text: str) -> str:
    """Return the unit that stands without a mark behind a name; "Points 1" and "tan d" have none."""
    return "" if text in ("d", *PURE) else plain_unit(text)


def words(text: str) -> str:
    """Return the words of a text in small letters, with one blank between them."""
    return " ".join(re.findall(r"[^\W_]+|[%|'*]", text.lower().replace("\N{PRIME}", "'")))


def read_text(text: str, answers: Answers | None = None) -> DataTable:
    """Return the table that a text is.  Raises TableError."""
    answers = answers or Answers()
    rows = [
        (number, line) for number, line in enumerate(re.split(r"\r\n|\r|\n", text), 1) if line.strip(" ;,\t")
    ]
    separator = ""
    if rows and (said := re.fullmatch(r"\"?sep=(.)\"?[;,\t]*", rows[0][1].strip(" "))):
        separator, rows = said[1], rows[1:]
    comments = [line for _, line in rows if COMMENT.match(line)]
    rows = [(number, INLINE_COMMENT.sub("", line)) for number, line in rows if not COMMENT.match(line)]
    separator = separator or _separator([line for _, line in rows])
    cells = [*_split(rows, separator)]
    data = [_is_data(row) for _, row in cells] + [True]
    first = next((place for place, pair in enumerate(pairwise(data)) if all(pair)), len(cells))
    named, form = [row for _, row in cells[:first]], "table"
    if first == len(cells):
        named = named[:1]
    units: list[str] = []
    if len(named) > 1 and all(plain_unit(cell) or not cell for cell in named[-1]):
        *named, units = named
    if named:
        head = named[-1]
    else:
        head, form = _commented_head(comments, separator, cells), "particles"
    if first == len(cells):
        raise TableError("has no rows" if not any(named) or cells else "is empty: it has no rows")
    rows_of_cells = [*_even(cells[first:], len(head), separator)]
    answers.check(head)
    lines = [number for number, _ in cells[first:]]
    by_column = [*zip(*rows_of_cells, strict=True)]
    commas = _decimal_comma(by_column, separator, answers.decimal)
    units = [*units, *[""] * len(head)]
    columns = [
        _column(name, units[place], by_column[place], lines, commas, answers)
        for place, name in enumerate(head)
        if name or (any(by_column[place]) and not (place == 0 and _counts(by_column[0])))
    ]
    return DataTable(tuple(column for column in columns if column is not None), form)


def _column(
    head: str, unit: str, cells: Sequence[str], lines: Sequence[int], comma: bool, answers: Answers
) -> Column | None:
    """Return a column; None for one that the user leaves out."""
    if not head:
        raise TableError(f"a column without a name has {show_value(next(filter(None, cells)))} in it")
    as_if = answers.columns.get(head, head)
    if as_if == IGNORE:
        return None
    name, own = split_head(as_if)
    below = plain_unit(unit)
    if own and below and not same_unit(own, below):
        raise TableError(
            f"column {show_value(head)} is in {own} by its name and in {below} by the line of units"
        )
    return Column(head, name, own or below, cells, lines, comma)


def _separator(lines: Sequence[str]) -> str:
    """Return the separator that most lines have; a blank stands for any number of blanks."""
    bare = re.compile(rf"\s*(?=[-+]?\d){NUMBER}(?: +(?=[-+]?\d){NUMBER})+\s*")
    if sum(bool(bare.fullmatch(line)) for line in lines) * 2 > len(lines):
        return " "
    for mark in ";\t,|":
        if sum(mark in re.sub(r'"[^"]*"', "", line) for line in lines) * 2 > len(lines):
            return mark
    return " " if any(re.search(r"\S\s+\S", line) for line in lines) else ","


def _split(rows: Sequence[tuple[int, str]], separator: str) -> Iterator[tuple[int, list[str]]]:
    """Yield the line and the cells of each row; a name or cell in quotation marks may have several lines."""
    if separator == " ":
        apart = [re.split(r"\s{2,}|\t", line.strip()) for _, line in rows]
        wide = len(apart[-1]) > 1 and len({len(row) for row in apart}) == 1 if apart else False
        yield from (
            (n, cells if wide else line.split()) for (n, line), cells in zip(rows, apart, strict=True)
        )
        return
    try:
        reader = csv.reader((f"{line}\n" for _, line in rows), delimiter=separator, skipinitialspace=True)
        begin = 0
        for row in reader:
            yield rows[begin][0], [" ".join(cell.split()) for cell in row]
            begin = reader.line_num
    except csv.Error as error:
        raise TableError(f"cannot be read: {error}") from None


def _is_data(row: Sequence[str]) -> bool:
    """Return whether most of a row's cells are numbers, sieves or numbers with units."""
    cells = [cell for cell in row if cell]
    numbers = [cell for cell in cells if re.match(r"(?:no\.?|nr\.?|#)?\s*[-+.,]?\d", cell, re.IGNORECASE)]
    return bool(cells) and 2 * len(numbers) >= len(cells)


def _commented_head(
    comments: Sequence[str], separator: str, cells: Sequence[tuple[int, list[str]]]
) -> list[str]:
    """Return the names in the last comment with as many of them as there are columns.  Raises TableError."""
    if not cells:
        raise TableError("is empty: it has no rows")
    count = len(cells[0][1])
    for comment in reversed(comments):
        names = comment.strip().lstrip("#/ ")
        of_yade = names.removeprefix("format ").split("_")  # YADE's export.textExt: "#format x_y_z_r"
        if of_yade[-1] == "attrs":  # they are named in the last comment
            of_yade[-1:] = comments[-1].lstrip("#/ ").split()
        for head in (names.split(), re.split(r"\s{2,}", names), names.split(separator), of_yade):
            if len(head) == count and not _is_data(head):
                return [name.strip() for name in head]
    first = show_value(cells[0][1][0])
    raise TableError(f"has no line with the names of its columns above {first}; add one")


def _even(cells: Sequence[tuple[int, list[str]]], width: int, separator: str) -> Iterator[list[str]]:
    """Yield all rows with as many cells as there are names.  Raises TableError."""
    wrong = []
    for line, row in cells:
        spare = row[width:]
        if len(row) < width or any(spare):
            hint = "; do its numbers have decimal commas?" if separator == "," and any(spare) else ""
            wrong.append(f"line {line}: {len(row)} cells instead of {width}{hint}")
        yield row[:width]
    if wrong:
        raise TableError(*wrong)


def _decimal_comma(columns: Sequence[Sequence[str]], separator: str, decimal: str) -> bool:
    """Return whether numbers have decimal commas.  Raises TableError where that is unsure."""
    if decimal:
        return decimal == ","
    sure: set[str] = set()
    unsure: dict[str, str] = {}
    for cell in (cell for column in columns for cell in column if "," in cell or "." in cell):
        number = next(iter(cell.split()), "")
        if MANY_MARKS.fullmatch(number):
            raise TableError(f"{show_value(cell)} has thousands separators; write the number without them")
        if not MARKED.fullmatch(number):
            continue
        mark = "," if "," in number else "."
        if THOUSANDS.fullmatch(number):
            unsure.setdefault(mark, cell)
        else:
            sure.add(mark)
    if len(sure) > 1:
        raise TableError('has decimal points and decimal commas; decimal = "," or "." would take one of them')
    points_of_a_program = not unsure.get(",") and not sure and separator in (",", " ")
    for mark, cell in unsure.items():
        if mark not in sure and not points_of_a_program:
            whole = re.sub("[.,]", "", cell)
            raise TableError(
                f'is {show_value(cell)} {whole} or has it decimals? decimal = "," or "." answers it'
            )
    return "," in sure


def _counts(cells: Sequence[str]) -> bool:
    """Return whether a column without a name counts the rows, as spreadsheets and pandas write it."""
    return [*cells] in ([*map(str, range(start, start + len(cells)))] for start in (0, 1))
