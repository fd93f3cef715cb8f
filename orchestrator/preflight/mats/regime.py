"""How a mat flips: its side and its blow in each turn, and the turns after which it repeats itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from orchestrator.ports import Array

Side = Literal["taut", "down", "up", "both"]
TAUT = 0.02  # height over the free length: less is the vibration of a mat that is hardly ever slack
ALIKE = 0.1  # of the motion's root mean square about its mean: turns that differ by less are alike
MOST_TURNS = 8  # after which a motion may be found to repeat itself
PHASES = 64  # of a turn, at which turns are compared


@dataclass(frozen=True)
class Regime:
    """The steady motion of a mat's middle over some turns of the machine.

    ``height_m`` (turns, phases) is its height over the line between the clamps' inner edges, towards the bed.
    ``peak_g`` and ``quoted_peak_g`` (turns,) are the largest accelerations of each turn, gravity not
    included, below 500 and below 100 Hz.
    """

    free_length_m: float
    height_m: Array
    peak_g: Array
    quoted_peak_g: Array

    @property
    def farthest_m(self) -> Array:
        """The height (turns,) in each turn that is farthest from the line between the clamps."""
        farthest = np.abs(self.height_m).argmax(axis=1)
        return np.asarray(self.height_m[np.arange(len(farthest)), farthest])

    @property
    def sides(self) -> Array:
        """The side (turns,) of each turn: -1 down, 1 up, 0 of a turn in which the mat stays taut."""
        taut = np.abs(self.farthest_m) < TAUT * self.free_length_m
        return np.where(taut, 0.0, np.sign(self.farthest_m))

    @property
    def turns(self) -> int:
        """The number of turns."""
        return len(self.peak_g)

    @property
    def turns_up(self) -> int:
        """The number of turns in which the mat arches up."""
        return int((self.sides > 0).sum())

    @property
    def side(self) -> Side:
        """The side of all turns."""
        ups, downs = (self.sides > 0).any(), (self.sides < 0).any()
        if ups and downs:
            return "both"
        return "up" if ups else "down" if downs else "taut"

    @property
    def repeats_after(self) -> int | None:
        """The number of turns after which the motion repeats itself; None above ``MOST_TURNS``."""
        return repeats_after(self.height_m)

    @property
    def mean_peak_g(self) -> float:
        """The mean of the turns' largest accelerations below 500 Hz."""
        return float(self.peak_g.mean())

    @property
    def mean_quoted_peak_g(self) -> float:
        """The mean of the turns' largest accelerations below 100 Hz."""
        return float(self.quoted_peak_g.mean())

    @property
    def in_words(self) -> str:
        """The regime in words."""
        turns = f"{self.turns} turns"
        ways = {
            "taut": "stays taut",
            "down": f"hangs down in all of {turns}",
            "up": f"arches up in all of {turns}",
            "both": f"arches up in {self.turns_up} of {turns}",
        }
        after = self.repeats_after
        alike = {None: "never repeats", 1: "repeats every turn"}.get(after, f"repeats every {after} turns")
        peaks = f"{self.mean_peak_g:.3g} g ({self.mean_quoted_peak_g:.3g} g below 100 Hz)"
        return f"{ways[self.side]}, {alike}, mean peak {peaks}"


def repeats_after(heights_m: Array) -> int | None:
    """Return the smallest number of turns after which rows of heights (turns, any number) are alike.

    Rows are alike within ``ALIKE`` of the root mean square of all heights about their mean.  The result is
    None above ``MOST_TURNS``, and if there are not twice as many turns.
    """
    size_m = float(np.std(heights_m))
    for turns in range(1, min(MOST_TURNS, len(heights_m) // 2) + 1):
        change_m = heights_m[turns:] - heights_m[:-turns]
        if float(np.sqrt(np.mean(change_m**2))) <= ALIKE * size_m:
            return turns
    return None
