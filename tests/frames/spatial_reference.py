"""Poses, forces and books of bodies in space as they are read: what ``frames/kernel/spatial.h`` computes.

Newmark's step with beta = 1/4, gamma = 1/2 is  m (v1 - v0) = h/2 (f0 + f1)  and
x1 - x0 = h/2 (v0 + v1).  So the mean of the forces at the two ends of a step gives the step's impulse to
rounding, and mean force times displacement gives the work exactly where the equations are linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.frames.common.rigid_frames import BushingTable, Unbalances, onto_bodies
from adapters.frames.exudyn.poses import Attached, Poses, turning
from orchestrator.ports import Array, Load, linear_frames
from orchestrator.ports.interface_records import cross, turn
from orchestrator.ports.plans import FramesPlan


@dataclass(frozen=True)
class Instant:
    """Poses and forces at one time; the names are those of ``CompiledBodies.memory``."""

    poses: Poses
    stretch_m: Array
    stretch_m_per_s: Array
    pull_N: Array
    from_m: Array
    to_m: Array
    couple_N_m: Array
    exciter_N: Array
    exciter_m: Array


def poses_of(drawn_m: Array, coordinates: Array, rates: Array) -> Poses:
    """Poses from displacements with Tait-Bryan angles (rotation Rx Ry Rz), (bodies, 6), and their rates."""
    bodies = len(drawn_m)
    center_m, velocity_m_per_s, spin_rad_per_s = np.zeros((3, bodies + 1, 3))
    center_m[:-1] = drawn_m + coordinates[:, :3]
    velocity_m_per_s[:-1] = rates[:, :3]
    rotation, spin_per_rate = turning(coordinates[:, 3:])
    spin_rad_per_s[:-1] = turn(spin_per_rate, rates[:, 3:])
    rotation = np.concatenate([rotation, np.eye(3)[None]])
    return Poses(center_m, rotation, velocity_m_per_s, spin_rad_per_s, spin_per_rate)


class SpatialReference:
    """The bodies of a plan whose bushings are stretched by ``sag_m`` (bushings, 3) as drawn."""

    def __init__(self, plan: FramesPlan, sag_m: Array) -> None:
        self.drawn_m = np.array([body.center_of_mass_m for body in plan.bodies])
        self._plan, self._table, self._sag_m = plan, BushingTable(plan), sag_m
        self._ends = self._table.first, self._table.second
        self._at_ends = [Attached.at(self._table.place_m, body, self.drawn_m) for body in self._ends]
        self._onto_first = onto_bodies(plan, self._table.first)
        self._unbalances = Unbalances(plan, plan.exciters)
        self._excited = Attached.at(self._unbalances.place_m, self._unbalances.body, self.drawn_m)
        carrier = linear_frames.numbers(plan, plan.carrier)
        self.carried = Attached.at(plan.points_m, carrier, self.drawn_m)
        self._free, self._driven = linear_frames.free(plan), linear_frames.driven(plan)

    def at(self, coordinates: Array, rates: Array, time_s: float, element_N: Array | float = 0.0) -> Instant:
        """The forces on bodies with these coordinates, (bodies, 6), and with the force ``element_N``
        (bushings, 3) of friction and Maxwell elements along the bushings' axes."""
        poses = poses_of(self.drawn_m, coordinates, rates)
        (from_m, from_m_per_s), (to_m, to_m_per_s) = (end.motion(poses) for end in self._at_ends)
        axes = self._table.axes @ poses.rotation[self._ends[0]].transpose(0, 2, 1)
        stretch_m = turn(axes, to_m - from_m) + self._sag_m
        stretch_m_per_s = turn(axes, to_m_per_s - from_m_per_s)
        pull_N = self._table.stiffness_N_per_m * stretch_m + self._table.damping_N_s_per_m * stretch_m_per_s
        pull_N = turn(axes.transpose(0, 2, 1), pull_N + element_N)
        couple_N_m = self._onto_first @ cross(to_m - from_m, pull_N)
        exciter_N = self._unbalances.force_N(np.array([time_s]))[0]
        exciter_m = self._excited.motion(poses)[0]
        parts = (stretch_m, stretch_m_per_s, pull_N, from_m, to_m, couple_N_m, exciter_N, exciter_m)
        return Instant(poses, *parts)

    def wrench_of(self, now: Instant, reaction: Load, length_s: float) -> Array:
        """Force and moment about the centres of mass (bodies, 6), with the interval's middle lever arms."""
        position_m, velocity_m_per_s = self.carried.motion(now.poses)
        body = self.carried.body
        arm_m = position_m - now.poses.center_m[body]
        arm_m += length_s / 2 * (velocity_m_per_s - now.poses.velocity_m_per_s[body])
        moment_N_m = cross(arm_m, reaction.force_N)
        return np.asarray(onto_bodies(self._plan, body) @ np.hstack([reaction.force_N, moment_N_m]))

    def acceleration_of(self, now: Instant, change: Array) -> Array:
        """The change (bodies, 6) of the accelerations of free bodies with a change of their wrench."""
        acceleration = np.zeros_like(change)
        for number in self._free:
            body, rotation = self._plan.bodies[number], now.poses.rotation[number]
            inertia = rotation @ body.inertia_kg_m2 @ rotation.T @ now.poses.spin_per_rate[number]
            acceleration[number, :3] = change[number, :3] / body.mass_kg
            acceleration[number, 3:] = np.linalg.solve(inertia, change[number, 3:])
        return acceleration

    def step_books(self, before: Instant, after: Instant, step_s: float) -> dict[str, Array | float]:
        """The impulse and work that ground, driven bodies, exciters and weight gave to the free bodies, the
        losses, and the work of bushings on driven bodies."""
        first, second = self._ends
        pulls_on_free = 1.0 * np.isin(first, self._free) - np.isin(second, self._free)
        pull_N, exciter_N = (before.pull_N + after.pull_N) / 2, (before.exciter_N + after.exciter_N) / 2
        free_kg = sum(self._plan.bodies[number].mass_kg for number in self._free)
        outside_N = pulls_on_free @ pull_N + exciter_N.sum(axis=0) + free_kg * self._plan.gravity_m_per_s2
        mean_m_per_s = (before.stretch_m_per_s + after.stretch_m_per_s) / 2
        moved_m = after.stretch_m - before.stretch_m
        first_J = np.sum(pull_N * (after.from_m - before.from_m), axis=1) @ np.isin(first, self._driven)
        second_J = np.sum(pull_N * (after.to_m - before.to_m), axis=1) @ np.isin(second, self._driven)
        couple_N_m = (before.couple_N_m + after.couple_N_m)[self._driven]
        spin_rad_per_s = (before.poses.spin_rad_per_s + after.poses.spin_rad_per_s)[self._driven]
        turning_J = step_s / 4 * np.sum(couple_N_m * spin_rad_per_s)
        return {
            "outside_N_s": step_s * outside_N,
            "damping_J": float(np.sum(self._table.damping_N_s_per_m * mean_m_per_s * moved_m)),
            "exciter_J": float(np.sum(exciter_N * (after.exciter_m - before.exciter_m))),
            "reaction_J": 0.0,
            "pushed_J": float(first_J - second_J + turning_J),
        }

    def reaction_books(self, reaction: Load, moved_m: Array, length_s: float) -> dict[str, Array | float]:
        """The books of a reaction on the carried points, which moved by ``moved_m`` (n, 3)."""
        work_J = np.sum(reaction.force_N * moved_m, axis=1)
        not_free = ~np.isin(self.carried.body, self._free)
        return {
            "outside_N_s": -length_s * reaction.force_N[not_free].sum(axis=0),
            "damping_J": 0.0,
            "exciter_J": 0.0,
            "reaction_J": float(work_J.sum()),
            "pushed_J": float(work_J @ np.isin(self.carried.body, self._driven)),
        }
