"""The kinds of value that a case is made of, and the table that every table of a case is.

Numbers are strict: "4" or true is no number, a whole number is one.  Every float carries its
unit at the end of its name; tests/case/test_tables.py walks all tables to make sure.
"""

from __future__ import annotations

import re
from typing import Annotated, Any, Self

from annotated_types import Ge, Gt, Le, Len, Lt
from pydantic import BaseModel, ConfigDict, Strict, StringConstraints


class Table(BaseModel):
    """A frozen table: unknown keys, NaN and infinity are refused.

    The text under each field is its documentation (docs/case-format.md is made of it).
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, use_attribute_docstrings=True)

    def times(self, factor: float, *keys: str) -> Self:
        """A copy with the numbers of these keys multiplied; keys without a value stay without."""
        return self.model_copy(update={key: _product(factor, getattr(self, key)) for key in keys})


def _product(factor: float, value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(factor * number for number in value)
    return None if value is None else factor * value


Number = Annotated[float, Strict()]
Positive = Annotated[float, Strict(), Gt(0)]
NotNegative = Annotated[float, Strict(), Ge(0)]
Share = Annotated[float, Strict(), Ge(0), Le(1)]
Particles = Annotated[int, Strict(), Gt(0), Le(10_000_000)]  # what one machine can hold
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


_UNIT = r"(?:m|mm|kg|s|min|h|N|J|W|Pa|Hz|rad|deg|percent|g)\d?"
_END = re.compile(rf"(?:^|_)({_UNIT}(?:_{_UNIT})*)(?:_per_({_UNIT}(?:_{_UNIT})*))?$")
_WRITTEN = {"deg": "degree", "percent": "%", "g": "9.80665 m/s2"}


def unit_of(name: str, without: str = "1") -> str:
    """The unit of a name: ``velocity_m_per_s`` has m/s, ``wear_m3_per_N_m`` m3/(N m).

    A name that ends in no unit belongs to a pure number and has the unit ``without``.
    """
    end = _END.search(name)
    if end is None:
        return without
    above, below = end.groups()
    unit = " ".join(_WRITTEN.get(part, part) for part in above.split("_"))
    if below is None:
        return unit
    return f"{unit}/({below.replace('_', ' ')})" if "_" in below else f"{unit}/{below}"
