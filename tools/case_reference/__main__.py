"""The pages docs/case-format.md and docs/study-format.md, made from the tables of a case and a study.

``python -m tools.case_reference > docs/case-format.md`` writes the first, and
``python -m tools.case_reference study > docs/study-format.md`` the second.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from textwrap import fill
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from orchestrator.case.solvers import Port, ShapeNames, SolverName, adapter, names
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import Table
from orchestrator.preflight.judgement.catalogue import EFFECTS
from orchestrator.preflight.scene.effect import Part
from orchestrator.studies.design.study_file import StudyFile
from tools.case_reference.texts import texts_of

ROWS = "tables"
"""A list of tables, in words."""
HEAD = "|key |value |meaning|\n|---|---|---|"
SMALL = 3
"""A table with so many keys and no tables in it has no section of its own."""
SIGNS = {"gt": ">", "ge": "≥", "lt": "<", "le": "≤"}
WIDTH = 160
LARGEST_PRINTED = 2**31
"""Limits of the computer's integers, above it, are not printed."""
PAGE_NAMED = re.compile(r"(?<!\])\((?:docs/)?((?:theory|how-to)/[\w-]+\.md|materials\.md)\)")


Seen = dict[type[BaseModel], str]
"""The tables so far, with the headings of their sections."""


def case_reference() -> str:
    """Return docs/case-format.md."""
    return _page(_rules("case"), *_effects(), *_of_solvers(), *_sections(Case, "", {}, "case.toml"))


def study_reference() -> str:
    """Return docs/study-format.md."""
    return _page(_rules("study"), *_sections(StudyFile, "", {}, "study.toml"))


def _page(*lines: str) -> str:
    return "\n".join(lines).rstrip() + "\n"


def _rules(of: str) -> str:
    """Return a part of the page that is written by hand."""
    return Path(__file__).with_name(f"{of}_rules.md").read_text(encoding="utf-8")


def _effects() -> Iterator[str]:
    """Yield the lines of the table of all effects, by part of the machine."""
    yield _rules("effect")
    yield "|effect of |key|\n|---|---|"
    for part in get_args(Part):
        yield f"|**{part}**||"
        for name, effect in EFFECTS.items():
            if effect.part == part:
                named = f"`{name}`" if effect.optional else f"*{name}*"
                laws = f" ({', '.join(effect.laws)})" if effect.laws else ""
                yield f"|{named}{laws} |{effect.key}|"
    yield ""


def _of_solvers() -> Iterator[str]:
    """Yield the lines of the table of all solvers, with the descriptions by their adapters."""
    yield _rules("solver")
    yield "|solver |what it is |what it leaves out|\n|---|---|---|"
    ports: tuple[Port, ...] = get_args(Port)
    for port in ports:
        for name in names(port):
            solver = adapter(port, name)
            yield f"|{port}: `{name}` |{solver.about} |{', '.join(solver.leaves_out)}|"
    yield ""


def _sections(table: type[BaseModel], path: str, seen: Seen, file: str) -> Iterator[str]:
    """Yield the keys of a table, then the keys of the tables in it; each table, and each base that tables
    share, has its keys in one section.  The section of the outermost table is named after the ``file``."""
    heading = f"`{path or file}`"
    shared: Any = table.__mro__[1]
    seen[table] = heading
    yield f"## {heading}\n"
    yield fill(_text(table.__doc__), WIDTH) + "\n"
    keys = dict(table.model_fields)
    if shared is not Table and (first := seen.setdefault(shared, heading)) != heading:
        keys = {key: field for key, field in keys.items() if key not in shared.model_fields}
        same = ", ".join(f"`{key}`" for key in shared.model_fields)
        yield fill(f"As in {first}: {same}.", WIDTH) + "\n"
    yield "\n".join([HEAD, *_rows(table, keys, "", seen)]) + "\n"
    sections = []
    for key, field in keys.items():
        tables = tables_in(field.annotation)
        for within, place in tables:
            if within not in seen:
                name = f"{path.strip('[]')}.{key}{place}".lstrip(".")
                other_way = "" if within is tables[0][0] else f"` with `{_wanted(within)}"
                name = (f"[[{name}]]" if _is_list(field) else f"[{name}]") + other_way
                sections.append((within, name, field))
    if not path:
        named = (f"**`{name}`**" if field.is_required() else f"`{name}`" for _, name, field in sections)
        yield fill(f"Tables: {', '.join(named)}.", WIDTH, break_on_hyphens=False) + "\n"
    for within, name, _ in sections:
        yield from _sections(within, name, seen, file)


def _rows(table: type[BaseModel], keys: Mapping[str, FieldInfo], above: str, seen: Seen) -> Iterator[str]:
    """Yield the rows of keys of a table, and of those in small tables, whose names have the key ``above``."""
    texts = texts_of(table)
    for key, field in keys.items():
        tables = tables_in(field.annotation)
        folded = [(within, place) for within, place in tables if within not in seen and _is_small(within)]
        if not tables or _choices(field.annotation):
            yield f"|`{above}{key}` |{_value(field)} |{_text(texts.get(key))}|"
        for within, place in folded:
            if not _choices(field.annotation):
                kind = "**table**" if field.is_required() else "tables" if _is_list(field) else "table"
                yield f"|`{key}{place}` |{kind} |{_text(within.__doc__)}|"
            seen[within] = key
            yield from _rows(within, within.model_fields, f"{key}{place}.", seen)


def _is_small(table: type[BaseModel]) -> bool:
    """Return whether the keys of a table stand among those of the table around it."""
    fields = table.model_fields.values()
    return len(fields) <= SMALL and not any(tables_in(field.annotation) for field in fields)


def _wanted(table: type[BaseModel]) -> str:
    """Return the first key that a table must give."""
    own = [key for key in table.__annotations__ if key in table.model_fields]
    return next(key for key in own if table.model_fields[key].is_required())


def _value(field: FieldInfo) -> str:
    """Return what a key may be: its default, if it has one, or the kind of its value, with its limits."""
    default, words = _default(field), _words(field)
    limits = _limits(field.annotation, field.metadata)
    if choices := _choices(field.annotation):
        value = " or ".join(_limits(each) or _kind(each) for each in choices)
    elif words:
        value = ", ".join(f"`{word}`" if word == default else word for word in words)
    elif default:
        value = ", ".join(filter(None, (f"`{default}`", limits)))
    else:
        kind = _kind(field.annotation)
        value = limits if kind == "number" and limits else ", ".join(filter(None, (kind, limits)))
    return f"**{value}**" if field.is_required() else value


def _words(field: FieldInfo) -> list[str]:
    """Return the words that a value may be, as solvers, shapes and switches; none where it may be another."""
    marks = [mark for mark in field.metadata if isinstance(mark, SolverName | ShapeNames)]
    if marks:
        return [f'"{name}"' for mark in marks for name in mark.allowed]
    kind = _kind(field.annotation)
    return kind.split(", ") if kind.startswith(('"', "true")) and " or " not in kind else []


def _text(words: str | None) -> str:
    """Return a docstring in Markdown, with links to the pages that it names."""
    text = " ".join((words or "").split()).replace("``", "`")
    return PAGE_NAMED.sub(r"([more](\1))", text)


def _is_list(field: FieldInfo) -> bool:
    """Return whether the tables of a field are rows of a list."""
    return any(_kind(each) == ROWS for each in (field.annotation, *_choices(field.annotation)))


def _choices(kind: Any) -> list[Any]:
    """Return the types of a value that is a list of tables or something else; none of any other value."""
    choices = list(get_args(kind)) if get_origin(kind) in (Union, UnionType) else []
    return choices if ROWS in map(_kind, choices) and NoneType not in choices else []


def tables_in(kind: Any) -> list[tuple[type[BaseModel], str]]:
    """Return the tables in values of this type, each with the part of its name after the key."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return [(kind, "")]
    place = ".<name>" if get_origin(kind) is dict else ""
    return [(table, place + inner) for argument in get_args(kind) for table, inner in tables_in(argument)]


def _kind(kind: Any) -> str:
    """Return a type in words."""
    origin, arguments = get_origin(kind), get_args(kind)
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return "table"
    if kind is NoneType:
        return "none"
    if origin is Annotated:
        return _kind(arguments[0])
    if origin is Literal:
        return ", ".join(f'"{word}"' if isinstance(word, str) else str(word) for word in arguments)
    if origin is tuple:
        inner = _kind(arguments[0])
        if arguments[-1] is Ellipsis:
            return f"rows of {inner}" if get_origin(arguments[0]) is tuple else f"{inner}s"
        return f"{len(arguments)}×{inner}" if inner[0].isdecimal() else f"{len(arguments)} {inner}s"
    if origin is dict:
        return f"table of {_kind(arguments[1])}"
    if origin in (Union, UnionType):
        return " or ".join(_kind(one) for one in arguments if one is not NoneType)
    return {float: "number", int: "integer", bool: "true, false", str: "text"}[kind]


def _limits(kind: Any, metadata: Sequence[Any] = ()) -> str:
    """Return the limits of a number, "" without any."""
    ends = {}
    for mark in (*metadata, *_marks(kind)):
        for sign, value in asdict(mark).items() if isinstance(mark, Gt | Ge | Lt | Le) else ():
            if value < LARGEST_PRINTED or sign == "le":
                ends[sign] = f"{value:g}"
    if ends.keys() == {"ge", "le"}:
        return f"{ends['ge']}..{ends['le']}"
    return ", ".join(f"{SIGNS[sign]}{value}" for sign, value in ends.items())


def _marks(kind: Any) -> Iterator[Any]:
    yield from getattr(kind, "__metadata__", ())
    for argument in get_args(kind):
        yield from _marks(argument)


def _default(field: FieldInfo) -> str:
    """Return the default in TOML; "" for a key that has none."""
    value = None if field.is_required() else field.get_default(call_default_factory=True)
    if value is None or value in ({}, ()):
        return ""
    if isinstance(value, tuple):
        value = list(value)
    text = str(value).lower() if isinstance(value, bool) else repr(value).replace("'", '"')
    return text.replace(", ", ",")


if __name__ == "__main__":
    sys.stdout.write(study_reference() if sys.argv[1:] == ["study"] else case_reference())
