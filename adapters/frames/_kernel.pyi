"""What frames compute around their solver's steps, in C++ (``kernel/module.cpp``)."""

from __future__ import annotations

from typing import TypedDict

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array

Ints = npt.NDArray[np.int32]

class Books(TypedDict):
    """What bodies received from outside, lost and did: the entries of ``FramesLedger.add``."""

    outside_N_s: Array
    damping_J: float
    exciter_J: float
    reaction_J: float
    pushed_J: float

class SpatialBodies:
    """The bodies of ``exudyn/compiled.py``, on arrays of the state that Python owns."""

    def __init__(self, **arguments: Array | Ints) -> None:
        """Bind the constants, which are copied, and the arrays of the state.

        All arrays are contiguous, float64 or int32, and passed by name.  TypeError for another type
        and for a name that is missing or not known, ValueError, with the array's name, for a wrong
        size.
        """

    def start(self, *, coordinates: Array, rates: Array) -> None:
        """Take over the coordinates and rates (6 bodies,) at t = 0."""

    def wrench_of(self, *, force_N: Array, length_s: float) -> Array:
        """Return force and moment about the centres of mass (bodies, 6) of forces on the carried
        points (n, 3), with lever arms of the middle of the interval."""

    def apply(self, *, wrench: Array, acceleration: Array) -> None:
        """Take over a wrench (bodies, 6), and add its change over the mass to the accelerations
        (6 bodies,) of free bodies."""

    def coming_loads(self, *, end_s: float) -> tuple[Array, Array]:
        """Return the exciters' forces (exciters, 3) and the bodies' torques (bodies, 3) at the end of
        the coming step."""

    def reach(self, *, coordinates: Array, rates: Array) -> None:
        """Take over the coordinates and rates (6 bodies,) at the end of the step whose loads came last:
        the motion and the bushings' stretches, but not yet their forces."""

    def book(self, *, step_s: float) -> Books:
        """Compute the bushings' forces there, with ``element_N``, and return the books of the step."""

    def carry(self) -> tuple[Array, Array]:
        """Return position and velocity of the carried points, (n, 3) each."""

    def reaction(self, *, force_N: Array, before_m: Array, after_m: Array, length_s: float) -> Books:
        """Return the books of a reaction (n, 3) on the carried points, which moved meanwhile."""
