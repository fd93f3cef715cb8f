"""Forces on bodies at an instant, and the ledger of trapezoidal steps between two instants.

Newmark's step with beta = 1/4, gamma = 1/2 is  m (v1 - v0) = h/2 (f0 + f1)  and
x1 - x0 = h/2 (v0 + v1): so the mean of the forces at its two ends gives its impulse to rounding,
and mean force times displacement gives its work exactly where the equations are linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.frames.common.exciter import Unbalance
from adapters.frames.common.ledger import BodyMotion, FramesLedger
from adapters.frames.common.rigid_frames import onto_bodies
from adapters.frames.exudyn.poses import Attached, Poses, cross, turned
from orchestrator.ports import Array, linear_frames
from orchestrator.ports.plans import FramesPlan


@dataclass(frozen=True)
class Instant:
    """Holds poses and forces at one time.

    ``stretch_m``, ``stretch_m_per_s`` (bushings, 3) along the spring axes; ``pull_N`` (bushings, 3)
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


class SpatialForces:
    """Evaluates bushings and exciters, ``sag_m`` (bushings, 3) as in ``system.assemble_system``.

    ``bodies``: the numbers (bushings,) of the bushings' first and of their second bodies."""

    def __init__(self, plan: FramesPlan, drawn_m: Array, sag_m: Array) -> None:
        place_m = np.array([b.position_m for b in plan.bushings]).reshape(-1, 3)
        first, second = (
            linear_frames.numbers(plan, tuple(b.bodies[end] for b in plan.bushings)) for end in (0, 1)
        )
        self.bodies = first, second
        self._ends = Attached.at(place_m, first, drawn_m), Attached.at(place_m, second, drawn_m)
        self._axes = np.array([b.axes for b in plan.bushings]).reshape(-1, 3, 3)
        self._sag_m = sag_m
        self.stiffness_N_per_m = np.array([b.stiffness_N_per_m for b in plan.bushings]).reshape(-1, 3)
        self.damping_N_s_per_m = np.array([b.damping_N_s_per_m for b in plan.bushings]).reshape(-1, 3)
        self._onto_first = onto_bodies(plan, first)
        self._exciters = [Unbalance(exciter) for exciter in plan.exciters]
        excited = linear_frames.numbers(plan, tuple(e.body for e in plan.exciters))
        exciter_m = np.array([e.position_m for e in plan.exciters]).reshape(-1, 3)
        self._unbalance = Attached.at(exciter_m, excited, drawn_m)

    def exciter_N(self, time_s: float) -> Array:
        """Return the force of each exciter, (exciters, 3)."""
        when = np.array([time_s])
        return np.array([exciter.force_N(when)[0] for exciter in self._exciters]).reshape(-1, 3)

    def at(self, poses: Poses, exciter_N: Array) -> Instant:
        """Evaluate all forces on bodies in these poses."""
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
        """Return the energy in the bushings."""
        return float(np.sum(self.stiffness_N_per_m * now.stretch_m**2)) / 2

    def lost_J(self, before: Instant, after: Instant) -> float:
        """Return what bushings dissipate in a step."""
        mean_m_per_s = (before.stretch_m_per_s + after.stretch_m_per_s) / 2
        moved_m = after.stretch_m - before.stretch_m
        return float(np.sum(self.damping_N_s_per_m * mean_m_per_s * moved_m))


class SpatialLedger(FramesLedger):
    """The ledger of trapezoidal steps since ``start``; ``carried`` are the reaction's points."""

    def __init__(self, plan: FramesPlan, forces: SpatialForces, carried: Attached, start: Poses) -> None:
        self._forces = forces
        self._inertia_kg_m2 = np.array([body.inertia_kg_m2 for body in plan.bodies])
        self._drawn_m = np.array([body.center_of_mass_m for body in plan.bodies])
        driven, free = linear_frames.driven(plan), linear_frames.free(plan)
        super().__init__(plan, self.bodies(start))
        self._free_weight_N = self._mass_kg[free].sum() * plan.gravity_m_per_s2
        first, second = forces.bodies
        self._pulls_on_free = 1.0 * np.isin(first, free) - np.isin(second, free)
        self._first_driven, self._second_driven = np.isin(first, driven), np.isin(second, driven)
        self._on_driven, self._not_free = np.isin(carried.body, driven), ~np.isin(carried.body, free)

    def bodies(self, poses: Poses) -> BodyMotion:
        """Return how bodies in these poses move."""
        velocity_m_per_s, spin_rad_per_s = poses.velocity_m_per_s[:-1], poses.spin_rad_per_s[:-1]
        body_spin = turned(poses.rotation[:-1].transpose(0, 2, 1), spin_rad_per_s)
        turning_J = np.sum(body_spin * turned(self._inertia_kg_m2, body_spin), axis=1) / 2
        return BodyMotion(velocity_m_per_s, poses.center_m[:-1] - self._drawn_m, turning_J)

    def step(self, before: Instant, after: Instant, step_s: float) -> None:
        """Book what ground, driven bodies, exciters and weight did to the free bodies, the losses, and
        the work of bushings on driven bodies."""
        pull_N, exciter_N = (before.pull_N + after.pull_N) / 2, (before.exciter_N + after.exciter_N) / 2
        outside_N = self._pulls_on_free @ pull_N + exciter_N.sum(axis=0)
        self.outside_N_s += step_s * (outside_N + self._free_weight_N)
        self.damping_J += self._forces.lost_J(before, after)
        self.exciter_J += float(np.sum(exciter_N * (after.exciter_m - before.exciter_m)))
        first_J = np.sum(pull_N * (after.from_m - before.from_m), axis=1) @ self._first_driven
        second_J = np.sum(pull_N * (after.to_m - before.to_m), axis=1) @ self._second_driven
        couple_N_m = (before.couple_N_m + after.couple_N_m)[self._driven]
        spin_rad_per_s = before.poses.spin_rad_per_s + after.poses.spin_rad_per_s
        turning_J = step_s / 4 * np.sum(couple_N_m * spin_rad_per_s[self._driven])
        self.pushed_J += float(first_J - second_J + turning_J)

    def interval(self, force_N: Array, moved_m: Array, length_s: float) -> None:
        """Book the reaction (n, 3) on points that moved by ``moved_m`` (n, 3)."""
        work_J = np.sum(force_N * moved_m, axis=1)
        self.reaction_J += float(work_J.sum())
        self.pushed_J += float(work_J @ self._on_driven)
        self.outside_N_s -= length_s * force_N[self._not_free].sum(axis=0)
