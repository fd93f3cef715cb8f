"""The kinds of value in a case, and the base class of all its tables.

Numbers are strict: "4" and true are no numbers, but a whole number is a valid float.  Numbers with
units ("4 mm") have been converted before a table sees them (file/units.py).  The name of every float
ends in its unit; tests/case/test_tables.py checks this for all tables.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Annotated, Any, Self

from annotated_types import Ge, Gt, Le, Len, Lt
from pydantic import BaseModel, ConfigDict, Strict, StringConstraints


class Table(BaseModel):
    """A frozen table that refuses unknown keys, NaN and infinity.

    The text under each field documents it, and docs/case-format.md is generated from these texts
    (``tools/case_reference``).
    """

    model_config = ConfigDict(defer_build=True, extra="forbid", frozen=True, allow_inf_nan=False)

    def times(self, factor: float, *keys: str) -> Self:
        """Return a copy with the values of these keys multiplied; keys without a value stay without one."""
        return self.model_copy(update={key: _product(factor, getattr(self, key)) for key in keys})


def _product(factor: float, value: Any) -> Any:
    """Return the product of a factor and a number or a tuple of numbers; None for None."""
    if isinstance(value, tuple):
        return tuple(factor * number for number in value)
    return None if value is None else factor * value


Number = Annotated[float, Strict()]
Positive = Annotated[float, Strict(), Gt(0)]
NotNegative = Annotated[float, Strict(), Ge(0)]
Share = Annotated[float, Strict(), Ge(0), Le(1)]
Particles = Annotated[int, Strict(), Gt(0), Le(10_000_000)]  # One computer has memory for so many.
Few = Annotated[int, Strict(), Gt(0), Le(1000)]
Whole = Annotated[int, Strict(), Ge(0), Lt(2**63)]
Switch = Annotated[bool, Strict()]
Vector = tuple[Number, Number, Number]
NotNegativeVector = tuple[NotNegative, NotNegative, NotNegative]
Vectors = Annotated[tuple[Vector, ...], Len(1)]
Box = tuple[Vector, Vector]
Cells = tuple[Few, Few]
Name = Annotated[str, StringConstraints(pattern=r"^[A-Za-z0-9_-]{1,60}$")]
OneLine = Annotated[str, StringConstraints(pattern=r"^\P{C}*$", max_length=200)]
Text = Annotated[str, StringConstraints(pattern=r"^[\P{C}\t\r\n]*$", max_length=20_000)]

GROUND = "ground"


_UNIT = r"(?:m|mm|kg|s|min|h|N|J|W|Pa|Hz|rad|degC|deg|percent|g)\d?"
_END = re.compile(rf"(?:^|_)({_UNIT}(?:_{_UNIT})*)(?:_per_({_UNIT}(?:_{_UNIT})*))?$")
_WRITTEN = {"deg": "degree", "percent": "%", "g": "9.80665 m/s2"}


def unit_of(name: str, without: str = "1") -> str:
    """Return the unit of a name: m/s for ``velocity_m_per_s``, m3/(N m) for ``wear_m3_per_N_m``, 1/s for
    ``steps_per_s``.

    A name that ends in no unit belongs to a pure number and has the unit ``without``.
    """
    end = _END.search(name)
    if end is None:
        return without
    above, below = end.groups()
    if name[: end.start()].endswith("_per"):
        above, below = "", above
    unit = " ".join(_WRITTEN.get(part, part) for part in above.split("_")) or "1"
    if below is None:
        return unit
    return f"{unit}/({below.replace('_', ' ')})" if "_" in below else f"{unit}/{below}"


def same_unit(some: str, other: str) -> bool:
    """Tell whether two units are one, whatever their brackets, spaces and signs: kg·m2 and kg m^2."""
    return _plain_unit(some) == _plain_unit(other)


def _plain_unit(unit: str) -> str:
    for sign, written in {"°": "degree", "²": "2", "³": "3"}.items():
        unit = unit.replace(sign, written)
    words = re.findall(r"[a-zA-Z]+|[^\sa-zA-Z·*^()]", unit)
    return "".join(_WRITTEN.get(word, word) for word in words).replace(" ", "")


def unit_along(words: Sequence[str]) -> str:
    """Return the unit of a number by its keys, from the outermost in: of the last that has one, else 1."""
    units = (unit_of(word, "") for word in reversed(words))
    return next((unit for unit in units if unit), "1")
