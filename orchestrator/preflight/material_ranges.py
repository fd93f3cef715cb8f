"""The ranges of restitution and rolling friction of a case's grains, and the case at their ends."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.materials.library import look_up, restitution_range, rolling_friction_range, slug
from orchestrator.case.tables.case import Contact
from orchestrator.preflight.judge import JudgedCase

Range = tuple[float, float]
KEYS = ("restitution", "rolling_friction")
ENDS = ("low", "high")


@dataclass(frozen=True)
class RangedContact:
    """A contact of grains with the ranges of its coefficients by key; what has none stays as it is given."""

    between: tuple[str, str]
    ranges: Mapping[str, Range]

    def at(self, ends: Mapping[str, int]) -> dict[str, Any]:
        """Return the row of ``contacts`` at some ends of the ranges: 0 the low one, 1 the high one."""
        return {"between": [*self.between]} | {key: values[ends[key]] for key, values in self.ranges.items()}


def ranged_contacts(judged: JudgedCase, own: Mapping[str, Range]) -> Iterator[RangedContact]:
    """Yield the contacts of grains; ``own`` ranges by key replace the library's of all of them.

    A restitution over speed counts as known.
    """
    case, grains = judged.case, set(smallest_grains(judged.case))
    for row in case.contacts:
        ranges = {key: own.get(key) or _library_range(judged, row, key) for key in KEYS}
        if row.rebound and "restitution" not in own:
            ranges["restitution"] = None
        if grains & set(row.between):
            known = {key: values for key, values in ranges.items() if values is not None}
            yield RangedContact(row.between, known)


def corner_sets(judged: JudgedCase, contacts: Sequence[RangedContact]) -> dict[str, str]:
    """Return the ``--set`` overlay of each corner of the ranges, by a name such as "low-restitution".

    All contacts are at their low or at their high ends together.
    """
    keys = [key for key in KEYS if any(key in each.ranges for each in contacts)]
    corners = {}
    for ends in product((0, 1), repeat=len(keys)):
        at = dict(zip(keys, ends, strict=True))
        name = "-".join(f"{ENDS[end]}-{key.replace('_', '-')}" for key, end in at.items())
        changed = [each.at(at) for each in contacts if each.ranges]
        corners[name] = f"contacts={_inline(_rows(judged, changed))}"
    return corners


def _library_range(judged: JudgedCase, row: Contact, key: str) -> Range | None:
    if key == "rolling_friction":
        return rolling_friction_range(*(judged.case.materials[name].shape for name in row.between))
    given = judged.layers.merged.get("materials", {})
    one, other = (look_up(str(given.get(name, {}).get("like", name))) for name in row.between)
    return None if one is None or other is None else restitution_range(one, other)


def _rows(judged: JudgedCase, changed: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the rows of ``contacts`` as the user gave them, with other coefficients, and added ones."""
    left = {frozenset(row["between"]): row for row in changed}
    rows = []
    for row in judged.layers.merged.get("contacts", []):
        names = frozenset(name if name in judged.case.materials else slug(name) for name in row["between"])
        rows.append({**row, **left.pop(names, {}), "between": row["between"]})
    return [*rows, *map(dict, left.values())]


def _inline(value: Any) -> str:
    """Return a value as TOML in one line."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_inline(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(_inline, value)) + "]"
    return json.dumps(value)
