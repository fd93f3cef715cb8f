"""The gap springs of bushings with a piecewise linear characteristic.

Along such an axis a bushing is a linear spring with gap springs in parallel (``CharacteristicPlan``).  The
frames' own equations contain the linear spring; the gap springs are here.  In a step that stretches the axis
from e0 to e1, the force of a gap spring acts with its mean over the stretch,

    f = (V(e1) - V(e0)) / (e1 - e0),        V(e) = k max(side e - gap, 0)^2 / 2,

the discrete gradient of its energy (Gonzalez, Journal of Nonlinear Science 6, 1996, 449-467, doi
10.1007/BF02440162).  Its work is the change of V, wherever in the step the gap closes, so that the balance of
energy closes to rounding with steps of any length.  The motion has an error of second order in the step.

In a machine drawn at rest, each axis is stretched so far that its whole characteristic holds the preload.
The forces here count from there, as the preload itself is in the linear springs.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import CharacteristicPlan, FramesPlan
from orchestrator.ports.state import SavedAttributes

Gap = tuple[float, float, float]
"""Side, gap in m and stiffness in N/m of a gap spring."""


class GapSprings(SavedAttributes):
    """The gap springs of all bushings of a plan, with the stretch of all axes, (bushings, 3), at the last
    step's end.

    ``sag_m`` (bushings, 3) are the stretches at which the linear springs hold the preload.  Raises ValueError
    for a characteristic that cannot hold it.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_stretch_m",)

    def __init__(self, plan: FramesPlan, sag_m: Array) -> None:
        self._stretch_m = np.zeros((len(plan.bushings), 3))
        self._steepest_N_per_m = np.zeros_like(self._stretch_m)
        self._laws: list[list[tuple[int, list[Gap]]]] = []
        for number, bushing in enumerate(plan.bushings):
            self._laws.append([])
            for law in bushing.characteristics:
                gaps = [*zip(law.side.tolist(), law.gap_m.tolist(), law.gap_N_per_m.tolist(), strict=True)]
                held_m = _stretch_under(law, gaps, law.elastic_N_per_m * float(sag_m[number, law.axis]))
                if held_m is None:
                    raise ValueError(f"the characteristic of bushing {bushing.name} cannot hold its preload")
                self._stretch_m[number, law.axis] = held_m
                self._steepest_N_per_m[number, law.axis] = max(_steepest(gaps, side) for side in (1.0, -1.0))
                self._laws[number].append((law.axis, gaps))
        self._drawn_N = np.zeros_like(self._stretch_m)
        self._drawn_N = self.force_N

    def __bool__(self) -> bool:
        """Return whether there are gap springs at all."""
        return any(self._laws)

    @property
    def stiffness_N_per_m(self) -> Array:
        """What gap springs add at most to the stiffness along the axes of each bushing, (bushings, 3)."""
        return self._steepest_N_per_m

    @property
    def force_N(self) -> Array:
        """The force of the gap springs along the axes of each bushing, (bushings, 3)."""
        return self.mean_N(np.zeros_like(self._stretch_m))

    def mean_N(self, moved_m: Array) -> Array:
        """Return the mean force (bushings, 3) over a step in which the bushings' ends move apart by
        ``moved_m`` (bushings, 3) along their axes.  The call changes nothing."""
        return np.array([self.mean_of_one_N(*each) for each in enumerate(moved_m.tolist())]).reshape(-1, 3)

    def mean_of_one_N(self, bushing: int, moved_m: Sequence[float]) -> list[float]:
        """Return the mean force (3,) of one bushing, as ``mean_N``."""
        total_N = [0.0, 0.0, 0.0]
        for axis, gaps in self._laws[bushing]:
            start_m, drawn_N = self._stretch_m[bushing, axis], self._drawn_N[bushing, axis]
            total_N[axis] = _mean_N(gaps, float(start_m), moved_m[axis]) - float(drawn_N)
        return total_N

    def accept(self, moved_m: Array) -> None:
        """Go to the end of a step as in ``mean_N``."""
        self._stretch_m = self._stretch_m + moved_m

    def stored_J(self) -> float:
        """Return the energy in the gap springs, but for a constant, in J."""
        energy_J = -float(np.sum(self._drawn_N * self._stretch_m))
        for stretch_m, laws in zip(self._stretch_m.tolist(), self._laws, strict=True):
            for axis, gaps in laws:
                energy_J += sum(
                    k * _beyond_m(side, gap_m, stretch_m[axis]) ** 2 / 2 for side, gap_m, k in gaps
                )
        return energy_J


def _beyond_m(side: float, gap_m: float, stretch_m: float) -> float:
    return max(side * stretch_m - gap_m, 0.0)


def _mean_N(gaps: Sequence[Gap], start_m: float, moved_m: float) -> float:
    """Return the mean force of gap springs over the way from one stretch to another."""
    total_N = 0.0
    for side, gap_m, stiffness_N_per_m in gaps:
        before_m, after_m = (_beyond_m(side, gap_m, at_m) for at_m in (start_m, start_m + moved_m))
        if before_m > 0 < after_m or moved_m == 0:
            total_N += side * stiffness_N_per_m * (before_m + after_m) / 2
        else:  # the gap is open at one end of the way, or at both
            total_N += side * stiffness_N_per_m * (before_m + after_m) ** 2 / (2 * abs(moved_m))
    return total_N


def _steepest(gaps: Sequence[Gap], side: float) -> float:
    """Return the largest sum of stiffnesses of the gap springs that act together on a side, at least 0."""
    nearest_first = sorted(gap for gap in gaps if gap[0] == side)
    sums = np.cumsum([0.0, *(stiffness for _, _, stiffness in nearest_first)])
    return float(sums.max())


def _stretch_under(law: CharacteristicPlan, gaps: Sequence[Gap], force_N: float) -> float | None:
    """Return the stretch nearest to zero at which a characteristic has a force; None where it has it
    nowhere."""
    side = 1.0 if force_N >= 0 else -1.0
    left_N, stretch_m, slope_N_per_m = abs(force_N), 0.0, law.elastic_N_per_m
    for _, gap_m, stiffness_N_per_m in sorted(gap for gap in gaps if gap[0] == side):
        if left_N <= slope_N_per_m * (gap_m - stretch_m):
            break
        left_N -= slope_N_per_m * (gap_m - stretch_m)
        stretch_m, slope_N_per_m = gap_m, slope_N_per_m + stiffness_N_per_m
    if force_N == 0:
        return 0.0
    return side * (stretch_m + left_N / slope_N_per_m) if slope_N_per_m > 0 else None
