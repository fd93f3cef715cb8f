"""The friction and Maxwell elements of bushings with measured curves.

Such a bushing is a linear spring with elements in parallel along its axis (Iwan, Journal of Applied Mechanics
33, 1966, 893-900, doi 10.1115/1.3625199, has friction elements; Berg, Vehicle System Dynamics 30, 1998,
197-212, doi 10.1076/vesd.30.3.197.8, adds friction to viscous elements for rubber springs).  The frames' own
equations contain the springs; the elements are here.  In a step of length h that stretches an element by d,
its force goes from f0 to

    f1 = (f0 (1 - h / 2T) + k d) / (1 + h / 2T)

with its relaxation time T, which is infinite for friction, and no farther than the force at which the
element slips.  The mean (f0 + f1) / 2 acts in the step.  It does the work (f0 + f1) d / 2, of which
(f1^2 - f0^2) / 2k is stored and the rest is lost.  The loss is never negative: it is the mean force times the
slip, or times the way of the damper.  So the balance of energy closes to rounding with steps of any length.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import FramesPlan
from orchestrator.ports.state import SavedAttributes


class Hysteresis(SavedAttributes):
    """The n elements of all bushings of a plan, with their forces at the last step's end, (n,)."""

    STATE: ClassVar[tuple[str, ...]] = ("_force_N",)

    def __init__(self, plan: FramesPlan) -> None:
        rows = [
            (number, law.axis, float(stiffness), float(limit), float(rate))
            for number, bushing in enumerate(plan.bushings)
            for law in bushing.hysteresis
            for stiffness, limit, rate in [
                *zip(law.friction_N_per_m, law.friction_N_per_m * law.slip_m, 0.0 * law.slip_m, strict=True),
                *zip(law.maxwell_N_per_m, np.inf + law.relaxation_s, 1 / law.relaxation_s, strict=True),
            ]
        ]
        table = np.array(rows, dtype=np.float64).reshape(-1, 5).T
        self._bushing, self._axis = table[:2].astype(np.int64)
        self._stiffness_N_per_m, self._limit_N, self._rate_per_s = table[2:]
        self._rows: list[list[tuple[int, int, float, float, float]]] = [[] for _ in plan.bushings]
        for element, (number, axis, stiffness, limit, rate) in enumerate(rows):
            self._rows[number].append((element, axis, stiffness, limit, rate))
        self._shape = (len(plan.bushings), 3)
        self._force_N: Array = np.zeros(len(self._stiffness_N_per_m))

    def __bool__(self) -> bool:
        """Return whether there are elements at all."""
        return len(self._force_N) > 0

    @property
    def stiffness_N_per_m(self) -> Array:
        """The sum of the elements' stiffnesses along the axes of each bushing, (bushings, 3)."""
        return self._along_axes(self._stiffness_N_per_m)

    @property
    def shortest_s(self) -> float:
        """The shortest relaxation time, infinite without Maxwell elements."""
        return 1 / max(float(self._rate_per_s.max(initial=0.0)), 1e-300)

    @property
    def force_N(self) -> Array:
        """The elements' force along the axes of each bushing, (bushings, 3)."""
        return self._along_axes(self._force_N)

    def force_of_one_after_N(self, bushing: int, moved_m: Sequence[float], step_s: float) -> list[float]:
        """Return the elements' force (3,) of one bushing after a step in which its ends moved apart by
        ``moved_m`` (3,) along its axes.  The call changes nothing.  For a few elements, plain numbers are
        faster than arrays."""
        total_N = [0.0, 0.0, 0.0]
        for number, axis, stiffness_N_per_m, limit_N, rate_per_s in self._rows[bushing]:
            half = step_s / 2 * rate_per_s
            force_N = self._force_N[number] * (1 - half) + stiffness_N_per_m * moved_m[axis]
            total_N[axis] += min(max(force_N / (1 + half), -limit_N), limit_N)
        return total_N

    def mean_N(self, moved_m: Array, step_s: float) -> Array:
        """Return the mean force (bushings, 3) over a step in which the bushings' ends moved apart by
        ``moved_m`` (bushings, 3) along their axes: the mean of those at its ends.  The call changes
        nothing."""
        return self._along_axes((self._force_N + self._after(moved_m, step_s)) / 2)

    def accept(self, moved_m: Array, step_s: float) -> float:
        """Go to the end of a step as in ``mean_N``, and return the energy lost in it in J."""
        before, after = self._force_N, self._after(moved_m, step_s)
        work_J = (before + after) / 2 @ moved_m[self._bushing, self._axis]
        stored_J = np.sum((after**2 - before**2) / (2 * self._stiffness_N_per_m))
        self._force_N = after
        return float(work_J - stored_J)

    def stored_J(self) -> float:
        """Return the energy in the elements' springs in J."""
        return float(np.sum(self._force_N**2 / (2 * self._stiffness_N_per_m)))

    def _after(self, moved_m: Array, step_s: float) -> Array:
        half = step_s / 2 * self._rate_per_s
        stretched_N = self._stiffness_N_per_m * moved_m[self._bushing, self._axis]
        force_N = (self._force_N * (1 - half) + stretched_N) / (1 + half)
        return np.asarray(np.minimum(np.maximum(force_N, -self._limit_N), self._limit_N))

    def _along_axes(self, of_element: Array) -> Array:
        """Return the sums (bushings, 3) of one number per element."""
        total = np.zeros(self._shape)
        np.add.at(total, (self._bushing, self._axis), of_element)
        return total
