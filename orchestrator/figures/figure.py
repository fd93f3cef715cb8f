"""The record of a figure, and the walk over the tables of results, by which each reader finds it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, Field, dataclass, field, fields, is_dataclass, replace
from functools import cache
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from orchestrator.case.tables.quantities import unit_along

Part = Literal["particles", "panels", "frames", ""]
ROUNDING = {"m": 1e-9, "m/s": 1e-9, "rad": 1e-9, "N": 1e-6, "W": 1e-9}
"""Resolution by unit where a record names none: differences that are rounding."""
SHOWN_SCALES = {"mm": 1e3, "kN": 1e-3, "kW": 1e-3, "t/h": 3.6}
"""Units in which people read figures, with the number of them in the SI unit."""
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class Figure:
    """What is known of a figure before any run.

    ``words`` name it, and ``about`` defines it further.  Differences up to ``resolution`` are not told.
    ``is_extensive``: a slice of the width has only its share of it.  ``part`` is the part of the machine that
    it describes, "" for all of it.  ``is_decisive``: it repeats itself well enough to decide, unlike single
    peaks, which a run-up may decide, and the shapes of slack panels.  ``is_of_cut``: it depends on the size
    at which fine and coarse are divided.  ``shown_in`` is the unit in which people read it, if it is another
    one.  ``path`` has its keys in ``summary.json`` with dots, with a * for any name or number.
    """

    words: str
    about: str = ""
    resolution: float | None = None
    is_extensive: bool = False
    part: Part = ""
    is_decisive: bool = True
    is_of_cut: bool = False
    shown_in: str = ""
    path: str = ""

    @property
    def unit(self) -> str:
        """Its unit, by its name and those of the tables around it; "1" of a pure number."""
        return "g" if self.path.endswith("_g") else unit_along(self.path.split("."))

    @property
    def floor(self) -> float:
        """The size up to which a difference is not told."""
        return ROUNDING.get(self.unit, 0.0) if self.resolution is None else self.resolution

    @property
    def shown_unit(self) -> str:
        """The unit in which people read it; "" of a pure number."""
        return self.shown_in or ("" if self.unit == "1" else self.unit.replace("m2", "m²"))

    @property
    def shown_scale(self) -> float:
        """How many of the shown unit are in one of its own."""
        return SHOWN_SCALES[self.shown_in] if self.shown_in else 1.0

    @property
    def label(self) -> str:
        """The words with the shown unit, for an axis or a table: "mass on the deck / kg"."""
        return f"{self.words}{in_unit(self.shown_unit)}"


def in_unit(unit: str) -> str:
    """Return a unit as it stands after words: " / mm", " / (m/s)", "" without one."""
    return "" if unit in ("", "1") else f" / ({unit})" if "/" in unit else f" / {unit}"


def figure(words: str, about: str = "", *, optional: bool = False, **known: Any) -> Any:
    """Return the field of a figure or of a table of figures; ``known`` are fields of ``Figure``.

    An ``optional`` field is None, and has no key in ``summary.json``, where a run does not have it.
    """
    record = Figure(words, about, **known)
    return field(default=None if optional else MISSING, metadata={"figure": record})


def record_of(each: Field[Any]) -> Figure:
    """Return the record of a field of a table."""
    record: Figure = each.metadata["figure"]
    return record


@cache
def kinds_of(table: type) -> dict[str, Any]:
    """Return the types of a table's fields by name, without None."""
    return {name: _without_none(kind) for name, kind in get_type_hints(table).items()}


def inner_kind(kind: Any) -> Any:
    """Return the type of the entries of a dict or list, else the type itself."""
    return _without_none(get_args(kind)[-1]) if get_origin(kind) in (dict, list) else kind


def is_table(kind: Any) -> bool:
    """Return whether a type is a table of figures, rather than a figure."""
    return is_dataclass(kind) and any("figure" in each.metadata for each in fields(kind))


def every_figure(table: type, path: str, around: Figure | None = None) -> Iterator[Figure]:
    """Yield the records of all figures of a table and of the tables in it, with their paths."""
    for each in fields(table):
        kind = kinds_of(table)[each.name]
        record = _inside(around, record_of(each), f"{path}.{each.name}")
        inner = inner_kind(kind)
        if is_table(inner):
            yield from every_figure(inner, record.path + (".*" if inner is not kind else ""), record)
        elif get_origin(kind) is dict:
            yield replace(record, path=f"{record.path}.*")
        else:
            yield record


def figure_along(table: type, words: list[str], path: str) -> Figure | None:
    """Return the record of the figure at keys below a table; None if there is no such figure.

    Keys may go on into a figure: to the components of a vector, or the half width of an estimate.
    """
    kind: Any = table
    record: Figure | None = None
    for word in words:
        if get_origin(kind) in (dict, list):
            kind = inner_kind(kind)
        elif is_table(kind):
            if word not in (known := {each.name: each for each in fields(kind)}):
                return None
            record = _inside(record, record_of(known[word]), "")
            kind = kinds_of(kind)[word]
        else:
            break
    return record and replace(record, path=".".join([path, *words]))


def _inside(around: Figure | None, record: Figure, path: str) -> Figure:
    """Return a record with its path, and with the part and the cut of the table around it."""
    if around is None:
        return replace(record, path=path)
    cut = record.is_of_cut or around.is_of_cut
    return replace(record, path=path, part=record.part or around.part, is_of_cut=cut)


def scaled(value: Any, factor: float, is_extensive: bool = False) -> Any:
    """Return a table, or an entry of one, with its extensive figures multiplied by a factor."""
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, dict):
        return {key: scaled(inner, factor, is_extensive) for key, inner in value.items()}
    if isinstance(value, list):
        return [scaled(inner, factor, is_extensive) for inner in value]
    if is_table(type(value)):
        inner = {
            each.name: scaled(getattr(value, each.name), factor, record_of(each).is_extensive)
            for each in fields(value)
        }
        return replace(value, **inner)
    if not is_extensive:
        return value
    return value.times(factor) if hasattr(value, "times") else value * factor


def to_json(value: Any) -> Any:
    """Return a table or an entry for JSON: arrays become lists, and NaN and infinity None.

    Optional fields that a run does not have are left out.
    """
    if hasattr(value, "as_json"):
        return to_json(value.as_json())
    if is_dataclass(value):
        entries = {each.name: (getattr(value, each.name), each.default) for each in fields(value)}
        return {name: to_json(inner) for name, (inner, left_out) in entries.items() if inner is not left_out}
    if isinstance(value, dict):
        return {key: to_json(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [to_json(inner) for inner in value]
    if isinstance(value, np.ndarray | np.generic):
        return to_json(value.tolist())
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value


def _without_none(kind: Any) -> Any:
    """Return the type in an optional one."""
    if get_origin(kind) in (Union, UnionType):
        (kind,) = (each for each in get_args(kind) if each is not NoneType)
    return kind
