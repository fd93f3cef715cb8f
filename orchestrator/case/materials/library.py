"""The library of materials: named materials and their contacts, each number with its range and its source.

library.toml has the numbers.  A name may say more than the library's own name: "moist limestone" has a
class of moisture, and "polyurethane 85 Shore A" a hardness.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Literal

from orchestrator.case.file.errors import did_you_mean
from orchestrator.case.file.hardness import RANGES, youngs_modulus_Pa

FILE = Path(__file__).with_name("library.toml")
Kind = Literal["grains", "surface", "elastomer"]
MOISTURES = ("dry", "moist", "wet", "sticky")  # from the driest to the stickiest
NAME = re.compile(r"(?:(dry|moist|wet|sticky) )?(.+?)(?: (\d+(?:\.\d+)?) ?shore ?([ad]))?")
COEFFICIENTS = ("restitution", "sliding_friction")
SIZE_EXPONENT = "size_exponent"
"""The quantity of grains that describes a typical feed (``typical_feed.py``), and no key of a case."""
LOSS_FROM_HZ, LOSS_TO_HZ = 5.0, 500.0
"""The frequencies between which an elastomer's loss factor is taken as constant."""


class UnknownMaterial(ValueError):
    """An error for a name that the library does not have.

    The message says what is wrong with it; it is empty if no material of the library is meant.
    """


@dataclass(frozen=True)
class Quantity:
    """A number of the library with its ordinary range, its source, and a note.

    ``source_id`` is the short name of the source.
    """

    key: str
    value: float
    low: float
    high: float
    source: str
    source_id: str
    note: str = ""


@dataclass(frozen=True)
class LibraryMaterial:
    """A material of the library, with all its quantities by key.

    ``shape`` is the usual shape class of grains, and "" of all other materials.  ``also`` are its other
    names.
    """

    name: str
    about: str
    kind: Kind
    quantities: Mapping[str, Quantity]
    shape: str = ""
    also: tuple[str, ...] = ()


@dataclass(frozen=True)
class Shape:
    """A shape class of grains, with the rolling friction of spheres that stand for them."""

    name: str
    about: str
    rolling_friction: Quantity


@dataclass(frozen=True)
class LibraryPair:
    """The contact of two materials of the library, with its coefficients by key."""

    between: tuple[str, str]
    quantities: Mapping[str, Quantity]


@dataclass(frozen=True)
class NamedMaterial:
    """A material as a case names it: a material of the library, its moisture and its hardness.

    ``moisture`` is "" if the name does not say it.  Only elastomers have a hardness, such as (85, "A").
    """

    material: LibraryMaterial
    moisture: str = ""
    hardness: tuple[float, str] | None = None

    def keys(self) -> dict[str, Any]:
        """Return the keys of the material's table in a case."""
        values = {
            key: quantity.value for key, quantity in self.material.quantities.items() if key != SIZE_EXPONENT
        }
        if self.hardness is None:
            return values | ({"shape": self.material.shape} if self.material.shape else {})
        modulus_Pa = values["modulus_over_that_of_hardness"] * youngs_modulus_Pa(*self.hardness)
        c10_Pa = modulus_Pa / 6 / (1 + values["c01_over_c10"])
        curve = [
            {"frequency_Hz": f, "loss_factor": values["loss_factor"]} for f in (LOSS_FROM_HZ, LOSS_TO_HZ)
        ]
        return {
            "density_kg_per_m3": values["density_kg_per_m3"],
            "hyperelastic": {
                "c10_Pa": c10_Pa,
                "c01_Pa": values["c01_over_c10"] * c10_Pa,
                "bulk_modulus_Pa": values["bulk_modulus_Pa"],
                "loss_curve": curve,
            },
        }


@cache
def materials() -> dict[str, LibraryMaterial]:
    """Return all materials of the library by name."""
    return {
        name: LibraryMaterial(
            name,
            row["about"],
            row["kind"],
            _quantities(row),
            row.get("shape", ""),
            tuple(row.get("also", ())),
        )
        for name, row in _table()["materials"].items()
    }


@cache
def shapes() -> dict[str, Shape]:
    """Return all shape classes by name, from the roundest."""
    return {
        name: Shape(name, row["about"], _quantities(row)["rolling_friction"])
        for name, row in _table()["shapes"].items()
    }


def rolling_friction_of(one: str | None, other: str | None) -> float | None:
    """Return the rolling friction of the contact of two materials of these shape classes.

    A material without a shape, such as that of a panel, has none of its own.  Two grains have the mean of
    both classes, which is an assumption.  Return None where neither has a shape.
    """
    given = [shapes()[shape].rolling_friction.value for shape in (one, other) if shape is not None]
    return sum(given) / len(given) if given else None


def rolling_friction_range(one: str | None, other: str | None) -> tuple[float, float] | None:
    """Return the range of the rolling friction of two materials of these shape classes; None without one.

    Two grains have the means of both classes' ends.
    """
    given = [shapes()[shape].rolling_friction for shape in (one, other) if shape is not None]
    return _mean_range(given)


def restitution_range(one: NamedMaterial, other: NamedMaterial) -> tuple[float, float] | None:
    """Return the range of the restitution of two materials; None if the library does not have the pair.

    Two different grains have the means of the ends of their own pairs.
    """
    names = [(one.material.name, other.material.name)]
    if frozenset(names[0]) not in pairs() and one.material.kind == other.material.kind == "grains":
        names = [(name, name) for name in names[0]]
    found = [
        pairs()[frozenset(pair)].quantities["restitution"] for pair in names if frozenset(pair) in pairs()
    ]
    return _mean_range(found)


def _mean_range(given: Sequence[Quantity]) -> tuple[float, float] | None:
    if not given:
        return None
    return sum(each.low for each in given) / len(given), sum(each.high for each in given) / len(given)


@cache
def pairs() -> dict[frozenset[str], LibraryPair]:
    """Return all pairs of the library by their two materials."""
    rows = [LibraryPair(tuple(row["between"]), _quantities(row)) for row in _table()["pairs"]]
    return {frozenset(row.between): row for row in rows}


def sources() -> dict[str, str]:
    """Return the full names of all sources by their short names."""
    return dict(_table()["sources"])


def find(name: str) -> NamedMaterial:
    """Return the material that a name denotes.  Raises UnknownMaterial."""
    match = NAME.fullmatch(re.sub(r"[\s_-]+", " ", name.strip()).lower())
    moisture, base, number, scale = match.groups("") if match else ("", "", "", "")
    material = next((row for row in materials().values() if base in (row.name, *row.also)), None)
    if material is None:
        if elastomer := _named_with_another_hardness(base or ""):
            what = "give a hardness in Shore A or D"
            raise UnknownMaterial(f'{what}, for example "{elastomer} 85 Shore A"')
        raise UnknownMaterial
    if moisture and material.kind != "grains":
        raise UnknownMaterial(f"only grains are {moisture}, and {base} is not a grain")
    if material.kind == "elastomer":
        if not number:
            raise UnknownMaterial(f'give its hardness, for example "{base} 85 Shore A"')
        hardness = (float(number), scale.upper())
        low, high = RANGES[hardness[1]]
        if not low <= hardness[0] <= high:
            raise UnknownMaterial(f"its hardness must be from {low:g} to {high:g} Shore {hardness[1]}")
        return NamedMaterial(material, hardness=hardness)
    if number:
        raise UnknownMaterial(f'only elastomers are named with a hardness; the material is "{base}"')
    return NamedMaterial(material, moisture)


def _named_with_another_hardness(base: str) -> str:
    """Return the elastomer that a name such as "rubber 60 shore b" begins with; "" if it begins with none."""
    names = [row.name for row in materials().values() if row.kind == "elastomer"]
    return next((name for name in names if re.match(rf"{re.escape(name)} \d", base)), "")


def look_up(name: str) -> NamedMaterial | None:
    """Return the material that a name denotes; None if the library does not have it."""
    try:
        return find(name)
    except UnknownMaterial:
        return None


def no_grains(name: str) -> str | None:
    """Return the library's own name of a material that is no grains; None for grains and unknown names."""
    named = look_up(name)
    return None if named is None or named.material.kind == "grains" else named.material.name


def suggest(name: str, others: Iterable[str] = ()) -> str:
    """Return a hint at what an unknown name may mean, among the library's and other names."""
    try:
        find(name)
    except UnknownMaterial as error:
        return str(error) or did_you_mean(name, {*others, *materials()}, say="materials")
    return ""


def slug(name: str) -> str:
    """Return the name of a material as a key of a case's table: polyurethane-85-Shore-A."""
    return re.sub(r"[^A-Za-z0-9]+", "-", name.strip()).strip("-")[:60]


def contact_keys(one: NamedMaterial, other: NamedMaterial) -> dict[str, Any]:
    """Return the keys of the contact of two materials; none if the library does not have the pair.

    Two different grains have the means of the coefficients of their own pairs, which is an assumption.
    The wetter material determines the moisture of the contact.
    """
    coefficients = _coefficients(one.material, other.material)
    wetter = max(one.moisture, other.moisture, key=("", *MOISTURES).index)
    return {**coefficients, "moisture": wetter} if coefficients and wetter else coefficients


def _coefficients(one: LibraryMaterial, other: LibraryMaterial) -> dict[str, float]:
    """Return restitution and friction of two materials; none if the library does not have them."""
    if pair := pairs().get(frozenset((one.name, other.name))):
        return {key: quantity.value for key, quantity in pair.quantities.items()}
    if one.kind == other.kind == "grains":
        own = [_coefficients(material, material) for material in (one, other)]
        return {key: sum(row[key] for row in own) / 2 for key in COEFFICIENTS}
    return {}


def _quantities(row: Mapping[str, Any]) -> dict[str, Quantity]:
    return {key: _quantity(key, **each) for key, each in row.items() if isinstance(each, Mapping)}


def _quantity(key: str, value: float, range: tuple[float, float], source: str, note: str = "") -> Quantity:
    low, high = range
    return Quantity(key, value, low, high, sources()[source], source, note)


@cache
def _table() -> dict[str, Any]:
    return tomllib.loads(FILE.read_text(encoding="utf-8"))
