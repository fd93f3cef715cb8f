"""Numbers with units, such as "750 rpm", which a case may give wherever a key ends in a unit.

They become numbers in the key's own unit when a table is read, so that no later step needs to know about
them.  A text that cannot be converted stays a text: the check of the tables refuses it, and ``why_refused``
says why.  units.txt has all units.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from decimal import Decimal
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from tokenize import TokenError
from typing import TYPE_CHECKING, Any

from orchestrator.case.file import hardness
from orchestrator.case.file.nested import leaves
from orchestrator.case.tables.quantities import unit_of

if TYPE_CHECKING:
    from pint import Unit, UnitRegistry

UNIT = r"[A-Za-zµμ°][A-Za-zµμ°0-9²³ ·*/^().-]{0,39}"
NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![eE][-+]?\d)"  # an exponent is no unit
NUMBER_AND_UNIT = re.compile(rf"\s*({NUMBER})\s*({UNIT}?)\s*")
NUMBER_ALONE = re.compile(rf"\s*({NUMBER})\s*")
OF_TURNS_OR_RADIANS = re.compile(rf"\s*{NUMBER}(?:\s+1)?\s*(?:/\s*(s|min)|(s|min)\s*(?:\^|\*\*)?\s*-\s*1)\s*")
DECIMAL_COMMA = re.compile(r"\s*[-+]?\d+,\d")
FRACTION = re.compile(rf"\s*(?:(\d{{1,6}})[ -])?(\d{{1,6}})\s*/\s*(\d{{1,6}})\s*({UNIT}?)\s*")
PERCENT = re.compile(rf"\s*({NUMBER})\s*%\s*")
OF_HARDNESS = "youngs_modulus_Pa"
KINDS = {
    "m": ("a length", "45 mm"),
    "s": ("a time", "50 ms"),
    "min": ("a time", "10 min"),
    "kg": ("a mass", "1.2 t"),
    "rad": ("an angle", "90 deg"),
    "degree": ("an angle", "20 deg"),
    "Hz": ("a frequency", "12 Hz"),
    "rad/s": ("an angular speed", "750 rpm"),
    "m/s": ("a speed", "300 mm/s"),
    "m/s2": ("an acceleration", "9.81 m/s2"),
    "kg/s": ("a mass rate", "50 t/h"),
    "kg/m3": ("a density", "1.4 t/m3"),
    "kg m": ("an unbalance, mass times radius", "3500 kg mm"),
    "kg m2": ("a moment of inertia", "2 kg m2"),
    "N": ("a force", "400 kN"),
    "N/m": ("a stiffness", "225 kN/m"),
    "N s/m": ("a damping, force over speed", "0.8 kN s/m"),
    "N m s": ("a torque over an angular speed", "0.5 N m s"),
    "Pa": ("a pressure or modulus", "10 MPa"),
    "Pa s": ("a viscosity", "0.0182 mPa s"),
    "Pa/m": ("a pressure over a length", "100 MPa/m"),
    "J/m2": ("an energy per area", "200 mJ/m2"),
    "m3/(N m)": ("a wear, volume over work", "1e-5 mm3/(N m)"),
    "W": ("a power", "15 kW"),
    "degC": ("a temperature in degrees Celsius", "45 degC"),
}
"""The kind of quantity that each unit of a key belongs to, with an example."""


def in_own_units(table: Mapping[str, Any], key: str = "") -> dict[str, Any]:
    """Return a table with every number that has a unit converted to the unit of its key.

    Elements of lists have the unit of the list's ``key``, also where an overlay gives them by their
    numbers.  Everything else stays as it is.
    """
    return {word: _converted(value, key if word.isdecimal() else word) for word, value in table.items()}


def keys_with_units(table: Mapping[str, Any]) -> Iterator[tuple[str, ...]]:
    """Yield the keys, as tuples of words, whose numbers a table gives as texts with units."""
    for key, value in leaves(table):
        words = tuple(map(str, key))
        name = next((word for word in reversed(words) if not word.isdecimal()), "")
        if isinstance(value, str) and not isinstance(_converted(value, name), str):
            yield words


def _converted(value: Any, key: str) -> Any:
    if isinstance(value, Mapping):
        return in_own_units(value, key)
    if isinstance(value, list):
        return [_converted(inner, key) for inner in value]
    if isinstance(value, str) and unit_of(key, ""):
        try:
            return parse_quantity(value, key)
        except ValueError:
            return value
    return value


def parse_quantity(text: str, key: str) -> float:
    """Return the number that a text such as "45 mm" denotes, in the unit of a key.

    "95 Shore A" denotes a Young's modulus.  Raises ValueError, whose message says why, for a text without
    number or unit, for an unknown unit, and for a unit of another kind than the key's.
    """
    if match := hardness.SHORE.fullmatch(text):
        if not key.endswith(OF_HARDNESS):
            raise ValueError(f"is a hardness, which only {OF_HARDNESS} takes; {_wanted(key)}")
        return hardness.youngs_modulus_Pa(float(match[1]), match[2].upper())
    if rate := OF_TURNS_OR_RADIANS.fullmatch(text):
        raise ValueError(_ambiguous(f"1/{rate[1] or rate[2]}", key))
    match = NUMBER_AND_UNIT.fullmatch(text)
    if match is None:
        raise ValueError(_no_unit(text, key))
    own = _unit(unit_of(key))
    try:
        number = Decimal(match[1])
    except ArithmeticError:
        raise ValueError("is not a number that can be computed with") from None
    try:
        given = _unit(match[2])
    except ValueError:
        raise ValueError(f'has the unknown unit "{match[2]}"; {_nearest(match[2], own)}') from None
    if given.dimensionality != own.dimensionality:
        kinds = (
            kind for unit, (kind, _) in KINDS.items() if _unit(unit).dimensionality == given.dimensionality
        )
        raise ValueError(f"is {next(kinds, 'of another kind')}; {_wanted(key)}")
    return float(_registry().Quantity(number, given).to(own).magnitude)


def is_unit(text: str) -> bool:
    """Return whether a text denotes a unit."""
    try:
        return bool(re.fullmatch(UNIT, text)) and _unit(text) is not None
    except ValueError:
        return False


def split_quantity(text: str) -> tuple[str, str]:
    """Return the number and the unit of a text such as "45 mm"; the whole text and "" if it has no unit."""
    match = NUMBER_AND_UNIT.fullmatch(text)
    return (match[1], match[2]) if match else (text.strip(), "")


def why_refused(text: str, path: tuple[str | int, ...]) -> str:
    """Return why a text is no value of the key at the end of a path; "" if it is for another reason."""
    names = [part for part in path if isinstance(part, str) and not part.isdecimal()]
    if not names or not unit_of(names[-1], ""):
        percent = PERCENT.fullmatch(text)
        return f"is in per cent; write {float(percent[1]) / 100:.9g}" if percent else ""
    try:
        parse_quantity(text, names[-1])
    except ValueError as error:
        return str(error)
    return ""


def _ambiguous(unit: str, key: str) -> str:
    """Return a message about a number per time, such as "1/s", which may count turns or radians."""
    if unit_of(key) not in ("rad/s", "Hz"):
        return f"is a number per time; {_wanted(key)}"
    return f"is ambiguous: {unit} may count turns or radians; give rpm, Hz or rad/s"


def _no_unit(text: str, key: str) -> str:
    """Return a message about a text that has no unit; "" if it is no number either."""
    if DECIMAL_COMMA.match(text):
        return "has a decimal comma; write a point"
    if (parts := FRACTION.fullmatch(text)) and int(parts[3]):
        number = int(parts[1] or 0) + int(parts[2]) / int(parts[3])
        return f"is a fraction; write '{number:.9g} {parts[4]}'"
    alone, own = NUMBER_ALONE.fullmatch(text), unit_of(key)
    if alone is None or own not in KINDS:
        return ""
    meant = f"{alone[1]} {split_quantity(KINDS[own][1])[1]}"
    return f"has no unit; is '{meant}' meant? A number without quotation marks is in {own}"


def _wanted(key: str) -> str:
    """Return a message about the kind of quantity that a key wants."""
    own = unit_of(key)
    if own not in KINDS:  # that of a key which no table has
        return f"give it in {own}"
    kind, example = KINDS[own]
    return f'give {kind}, such as "{example}"'


def _nearest(text: str, own: Unit) -> str:
    same_kind = [word for word in USUAL if _unit(word).dimensionality == own.dimensionality]
    if near := get_close_matches(text, same_kind, n=1):
        return f'did you mean "{near[0]}"?'
    return f"for example {', '.join(same_kind or USUAL)}"


NO_UNIT = (
    *(ValueError, TypeError, SyntaxError, AttributeError, ArithmeticError),
    *(LookupError, AssertionError, RecursionError, TokenError),
)
"""What pint raises, beside its own errors, for a text such as "s^0" or "s/"."""


@cache
def _unit(text: str) -> Unit:
    """Return the unit that a text denotes, with powers as in "kg/m3" or "kg/m^3".

    Raises ValueError for a text that denotes none.
    """
    from pint import PintError

    powers = re.sub(r"(?<=[A-Za-zµμ°])(?=\d)", "**", text.replace("·", " "))
    try:
        return _registry().parse_units(powers)
    except (PintError, *NO_UNIT):
        raise ValueError(f'no unit "{text}"') from None


USUAL = (
    *("m", "mm", "cm", "um", "in", "ft", "kg", "g", "t", "lb", "s", "ms", "us", "min", "h", "rad", "deg"),
    *("rad/s", "rpm", "Hz", "m/s", "mm/s", "kg/s", "t/h", "kg/h", "kg/m3", "t/m3", "N/m", "N/mm", "kN/m"),
    *("N", "kN"),
    *("Pa", "kPa", "MPa", "GPa", "bar", "psi", "J/m2", "mJ/m2", "W", "kW", "kg m", "kg mm", "kg m2"),
)
"""The units that messages propose."""


@cache
def _registry() -> UnitRegistry[Any]:
    """Return the registry of all units, which converts in decimals: "10 us" is 1e-5 s without rounding.

    pint is imported only here and in ``_unit``, when a case has a number with a unit.
    """
    from pint import UnitRegistry

    registry = UnitRegistry(None, non_int_type=Decimal)
    registry.load_definitions(Path(__file__).with_name("units.txt"))
    return registry
