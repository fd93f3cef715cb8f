"""The problems of a case: one message shows them all, each with file, key, value and a suggestion."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from orchestrator.case.file.printable import escape_unprintable
from orchestrator.case.file.units import why_refused

Key = tuple[str | int, ...]
Kind = Literal[
    "unknown-key",
    "unknown-name",
    "missing",
    "wrong-type",
    "unit",
    "out-of-range",
    "misplaced",
    "file",
    "solver",
    "conflict",
]
"""The kind of a problem: a key that its table does not have; a name that nothing has, or a word that is not
one of those wanted; a value that is not there; a value of another
type, form or number of elements; a number with a wrong unit; a number beyond its limits; parts or particles
where they cannot be; a file that cannot be read or written; a solver that cannot do it; values that do not
go together."""
BEYOND = ("greater_than", "greater_than_equal", "less_than", "less_than_equal", "finite_number")
"""The kinds of pydantic's errors that are of a number beyond its limits."""
OTHER_WORDS = {"diameter_m": "sieve_size_m"}
"""Keys of other programs, and those that mean the same here."""
REFUSED = "refused"
"""The kind of an error whose message says all that is wrong."""
PLAIN = (
    ("a valid integer", "a whole number"),
    ("a valid string", "a text"),
    ("a valid ", "a "),
    ("greater than or equal to", "at least"),
    ("less than or equal to", "at most"),
)
"""Words of pydantic, and plainer ones."""
MOST = 50  # A message shows at most so many problems.
OTHER_WAY = "it belongs to another way of giving this table: give all of one way"
LONGEST = 600  # The line about a problem has at most so many characters.


@dataclass(frozen=True)
class CaseProblem:
    """A problem at a key of the case; an empty ``key`` stands for the whole file.

    ``what`` says what is wrong, ``hint`` how to correct it, and ``kind`` is for programs.
    ``Layers.named`` fills in ``file``, because the layers know which file gave a key. ``guesses_unit``
    says that the hint takes the value for one without a unit; ``Layers.named`` leaves out such a hint
    where the user gave a unit.
    """

    key: Key
    what: str
    hint: str = ""
    file: str = ""
    guesses_unit: bool = False
    kind: Kind = "conflict"

    def __str__(self) -> str:
        place = " ".join(part for part in (self.file, dotted_key(self.key)) if part)
        return visible(f"{place}: {self.what_helps}")

    @property
    def what_helps(self) -> str:
        """What is wrong and how to correct it, without the place."""
        return f"{self.what}; {self.hint}" if self.hint else self.what

    def as_json(self) -> dict[str, str]:
        """Return the problem as a table of texts (docs/json-output.md)."""
        texts = {"what": visible(self.what), "hint": visible(self.hint)}
        return {"kind": self.kind, "file": self.file, "key": dotted_key(self.key), **texts}


class CaseError(Exception):
    """An error for a case that cannot be run as it is (exit code 2); ``problems`` lists the reasons."""

    where = "in the case"

    def __init__(self, problems: Iterable[CaseProblem]) -> None:
        self.problems = tuple(problems)
        count = len(self.problems)
        head = "1 problem" if count == 1 else f"{count} problems"
        lines = [f"{head} {self.where}:", *(f"  {problem}" for problem in self.problems[:MOST])]
        if count > MOST:
            lines.append(f"  and {count - MOST} more")
        super().__init__("\n".join(lines))

    def __reduce__(self) -> tuple[type[CaseError], tuple[tuple[CaseProblem, ...]]]:
        """Return what another process or rank makes the error of."""
        return CaseError, (self.problems,)


def dotted_key(key: Key) -> str:
    """Join a key by dots, as ``--set`` takes it: ('bed', 'sizes', 0, 'm') becomes bed.sizes.0.m."""
    return ".".join(shorten(str(part)) for part in key)


def visible(text: str) -> str:
    """Return a text as one line without control characters, cut where it becomes too long.

    Characters that cannot be printed are escaped, so that a terminal obeys none of them.
    """
    text = text if len(text) <= LONGEST else text[: LONGEST - 3] + "..."
    return escape_unprintable(text, "")


def shorten(text: str) -> str:
    """Cut a text to a readable length."""
    return text if len(text) <= 60 else text[:57] + "..."


def did_you_mean(word: str, known: Iterable[str], say: str = "known") -> str:
    """Return a hint that names the nearest known word, or all known words if none is near."""
    names = sorted(known)
    if near := _nearest(word, names):
        return f'did you mean "{near[0]}"?'
    return f"{say}: {', '.join(names)}" if names else f"{say}: none"


def _nearest(word: str, names: Sequence[str]) -> list[str]:
    """Return the name that a word is near to, or means; none if there is no such name."""
    near = difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    return near or [name for name in names if name == OTHER_WORDS.get(word)]


def show_value(value: Any) -> str:
    """Return a value as the user would write it, cut to a readable length."""
    try:
        return shorten(repr(value) if not isinstance(value, bool) else str(value).lower())
    except ValueError:  # Python does not write whole numbers of more than 4300 digits.
        return "a number of thousands of digits"


def from_validation(error: ValidationError, model: type[BaseModel]) -> list[CaseProblem]:
    """Return a case problem for each error of pydantic's validation.

    A missing key is left out if a misspelt key was obviously meant to be that key.
    """
    details = [_without_branches(detail) for detail in error.errors(include_url=False)[: 2 * MOST]]
    problems: list[CaseProblem] = []
    meant: set[Key] = set()
    for detail in details:
        if detail["type"] == "extra_forbidden":
            *table, key = detail["loc"]
            known = _keys_at(model, table)
            meant.update((*table, name) for name in _nearest(str(key), known))
            what = f"unknown key (its value: {show_value(detail['input'])})"
            hint = OTHER_WAY if key in known else did_you_mean(str(key), known)
            problems.append(CaseProblem(detail["loc"], what, hint, kind="unknown-key"))
    for detail in details:
        if detail["type"] == "missing" and detail["loc"] in meant:
            continue
        if detail["type"] != "extra_forbidden":
            problems.append(_problem(detail))
    return problems


def _without_branches(detail: ErrorDetails) -> ErrorDetails:
    """Return an error without the words in angle brackets, which name branches of a type and are no keys."""
    given = detail["loc"]
    end = len(given) - 1 if detail["type"] == "extra_forbidden" else len(given)  # an unknown key may look so
    loc = (*(part for part in given[:end] if not str(part).startswith("<")), *given[end:])
    return {**detail, "loc": loc}


def _problem(detail: ErrorDetails) -> CaseProblem:
    kind, key, value = detail["type"], detail["loc"], show_value(detail["input"])
    if kind == "missing":
        if key and isinstance(key[-1], int):
            return CaseProblem(key[:-1], f"{value} has too few values", kind="wrong-type")
        return CaseProblem(key, "missing", kind="missing")
    if kind == "too_long" and isinstance(detail["input"], list | tuple):
        return CaseProblem(
            key, f"{value} has more than {detail['ctx']['max_length']} values", kind="wrong-type"
        )
    if kind == "too_short":
        return CaseProblem(key, f"needs {detail['ctx']['min_length']} or more", kind="wrong-type")
    if key and key[-1] == "[key]":
        return CaseProblem(
            key[:-1], "a name is made of letters, digits, _ and -, at most 60", kind="wrong-type"
        )
    if kind == "string_pattern_mismatch":
        return CaseProblem(key, f"{value} has characters that cannot be shown", kind="wrong-type")
    if kind == REFUSED:
        return CaseProblem(key, detail["msg"], kind="out-of-range")
    expected = re.sub("^(Input|String) should (be )?", "", detail["msg"])
    if kind == "literal_error":
        allowed = [word.strip("' ") for word in expected.replace(" or ", ",").split(",")]
        word = detail["input"] if isinstance(detail["input"], str) else ""
        hint = did_you_mean(word, allowed) if _nearest(word, allowed) else ""
        return CaseProblem(key, f"{value} is not one of {expected}", hint, kind="unknown-name")
    if isinstance(detail["input"], str) and (why := why_refused(detail["input"], key)):
        return CaseProblem(key, f"{value} {why}", kind="unit")
    if kind == "model_type":
        expected = "a table"
    if kind == "tuple_type":
        expected = "a list"
        if isinstance(detail["input"], dict) and all(str(word).isdecimal() for word in detail["input"]):
            return CaseProblem(
                key,
                "is not in the case, so that it has no elements to change",
                "give all of it",
                kind="wrong-type",
            )
    for words, plain in PLAIN:
        expected = expected.replace(words, plain)
    what = f"must be {expected}, not {value}"
    return CaseProblem(key, what, kind="out-of-range" if kind in BEYOND else "wrong-type")


def _keys_at(model: type[BaseModel], table: Sequence[str | int]) -> list[str]:
    place: Any = model
    for part in table:
        place = _inside(place, part)
    return [key for table_type in _tables_in(place) for key in table_type.model_fields]


def _inside(place: Any, part: str | int) -> Any:
    """Return the type one step further in: of a field of a table, or of an element of a dict or tuple."""
    if tables := _tables_in(place):
        fields = (table_type.model_fields.get(str(part)) for table_type in tables)
        return next((field.annotation for field in fields if field), None)
    arguments = get_args(place)
    if get_origin(place) is dict:
        return arguments[1]
    if get_origin(place) is tuple:
        return arguments[0]
    return next((inner for each in arguments if (inner := _inside(each, part)) is not None), None)


def _tables_in(place: Any) -> list[type[BaseModel]]:
    """Return the tables that a type is or may be (as in ``Table | None``); none for any other type."""
    if isinstance(place, type) and issubclass(place, BaseModel):
        return [place]
    if get_origin(place) in (dict, tuple):
        return []
    return [table for argument in get_args(place) for table in _tables_in(argument)]
