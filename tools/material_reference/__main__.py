"""The page docs/materials.md, made from the library of materials.

``python -m tools.material_reference > docs/materials.md`` writes it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from orchestrator.case.materials.library import Quantity, materials, pairs, shapes, sources
from orchestrator.case.tables.quantities import unit_of

HEAD = "| key | value | unit | range | source | note |\n| --- | --- | --- | --- | --- | --- |"


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
    yield "## Shapes\n"
    yield "| shape | grains | `rolling_friction` | range | source | note |"
    yield "| --- | --- | --- | --- | --- | --- |"
    for shape in shapes().values():
        each = shape.rolling_friction
        cells = [f"`{shape.name}`", shape.about, f"{each.value:g}", _range(each), each.source_id, each.note]
        yield f"| {' | '.join(cells)} |"
    yield ""


def _materials() -> Iterator[str]:
    """Yield a section for each material."""
    yield "## Materials\n"
    for material in materials().values():
        also = f" Also named {', '.join(material.also)}." if material.also else ""
        yield f"### {material.name}\n\n{material.about[0].upper()}{material.about[1:]}.{also}\n"
        if material.shape:
            yield f"Shape: `{material.shape}`.\n"
        yield HEAD
        yield from _rows(material.quantities.values())
        yield ""


def _contacts() -> Iterator[str]:
    """Yield a table of all contacts."""
    yield "## Contacts\n"
    yield "| materials | quantity | value | range | source | note |\n| --- | --- | --- | --- | --- | --- |"
    for pair in pairs().values():
        for each in pair.quantities.values():
            cells = [
                " – ".join(pair.between),
                f"`{each.key}`",
                f"{each.value:g}",
                _range(each),
                each.source_id,
                each.note,
            ]
            yield f"| {' | '.join(cells)} |"
    yield ""


def _sources() -> Iterator[str]:
    yield "## Sources\n"
    yield from (f"- **{name}**: {text}." for name, text in sources().items())


def _rows(quantities: Iterable[Quantity]) -> Iterator[str]:
    for each in quantities:
        unit = unit_of(each.key, "")
        cells = [f"`{each.key}`", f"{each.value:g}", unit, _range(each), each.source_id, each.note]
        yield f"| {' | '.join(cells)} |"


def _range(quantity: Quantity) -> str:
    return f"{quantity.low:g} to {quantity.high:g}"


if __name__ == "__main__":
    sys.stdout.write(material_reference())
