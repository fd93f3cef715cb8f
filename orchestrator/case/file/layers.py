"""The layers of a case: its TOML files and overrides, merged, with the source of each key.

Tables are merged key by key; any other value is replaced as a whole.  An overlay addresses an element
of a list by its number, as if the list were a table: ``contacts.0.restitution``.  If an overlay gives a
quantity in another way than the layers below it, the other way is gone.
"""

from __future__ import annotations

import re
import tomllib
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.file.nested import nested, value_at
from orchestrator.case.file.units import in_own_units, keys_with_units

DEEPEST = 20  # So many tables may lie in each other; the case format has 7.
TOO_DEEP = "is nested too deeply"
PLACE = re.compile(r"at line (\d+), column (\d+)")
DECIMAL_COMMA = re.compile(r"(?<![\d.,])\d+,\d+(?![\d.]|,\d{3})")  # and no thousands
LARGEST_BYTES = 1_000_000  # The largest case of this project has 10 000.


def read_toml(file: Path, within: Path | None = None) -> dict[str, Any]:
    """Read the table in a file.

    Raises CaseError if the file cannot be read, is not TOML, or lies outside of the folder ``within``.
    """
    text = hint = ""
    try:
        if within is not None and is_outside(file, within):
            what = "is a link to a file outside of the case's folder"
        elif file.exists() and not file.is_file():
            what = "is not a file"
        else:
            with file.open("rb") as opened:
                content = opened.read(LARGEST_BYTES + 1)
            what = f"is larger than {LARGEST_BYTES} bytes"
            if len(content) <= LARGEST_BYTES:
                text = content.decode("utf-8-sig")
                table = tomllib.loads(text)
                if not is_too_deep(table):
                    return table
                what = TOO_DEEP
    except OSError as error:
        what = f"cannot be read: {error.strerror}"
    except UnicodeDecodeError:
        what = "is not a text file in UTF-8"
    except ValueError as error:
        what, hint = f"is not TOML: {error}", _hint_at(text, str(error))
    except RecursionError:
        what = TOO_DEEP
    except RuntimeError:
        what = "is a link to itself"
    raise CaseError([CaseProblem((), what, hint, str(file), kind="file")])


def _hint_at(text: str, error: str) -> str:
    """Return how to correct the place in a text that an error of TOML names; "" where it is not clear."""
    place = PLACE.search(error)
    if place is None:
        return ""
    line, column = text.split("\n")[int(place[1]) - 1], int(place[2])
    for number in DECIMAL_COMMA.finditer(line):
        if number.start() < column <= number.end() + 1:
            return f"write a decimal point: {number[0].replace(',', '.')}"
    there = line[column - 1 : column]
    if there.isascii():
        return ""
    return f"the character there is a {unicodedata.name(there, 'special one').lower()}; write a plain one"


def is_too_deep(given: Any) -> bool:
    """Return whether tables are nested more deeply than the recursive functions of a run can follow."""
    inside: list[Any] = [given]
    for _ in range(DEEPEST):
        tables = [list(v.values()) if isinstance(v, dict) else v for v in inside]
        inside = [value for table in tables if isinstance(table, list) for value in table]
    return bool(inside)


def is_outside(file: Path, folder: Path) -> bool:
    """Return whether a file really lies outside of a folder, by ``..`` or by links."""
    return not file.resolve().is_relative_to(folder.resolve())


NAMES_FILE = "file"
"""The key of a table that stands for a list and names the file with its elements."""
OF_PATTERNS = (
    *("shape", "length_m", "width_m", "pitch_along_m", "pitch_across_m"),
    *("stagger", "margin_along_m", "margin_across_m"),
)
"""Keys of a pattern of openings, for which a drawing may stand."""
REPLACED_BY = {
    "work_of_adhesion_J_per_m2": ("bond_number", "bond_diameter_m", "moisture"),
    "bond_number": ("work_of_adhesion_J_per_m2", "moisture"),
    "moisture": ("work_of_adhesion_J_per_m2", "bond_number", "bond_diameter_m"),
    "loss_curve": ("maxwell",),
    "sizes": ("curve",),
    "curve": ("sizes",),
    "points": ("file", "elastic_N_per_m", "friction", "maxwell"),
    "file": ("points", "elastic_N_per_m", "friction", "maxwell", *OF_PATTERNS),
    "pitch_along_m": ("file", "unit", "layers", "rotation_deg"),
}
"""Keys that a key of a later layer replaces, because it gives the same quantity in another way.

Elements that were fitted to a measured curve go when a later layer gives another curve."""


class Layers:
    """A stack of tables laid over each other; ``merged`` is the table that all of them make.

    Numbers with units are in the units of their keys (units.py).
    """

    def __init__(self, given: Mapping[str, Any], source: str) -> None:
        self._first = source
        self._source: dict[tuple[str, ...], str] = {}
        self._with_units = {*keys_with_units(given)}
        self.merged: dict[str, Any] = in_own_units(given)

    def copy(self) -> Layers:
        """Return a copy of these layers, over which others can be laid."""
        twin = Layers(self.merged, self._first)
        twin._source, twin._with_units = dict(self._source), {*self._with_units}
        return twin

    def lay(self, overlay: Mapping[str, Any], source: str) -> None:
        """Lay a table from ``source`` over the others; a value of None removes its key.

        Raises CaseError if the table addresses an element that a list does not have.
        """
        self.merged = self._over(self.merged, in_own_units(overlay), (), source)
        self._with_units |= {*keys_with_units(overlay)}

    def source(self, key: Key) -> str:
        """Return the file or option that last gave this key or the table that holds it.

        Of a list whose elements were changed later, it names those that changed them, too.
        """
        words = tuple(str(part) for part in key)
        below = [self._source[words[:end]] for end in range(len(words), 0, -1) if words[:end] in self._source]
        own = below[0] if below else self._first
        if not isinstance(value_at(self.merged, words), list):
            return own
        changed = [source for other, source in self._source.items() if other[: len(words)] == words]
        return ", ".join(dict.fromkeys((own, *changed)))

    def named(self, problems: Sequence[CaseProblem]) -> list[CaseProblem]:
        """Return the problems with their files filled in, without guesses at units that the user gave."""
        told = [
            replace(m, hint="") if m.guesses_unit and tuple(map(str, m.key)) in self._with_units else m
            for m in problems
        ]
        return [m if m.file else replace(m, file=self.source(m.key)) for m in told]

    def _over(self, below: Any, overlay: Any, key: tuple[str, ...], source: str) -> Any:
        """Return ``overlay`` merged over ``below`` at ``key``, and change neither of them."""
        if not isinstance(overlay, Mapping):
            self._give_whole(below, key, source)
            return overlay
        if isinstance(below, list) and NAMES_FILE not in overlay:
            below = list(below)
            for word, value in overlay.items():
                number = _number(word, below, key, source)
                below[number] = self._over(below[number], value, (*key, word), source)
            return below
        if not isinstance(below, Mapping):
            self._give_whole(below, key, source)
            below = {}
        other_ways = {other for word in overlay for other in REPLACED_BY.get(word, ())} - overlay.keys()
        for other in other_ways & below.keys():
            self._forget((*key, other))
        merged = {word: value for word, value in below.items() if word not in other_ways}
        for word, value in overlay.items():
            merged[word] = self._over(below.get(word), value, (*key, word), source)
            if value is None:
                del merged[word]
        return merged

    def _give_whole(self, below: Any, key: tuple[str, ...], source: str) -> None:
        """Note that ``source`` gives all that stands at a key, in place of ``below``, None if nothing stood
        there."""
        if below is not None:
            self._forget(key)
        self._source.pop(key, None)
        self._source[key] = source
        self._with_units.discard(key)

    def _forget(self, key: tuple[str, ...]) -> None:
        """Forget what was known of a key and of all below it."""
        self._source = {at: by for at, by in self._source.items() if at[: len(key)] != key}
        self._with_units = {at for at in self._with_units if at[: len(key)] != key}


def _number(word: str, below: Sequence[Any], key: Key, source: str) -> int:
    """Return the number of an element of the list ``below``.  Raises CaseError if it has no such element."""
    if word.isdecimal() and int(word) < len(below):
        return int(word)
    what = f'"{word}" is not an element of this list'
    hint = f"its elements are numbered 0 to {len(below) - 1}" if below else "it is empty"
    raise CaseError([CaseProblem((*key, word), what, hint, source, kind="unknown-name")])


def parse_override(override: str) -> dict[str, Any]:
    """Return an override, 'panel.solver=rigid', as an overlay, {"panel": {"solver": "rigid"}}.

    A value that is not TOML counts as a bare string.  Raises CaseError for text without key or "=".
    """
    path, equals, text = override.partition("=")
    words = [word.strip() for word in path.split(".")]
    if not equals or not all(words):
        hint = "for example --set panel.solver=rigid"
        raise CaseError([CaseProblem((), "is not key=value", hint, f"--set {override}", kind="wrong-type")])
    overlay = nested(words, _value(text.strip()))
    if is_too_deep(overlay):
        raise CaseError([CaseProblem((), TOO_DEEP, file=f"--set {override}", kind="wrong-type")])
    return overlay


def _value(text: str) -> Any:
    """Return the TOML value that a text denotes; the text itself if it is not TOML."""
    try:
        table = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return table["value"] if list(table) == ["value"] else text


def find_changes(before: Any, after: Any, key: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """Yield the keys, as tuples of words below ``key``, whose values differ between two tables."""
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        for word in dict.fromkeys((*before, *after)):
            yield from find_changes(before.get(word), after.get(word), (*key, word))
    elif before != after:
        yield key
