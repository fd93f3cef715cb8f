"""Forces on bodies at an instant, for the books of a trapezoidal step between two instants.

Newmark's step with beta = 1/4, gamma = 1/2 is  m (v1 - v0) = h/2 (f0 + f1)  and
x1 - x0 = h/2 (v0 + v1): so the mean of the forces at its two ends gives its impulse to rounding,
and mean force times displacement gives its work exactly where the equations are linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.exciter import Unbalance
from adapters.frames.common.poses import Attached, Poses, cross, turned
from orchestrator.ports import Array
from orchestrator.ports.plans import FramesPlan


@dataclass(frozen=True)
class Instant:
    """``stretch_m``, ``stretch_m_per_s`` (bushings, 3) along the spring axes; ``pull_N`` (bushings, 3)
    on the first body at ``from_m``, and its opposite on the second at ``to_m``; ``couple_N_m``
    (bodies, 3) what a stretched bushing adds to its first body; ``exciter_N``, ``exciter_m``
    (exciters, 3) force and place."""

    poses: Poses
    stretch_m: Array
    stretch_m_per_s: Array
    pull_N: Array
    from_m: Array
    to_m: Array
    couple_N_m: Array
    exciter_N: Array
    exciter_m: Array


class Forces:
    """Evaluates bushings and exciters, ``sag_m`` (bushings, 3) as in ``multibody.assembled``.

    ``bodies``: the numbers (bushings,) of the bushings' first and of their second bodies."""

    def __init__(self, plan: FramesPlan, drawn_m: Array, sag_m: Array) -> None:
        place_m = np.array([b.position_m for b in plan.bushings]).reshape(-1, 3)
        first, second = (linear.numbers(plan, tuple(b.bodies[end] for b in plan.bushings)) for end in (0, 1))
        self.bodies = first, second
        self._ends = Attached.at(place_m, first, drawn_m), Attached.at(place_m, second, drawn_m)
        self._axes = np.array([b.axes for b in plan.bushings]).reshape(-1, 3, 3)
        self._sag_m = sag_m
        self.stiffness_N_per_m = np.array([b.stiffness_N_per_m for b in plan.bushings]).reshape(-1, 3)
        self.damping_N_s_per_m = np.array([b.damping_N_s_per_m for b in plan.bushings]).reshape(-1, 3)
        self._onto_first = linear.onto_bodies(plan, first)
        self._exciters = [Unbalance(exciter) for exciter in plan.exciters]
        excited = linear.numbers(plan, tuple(e.body for e in plan.exciters))
        exciter_m = np.array([e.position_m for e in plan.exciters]).reshape(-1, 3)
        self._unbalance = Attached.at(exciter_m, excited, drawn_m)

    def exciter_N(self, time_s: float) -> Array:
        """(exciters, 3)"""
        when = np.array([time_s])
        return np.array([exciter.force_N(when)[0] for exciter in self._exciters]).reshape(-1, 3)

    def at(self, poses: Poses, exciter_N: Array) -> Instant:
        (from_m, from_m_per_s), (to_m, to_m_per_s) = (end.motion(poses) for end in self._ends)
        axes = self._axes @ poses.rotation[self._ends[0].body].transpose(0, 2, 1)
        stretch_m = turned(axes, to_m - from_m) + self._sag_m
        stretch_m_per_s = turned(axes, to_m_per_s - from_m_per_s)
        pull_N = self.stiffness_N_per_m * stretch_m + self.damping_N_s_per_m * stretch_m_per_s
        pull_N = turned(axes.transpose(0, 2, 1), pull_N)
        couple_N_m = self._onto_first @ cross(to_m - from_m, pull_N)
        return Instant(
            poses,
            stretch_m,
            stretch_m_per_s,
            pull_N,
            from_m,
            to_m,
            couple_N_m,
            exciter_N,
            self._unbalance.motion(poses)[0],
        )

    def elastic_J(self, now: Instant) -> float:
        return float(np.sum(self.stiffness_N_per_m * now.stretch_m**2)) / 2

    def lost_J(self, before: Instant, after: Instant) -> float:
        mean_m_per_s = (before.stretch_m_per_s + after.stretch_m_per_s) / 2
        moved_m = after.stretch_m - before.stretch_m
        return float(np.sum(self.damping_N_s_per_m * mean_m_per_s * moved_m))
