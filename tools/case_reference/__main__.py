"""The pages docs/case-format.md and docs/study-format.md, made from the tables of a case and a study.

``python -m tools.case_reference > docs/case-format.md`` writes the first, and
``python -m tools.case_reference study > docs/study-format.md`` the second.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from orchestrator.case.solvers import Port, ShapeNames, SolverName, adapter, names
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import unit_of
from orchestrator.preflight.judgement.catalogue import EFFECTS
from orchestrator.preflight.scene.effect import Part
from orchestrator.studies.design.study_file import StudyFile

ROWS = "tables"
"""A list of tables, in words."""
EFFECTS_TABLE = """\
| effect | part | can be left out | laws | what else has it or not |
| --- | --- | --- | --- | --- |"""


def case_reference() -> str:
    """Return docs/case-format.md."""
    return _page(_rules("case"), *_effects(), *_of_solvers(), *_sections(Case, "", set(), "case.toml"))


def study_reference() -> str:
    """Return docs/study-format.md."""
    return _page(_rules("study"), *_sections(StudyFile, "", set(), "study.toml"))


def _page(*lines: str) -> str:
    return "\n".join(lines).rstrip() + "\n"


def _rules(of: str) -> str:
    """Return a part of the page that is written by hand."""
    return Path(__file__).with_name(f"{of}_rules.md").read_text(encoding="utf-8")


def _effects() -> Iterator[str]:
    """Yield the lines of the table of all effects, by part of the machine."""
    yield _rules("effect")
    yield EFFECTS_TABLE
    for part in get_args(Part):
        for name, effect in EFFECTS.items():
            if effect.part == part:
                left_out = "yes" if effect.optional else "no"
                laws = ", ".join(f"`{law}`" for law in effect.laws)
                yield f"| `{name}` | {part} | {left_out} | {laws} | {effect.key} |"
    yield ""


def _of_solvers() -> Iterator[str]:
    """Yield the lines of the table of all solvers, with the descriptions by their adapters."""
    yield _rules("solver")
    yield "| port | solver | what it is | what it leaves out |\n| --- | --- | --- | --- |"
    ports: tuple[Port, ...] = get_args(Port)
    for port in ports:
        for name in names(port):
            solver = adapter(port, name)
            yield f"| `{port}` | `{name}` | {solver.about} | {', '.join(solver.leaves_out)} |"
    yield ""


def _sections(table: type[BaseModel], path: str, seen: set[type[BaseModel]], file: str) -> Iterator[str]:
    """Yield the keys of a table, then the keys of the tables in it; each table has one section.  The section
    of the outermost table is named after the ``file``."""
    seen.add(table)
    yield f"## `{path or file}`"
    yield f"\n{_text(table.__doc__)}\n"
    yield "| key | value | unit | default | meaning |\n| --- | --- | --- | --- | --- |"
    inner = []
    for key, field in table.model_fields.items():
        tables = tables_in(field.annotation)
        yield _row(key, field, bool(tables))
        for inner_table, place in tables:
            if inner_table not in seen:
                name = f"{path.strip('[]')}.{key}{place}".lstrip(".")
                other_way = "" if inner_table is tables[0][0] else f"` with `{_wanted(inner_table)}"
                inner.append((inner_table, (f"[[{name}]]" if _is_list(field) else f"[{name}]") + other_way))
    yield ""
    for inner_table, place in inner:
        yield from _sections(inner_table, place, seen, file)


def _wanted(table: type[BaseModel]) -> str:
    """Return the first key that a table must give."""
    own = [key for key in table.__annotations__ if key in table.model_fields]
    return next(key for key in own if table.model_fields[key].is_required())


def _row(key: str, field: FieldInfo, holds_tables: bool) -> str:
    if choices := _choices(field.annotation):
        value = " or ".join(_kind(each) + _limits(each) for each in choices)
    elif holds_tables:
        value = "tables" if get_origin(field.annotation) in (dict, tuple) else "table"
    else:
        value = _solvers(field) or _kind(field.annotation) + _limits(field.annotation, field.metadata)
    meaning = _text(field.description)
    return f"| `{key}` | {value} | {unit_of(key, '')} | {_default(field)} | {meaning} |"


def _solvers(field: FieldInfo) -> str:
    """Return the solvers or shapes that a key may name, or "" for a key that names none."""
    marks = [mark for mark in field.metadata if isinstance(mark, SolverName | ShapeNames)]
    return " or ".join(f'"{name}"' for mark in marks for name in mark.allowed)


def _text(words: str | None) -> str:
    return " ".join((words or "").split()).replace("``", "`")


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
        return " or ".join(f'"{word}"' if isinstance(word, str) else str(word) for word in arguments)
    if origin is tuple:
        if arguments[-1] is Ellipsis and _kind(arguments[0]) == "table":
            return ROWS
        if arguments[-1] is Ellipsis:
            return f"list of [{_kind(arguments[0])}]"
        return f"{len(arguments)} x {_kind(arguments[0])}"
    if origin is dict:
        return f"table of name = {_kind(arguments[1])}"
    if origin in (Union, UnionType):
        return " or ".join(_kind(one) for one in arguments if one is not NoneType)
    return {float: "number", int: "whole number", bool: "true or false", str: "text"}[kind]


def _limits(kind: Any, metadata: Sequence[Any] = ()) -> str:
    formats = {Gt: "> {0.gt}", Ge: ">= {0.ge}", Lt: "< {0.lt}", Le: "<= {0.le}"}
    marks = [*metadata, *_marks(kind)]
    limits = [formats[type(mark)].format(mark) for mark in marks if type(mark) in formats]
    return " " + ", ".join(dict.fromkeys(limits)) if limits else ""


def _marks(kind: Any) -> Iterator[Any]:
    yield from getattr(kind, "__metadata__", ())
    for argument in get_args(kind):
        yield from _marks(argument)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "must be given"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, BaseModel):
        return "see there"
    if value is None or value in ({}, ()):
        return "none"
    if isinstance(value, tuple):
        value = list(value)
    text = str(value).lower() if isinstance(value, bool) else repr(value).replace("'", '"')
    return f"`{text}`"


if __name__ == "__main__":
    sys.stdout.write(study_reference() if sys.argv[1:] == ["study"] else case_reference())
