"""The answers of ``flipflow materials``: the library of materials as lines of text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rich.table import Table

from orchestrator.case.bed.work_of_adhesion import BASES, MOISTURES_J_PER_M2, UNSURE
from orchestrator.case.materials.library import (
    LibraryMaterial,
    NamedMaterial,
    Quantity,
    UnknownMaterial,
    find,
    materials,
    pairs,
    shapes,
    suggest,
)
from orchestrator.case.tables.case import WORK_OF_ADHESION
from orchestrator.case.tables.quantities import unit_of
from orchestrator.cli.console import refuse

ELASTOMER = "name it with a hardness, for example {0} 85 Shore A"
SOFTENED = (
    "Moduli are those of the real material. particles.largest_youngs_modulus_Pa softens contacts for "
    "longer steps."
)


def find_or_refuse(name: str) -> NamedMaterial:
    """Return the material of this name; end the program with a hint if there is none.

    An elastomer may be named without its hardness, because its quantities do not depend on it.
    """
    try:
        return find(name)
    except UnknownMaterial:
        if name.strip().lower() in materials():
            return NamedMaterial(materials()[name.strip().lower()])
        refuse(f'no material "{name}" in the library; {suggest(name)}')


def list_form() -> dict[str, Any]:
    """Return the list of all materials for JSON."""
    rows = [{"name": row.name, "kind": row.kind, "about": row.about} for row in materials().values()]
    return {"materials": rows}


def list_lines() -> Iterator[str]:
    """Yield a line for each material of the library, and lines about its use."""
    width = max(map(len, materials()))
    for row in materials().values():
        yield f"{row.name:{width}}  {row.about}"
    yield ""
    yield 'Grains may be dry, moist, wet or sticky: material = "moist limestone".'
    for shape in shapes().values():
        friction = _in_words(shape.rolling_friction)
        yield f"Grains may be {shape.name} ({shape.about}): rolling friction {friction}."
    yield 'Elastomers have a hardness: material = "polyurethane 85 Shore A".'
    yield "flipflow materials limestone has its numbers, with ranges and sources."


def material_form(named: NamedMaterial) -> dict[str, Any]:
    """Return everything about a material for JSON; ``case`` has the keys of its table in a case."""
    material = named.material
    is_complete = material.kind != "elastomer" or named.hardness is not None
    return {
        "material": material.name,
        "about": material.about,
        "kind": material.kind,
        "shape": shape_form(material),
        "moisture": named.moisture or None,
        "adhesion": _as_row(adhesion) if (adhesion := adhesion_of(named.moisture)) else None,
        "hardness": f"{named.hardness[0]:g} Shore {named.hardness[1]}" if named.hardness else None,
        "case": named.keys() if is_complete else None,
        "quantities": [_as_row(quantity) for quantity in material.quantities.values()],
        "contacts": [
            {"with": other, "quantities": [_as_row(quantity) for quantity in rows]}
            for other, rows in contacts_of(material)
        ],
    }


def shape_form(material: LibraryMaterial) -> dict[str, Any] | None:
    """Return the shape class of grains for JSON; None for other materials."""
    if not material.shape:
        return None
    shape = shapes()[material.shape]
    return {"name": shape.name, "about": shape.about, "quantities": [_as_row(shape.rolling_friction)]}


def explanation(named: NamedMaterial) -> Iterator[str | Table]:
    """Yield the lines and tables that explain a material."""
    material = named.material
    yield f"{material.name}: {material.about}" + (
        f" (also {', '.join(material.also)})" if material.also else ""
    )
    yield _table("quantity", [("", quantity) for quantity in material.quantities.values()])
    if material.kind == "elastomer" and named.hardness is None:
        yield ELASTOMER.format(material.name)
    elif named.hardness is not None:
        law = named.keys()["hyperelastic"]
        yield "in a case: " + ", ".join(f"{key} = {law[key]:.4g}" for key in law if key != "loss_curve")
    if adhesion := adhesion_of(named.moisture):
        limits = f"range {adhesion.low:.3g} to {adhesion.high:.3g}"
        yield (
            f"{named.moisture}: all its contacts have a work of adhesion of {adhesion.value:.3g} J/m2 "
            f"({limits}; {adhesion.note}; {adhesion.source})"
        )
    if material.shape:
        shape = shapes()[material.shape]
        friction = shape.rolling_friction
        yield (
            f"shape: {shape.name} ({shape.about}), which gives all its contacts a rolling friction of "
            f"{_in_words(friction)} ({friction.note}; {friction.source}); another shape, or a contact's own "
            "rolling_friction, replaces it"
        )
    if rows := [(f"with {other}", each) for other, every in contacts_of(material) for each in every]:
        yield _table("contact", rows)
    yield SOFTENED


def adhesion_of(moisture: str) -> Quantity | None:
    """Return the work of adhesion that a class of moisture stands for; None for ""."""
    if not moisture:
        return None
    value, (source, note) = MOISTURES_J_PER_M2[moisture], BASES[moisture]
    return Quantity(WORK_OF_ADHESION, value, value / UNSURE, value * UNSURE, source, "", note)


def contacts_of(material: LibraryMaterial) -> Iterator[tuple[str, tuple[Quantity, ...]]]:
    """Yield the other material and the coefficients of each contact of a material in the library."""
    for pair in pairs().values():
        if material.name in pair.between:
            one, two = pair.between
            yield two if one == material.name else one, tuple(pair.quantities.values())


def _as_row(quantity: Quantity) -> dict[str, Any]:
    return {
        "key": quantity.key,
        "value": quantity.value,
        "unit": unit_of(quantity.key),
        "range": [quantity.low, quantity.high],
        "source": quantity.source,
        "note": quantity.note,
    }


def _in_words(quantity: Quantity) -> str:
    return f"{quantity.value:g} (range {quantity.low:g} to {quantity.high:g})"


def _table(of: str, rows: list[tuple[str, Quantity]]) -> Table:
    """Return a table of quantities; ``rows`` have a word that comes before the key."""
    table = Table(of, "value", "unit", "range", "source, note")
    for word, each in rows:
        why = f"{each.source}; {each.note}" if each.note else each.source
        limits = f"{each.low:g} to {each.high:g}"
        table.add_row(f"{word} {each.key}".strip(), f"{each.value:g}", unit_of(each.key, ""), limits, why)
    return table
