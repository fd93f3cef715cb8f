"""The completion of a case from the library of materials.

It works on the tables as the user gave them, before their types are checked, and therefore leaves alone
everything that it does not expect.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations_with_replacement, product
from typing import Any

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.layers import REPLACED_BY
from orchestrator.case.materials.library import (
    NamedMaterial,
    contact_keys,
    look_up,
    rolling_friction_of,
    shapes,
    slug,
    suggest,
)

ROLLING = "rolling_friction"


def fill_in_materials(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a case's table with the library's values for all keys of materials and contacts not given.

    A material is completed if its own name or its key ``like`` names one of the library.  A material that
    is complete without the library has nothing to do with it, whatever its name.  Contacts are added for
    all pairs of completed materials that can meet.  Names of the library with blanks are replaced by their
    slugs everywhere.  Contacts that give no rolling friction have that of the shape of their grains.  Raises
    CaseError for materials that are ``like`` one that the library does not have.
    """
    if not _is_regular(table):
        return dict(table)
    if problems := [*_unknown_models(table.get("materials", {}))]:
        raise CaseError(problems)
    case, known = _listed(table)
    materials = case["materials"] | {
        name: _completed(library, case["materials"][name]) for name, library in known.items()
    }
    contacts = [_with_rolling_friction(_filled_contact(row, known), materials) for row in case["contacts"]]
    return {**case, "materials": materials} | ({"contacts": contacts} if contacts else {})


def list_library_rows(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a case's table with the rows that ``fill_in_materials`` adds to it, without their numbers.

    Materials have the names and contacts the order that they have in the completed case, so that overlays can
    address them; what the user gave stays as it is.
    """
    return _listed(table)[0] if _is_regular(table) else dict(table)


def _is_regular(table: Mapping[str, Any]) -> bool:
    """Return whether materials and contacts are of the kinds of which they can be completed."""
    return isinstance(table.get("materials", {}), Mapping) and isinstance(table.get("contacts", []), list)


def _listed(table: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, NamedMaterial]]:
    """Return the table of ``list_library_rows``, and the library's material of each one to be completed."""
    given: Mapping[str, Any] = table.get("materials", {})
    names = dict.fromkeys([*given, *(name for _, name in _references(table, ""))])
    renamed = {name: slug(name) for name in names if look_up(name) is not None}
    case = _with_names(table, renamed)
    materials: dict[str, Any] = {renamed.get(name, name): row for name, row in given.items()}
    original = {new: name for name, new in renamed.items()}
    known: dict[str, NamedMaterial] = {}
    for name in dict.fromkeys([*materials, *renamed.values()]):
        row = materials.get(name, {})
        if not isinstance(row, Mapping):
            continue
        library = look_up(str(row.get("like", original.get(name, name))))
        # A table that lacks nothing but the shape is a material of the user's own.
        if library and {**_completed(library, row), "shape": None} != {**row, "shape": None}:
            materials[name], known[name] = row, library
    contacts = [*case.get("contacts", [])]
    contacts += [{"between": pair} for pair in _missing_pairs(case, contacts, known)]
    return {**case, "materials": materials, "contacts": contacts}, known


def _unknown_models(given: Mapping[str, Any]) -> Iterator[CaseProblem]:
    """Yield a problem for each material that is ``like`` one that the library does not have."""
    for name, row in given.items():
        like = row.get("like") if isinstance(row, Mapping) else None
        if isinstance(like, str) and look_up(like) is None:
            what = f'no material "{like}" in the library'
            yield CaseProblem(("materials", name, "like"), what, suggest(like), kind="unknown-name")


def _references(value: Any, key: str) -> Iterator[tuple[str, str]]:
    """Yield each name of a material in a table, with the name of the table that refers to it."""
    if isinstance(value, Mapping):
        for word, inner in value.items():
            if word == "material" and isinstance(inner, str):
                yield key, inner
            elif word not in ("materials", "contacts"):
                yield from _references(inner, key or word)
    elif isinstance(value, list | tuple):
        for inner in value:
            yield from _references(inner, key)


def _with_names(value: Any, renamed: Mapping[str, str]) -> Any:
    """Return tables with other names of materials wherever a key refers to one."""
    if isinstance(value, Mapping):
        return {
            word: renamed.get(inner, inner)
            if word == "material" and isinstance(inner, str)
            else [renamed.get(name, name) if isinstance(name, str) else name for name in inner]
            if word == "between" and isinstance(inner, list | tuple)
            else _with_names(inner, renamed)
            for word, inner in value.items()
        }
    if isinstance(value, list | tuple):
        return [_with_names(inner, renamed) for inner in value]
    return value


def _completed(library: NamedMaterial, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the table of a material with the library's values for all keys that it lacks."""
    return _filled(library.keys(), {key: value for key, value in row.items() if key != "like"})


def _filled(library: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """Return ``given`` with the library's values for all keys that it lacks, also in its tables."""
    filled = dict(library) | dict(given)
    for key, value in library.items():
        if isinstance(value, Mapping) and isinstance(given.get(key), Mapping):
            filled[key] = _filled(value, given[key])
    return filled


def _filled_contact(row: Any, known: Mapping[str, NamedMaterial]) -> Any:
    """Return a row of ``contacts`` with the library's values for all keys that it lacks."""
    if not isinstance(row, Mapping):
        return row
    between = row.get("between")
    if not isinstance(between, list) or len(between) != 2 or not all(str(name) in known for name in between):
        return row
    one, other = (known[str(name)] for name in between)
    library = contact_keys(one, other)
    if any(way in row for way in REPLACED_BY):
        library.pop("moisture", None)
    return _filled(library, row)


def _with_rolling_friction(row: Any, materials: Mapping[str, Any]) -> Any:
    """Return a row of ``contacts`` with the rolling friction of its grains' shapes, if it gives none.

    A shape that does not exist is the matter of another check; the row has none then.
    """
    if not isinstance(row, Mapping) or row.get(ROLLING) is not None:
        return row
    between = row.get("between")
    if not isinstance(between, list) or len(between) != 2:
        return row
    tables = [materials.get(name) if isinstance(name, str) else None for name in between]
    classes = [table.get("shape") if isinstance(table, Mapping) else None for table in tables]
    if any(shape is not None and shape not in [*shapes()] for shape in classes):
        return {**row, ROLLING: 0.0}
    friction = rolling_friction_of(*classes)
    return row if friction is None else {**row, ROLLING: friction}


def _missing_pairs(
    case: Mapping[str, Any], contacts: list[Any], known: Mapping[str, NamedMaterial]
) -> list[list[str]]:
    """Return all pairs of the library's materials that can meet and that no contact is given of."""
    references = list(_references(case, ""))
    in_bed = {name for table, name in references if table == "bed"}
    # Particles of a run or table that the case takes over may be of any grains in its ``materials``.
    grains = sorted(name for name in known if name in in_bed or known[name].material.kind == "grains")
    surfaces = sorted({name for table, name in references if table == "screen" and name in known} - {*grains})
    given = [row.get("between") for row in contacts if isinstance(row, Mapping)]
    there = {frozenset(map(str, between)) for between in given if isinstance(between, list)}
    return [
        [one, other]
        for one, other in [*combinations_with_replacement(grains, 2), *product(grains, surfaces)]
        if frozenset((one, other)) not in there and contact_keys(known[one], known[other])
    ]
