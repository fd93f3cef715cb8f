"""A value of a knob, and values that belong together."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Setting:
    """``sets``: ``--set`` overlays, none for the case as it is; ``h``: what its error goes to zero
    with, in the unit of its family, None where it is no matter of degree."""

    label: str
    sets: tuple[str, ...] = ()
    h: float | None = None


@dataclass(frozen=True)
class Family:
    """Settings from coarse to fine that go to one answer.

    ``axis``: knobs that exclude each other share one, and one of all their settings is taken;
    ``length``: what ``h`` is; ``expected``: order in h that theory gives, None where there is none;
    ``rank``: on one axis the family of the highest is nearest to the truth; ``note``: what a reader
    must know.
    """

    knob: str
    axis: str
    variant: str
    settings: tuple[Setting, ...]
    length: str = ""
    expected: float | None = None
    rank: float = 0.0
    note: str = ""


class NotOffered(Exception):
    """A knob that this case has not; the message says why."""


def degrees(points: int) -> list[int]:
    """How often a value is halved, from coarse to fine, for ``points`` values: 0 is the case's own;
    3 gives -1, 0, 1."""
    coarser = (points - 1) // 2
    return list(range(-coarser, points - coarser))
