"""The values of a sweep: a key of the case and what to give it."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from orchestrator.case.file.errors import CaseError, CaseProblem

MOST = 1000


@dataclass(frozen=True)
class Vary:
    """``key`` (dotted, as ``--set`` takes it) and its ``values`` as text."""

    key: str
    values: tuple[str, ...]

    @property
    def name(self) -> str:
        """The key's last word, which has the unit."""
        return self.key.rpartition(".")[2]

    def folder(self, value: str) -> str:
        """A name for the point's folder."""
        plain = "".join(c if c.isalnum() or c in "+-._" else "_" for c in value)
        return f"{self.name}-{plain}"


def parsed(text: str) -> Vary:
    """'key=a,b,c' or 'key=first:last:step', both ends included.  Raises CaseError."""
    key, equals, values = text.partition("=")
    if not equals or not key.strip() or not values.strip():
        raise _wrong(text, "is not key=values")
    if values.count(":") == 2:
        found = _range(text, values)
    else:
        found = tuple(value.strip() for value in _apart(values))
    if len(set(found)) < len(found) or not all(found):
        raise _wrong(text, "has an empty value or one twice")
    return Vary(key.strip(), found)


def _range(text: str, values: str) -> tuple[str, ...]:
    """In exact fractions: 0.1:0.3:0.1 has three values."""
    try:
        first, last, step = (Fraction(part.strip()) for part in values.split(":"))
    except (ValueError, ZeroDivisionError):
        raise _wrong(text, "is no range of numbers") from None
    if step == 0 or (last - first) / step < 0 or (last - first) / step > MOST:
        raise _wrong(text, f"is no range of 1 to {MOST} values")
    count = int((last - first) / step) + 1
    return tuple(repr(float(first + number * step)) for number in range(count))


def _apart(values: str) -> list[str]:
    """At commas outside brackets."""
    parts, depth = [""], 0
    for letter in values:
        depth += (letter in "[{") - (letter in "]}")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _wrong(text: str, what: str) -> CaseError:
    hint = "for example --vary screen.exciters.shaft.speed_rad_per_s=58:110:4"
    return CaseError([CaseProblem((), what, hint, f"--vary {text}")])
