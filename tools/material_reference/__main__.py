"""The page docs/materials.md, made from the library of materials.

``python -m tools.material_reference > docs/materials.md`` writes it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path
from textwrap import fill

from orchestrator.case.materials.library import Quantity, materials, pairs, shapes, sources

TYPICAL = "typical"
WIDTH = 180
Notes = dict[tuple[str, str], list[str]]
"""The names that have a note, by key and note."""


def material_reference() -> str:
    """Return docs/materials.md."""
    lines = [
        Path(__file__).with_name("use.md").read_text(encoding="utf-8"),
        *_shapes(),
        *_materials(),
        *_contacts(),
        *_sources(),
    ]
    return "\n".join(lines).rstrip() + "\n"


def _shapes() -> Iterator[str]:
    """Yield a table of all shape classes."""
    yield "## Shapes\n\n|shape |grains |`rolling_friction`|\n|---|---|---|"
    notes: Notes = {}
    for shape in shapes().values():
        cell = _cell(shape.rolling_friction, shape.name, notes)
        yield f"|`{shape.name}` |{shape.about} |{cell}|"
    yield from _lines(notes, keyed=False)


def _materials() -> Iterator[str]:
    """Yield a table of the materials of each kind."""
    yield "## Materials\n"
    for kind, group in groupby(materials().values(), lambda material: material.kind):
        rows = [*group]
        keys = [*dict.fromkeys(key for material in rows for key in material.quantities)]
        yield f"|{kind} |{' |'.join(f'`{key}`' for key in keys)}|\n|{'---|' * (len(keys) + 1)}"
        notes: Notes = {}
        for material in rows:
            cells = [_cell(material.quantities.get(key), material.name, notes) for key in keys]
            yield f"|{material.name} |{' |'.join(cells)}|"
        yield ""
        for material in rows:
            also = f"; also {', '.join(material.also)}" if material.also else ""
            shape = f"; `{material.shape}`" if material.shape else ""
            yield f"- {material.name}: {material.about}{also}{shape}"
        yield from _lines(notes)


def _contacts() -> Iterator[str]:
    """Yield a table of all contacts."""
    keys = [*dict.fromkeys(key for pair in pairs().values() for key in pair.quantities)]
    yield "## Contacts\n"
    yield f"|materials |{' |'.join(f'`{key}`' for key in keys)}|\n|{'---|' * (len(keys) + 1)}"
    notes: Notes = {}
    for pair in pairs().values():
        name = "–".join(pair.between)
        yield f"|{name} |{' |'.join(_cell(pair.quantities.get(key), name, notes) for key in keys)}|"
    yield from _lines(notes)


def _cell(quantity: Quantity | None, name: str, notes: Notes) -> str:
    """Return a number with its range and its source, unless this is "typical"; keep its note."""
    if quantity is None:
        return ""
    if quantity.note:
        notes.setdefault((quantity.key, quantity.note), []).append(name)
    source = "" if quantity.source_id == TYPICAL else f", {quantity.source_id}"
    return f"{quantity.value:g} ({quantity.low:g}–{quantity.high:g}{source})"


def _lines(notes: Notes, keyed: bool = True) -> Iterator[str]:
    """Yield an item for each note, with its key if they are ``keyed``, between empty lines."""
    yield ""
    for (key, note), names in notes.items():
        yield _item(f"{', '.join(names)}{f', `{key}`' * keyed}: {note}")
    if notes:
        yield ""


def _item(text: str) -> str:
    """Return an item of a list."""
    return fill(f"- {text}", WIDTH, subsequent_indent="  ", break_on_hyphens=False)


def _sources() -> Iterator[str]:
    yield "## Sources\n"
    yield from (_item(f"**{name}**: {text}.") for name, text in sources().items() if name != TYPICAL)


if __name__ == "__main__":
    sys.stdout.write(material_reference())
