"""The page docs/case-format.md, made from the tables of a case:

python -m tools.case_reference > docs/case-format.md
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from orchestrator.case.solvers import Port, SolverName, adapter, names
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import unit_of
from orchestrator.preflight.judgement.catalogue import EFFECTS
from orchestrator.preflight.scene.effect import Part

EFFECTS_TABLE = """\
| effect | part | can be left out | laws | what else has it or not |
| --- | --- | --- | --- | --- |"""


def reference() -> str:
    """Return the whole page."""
    return (
        "\n".join([_rules("case"), *_effects(), *_of_solvers(), *_sections(Case, "", set())]).rstrip() + "\n"
    )


def _rules(of: str) -> str:
    """Return what is written by hand."""
    return Path(__file__).with_name(f"{of}_rules.md").read_text(encoding="utf-8")


def _effects() -> Iterator[str]:
    """Yield a table of all effects, by part."""
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
    """Yield a table of all solvers, with what their adapters say of them."""
    yield _rules("solver")
    yield "| port | solver | what it is | what it leaves out |\n| --- | --- | --- | --- |"
    ports: tuple[Port, ...] = get_args(Port)
    for port in ports:
        for name in names(port):
            able = adapter(port, name)
            yield f"| `{port}` | `{name}` | {able.about} | {', '.join(able.leaves_out)} |"
    yield ""


def _sections(table: type[BaseModel], path: str, seen: set[type[BaseModel]]) -> Iterator[str]:
    """Yield this table's keys, then those of the tables in it; each table once."""
    seen.add(table)
    yield f"## `{path}`" if path else "## `case.toml`"
    yield f"\n{_text(table.__doc__)}\n"
    yield "| key | value | unit | default | meaning |\n| --- | --- | --- | --- | --- |"
    inner = []
    for key, field in table.model_fields.items():
        found, place = table_in(field.annotation)
        yield _row(key, field, found)
        if found is not None and found not in seen:
            name = f"{path.strip('[]')}.{key}{place}".lstrip(".")
            inner.append((found, f"[[{name}]]" if _is_list(field) else f"[{name}]"))
    yield ""
    for found, place in inner:
        yield from _sections(found, place, seen)


def _row(key: str, field: FieldInfo, table: type[BaseModel] | None) -> str:
    if table is not None:
        value = "tables" if get_origin(field.annotation) in (dict, tuple) else "table"
    else:
        value = _solvers(field) or _kind(field.annotation) + _limits(field)
    meaning = _text(field.description)
    return f"| `{key}` | {value} | {unit_of(key, '')} | {_default(field)} | {meaning} |"


def _solvers(field: FieldInfo) -> str:
    """Return what a key may be that names a solver, "" for another key."""
    marks = [mark for mark in field.metadata if isinstance(mark, SolverName)]
    return " or ".join(f'"{name}"' for mark in marks for name in mark.allowed)


def _text(words: str | None) -> str:
    return " ".join((words or "").split()).replace("``", "`")


def _is_list(field: FieldInfo) -> bool:
    """Return whether the tables of a field are rows of a list."""
    return get_origin(field.annotation) is tuple


def table_in(kind: Any) -> tuple[type[BaseModel] | None, str]:
    """Return the table that a value of this type is made of, if any, and how its name goes on."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind, ""
    place = ".<name>" if get_origin(kind) is dict else ""
    for argument in get_args(kind):
        found, inner = table_in(argument)
        if found is not None:
            return found, place + inner
    return None, ""


def _kind(kind: Any) -> str:
    """Return a type in words."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _kind(arguments[0])
    if origin is Literal:
        return " or ".join(f'"{word}"' for word in arguments)
    if origin is tuple:
        if arguments[-1] is Ellipsis:
            return f"list of [{_kind(arguments[0])}]"
        return f"{len(arguments)} x {_kind(arguments[0])}"
    if NoneType in arguments:
        return " or ".join(_kind(one) for one in arguments if one is not NoneType)
    return {float: "number", int: "whole number", bool: "true or false", str: "text"}[kind]


def _limits(field: FieldInfo) -> str:
    said = {Gt: "> {0.gt}", Ge: ">= {0.ge}", Lt: "< {0.lt}", Le: "<= {0.le}"}
    marks = [*field.metadata, *_marks(field.annotation)]
    found = [said[type(mark)].format(mark) for mark in marks if type(mark) in said]
    return " " + ", ".join(dict.fromkeys(found)) if found else ""


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
    sys.stdout.write(reference())
