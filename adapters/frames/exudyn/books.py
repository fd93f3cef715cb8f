"""The books of a trapezoidal run: momentum and energy, and what came from outside.

Driven bodies belong to the outside as the ground does, but have momentum and energy: their
drives give them whatever bushings and reactions do not (d'Alembert).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.poses import Attached, Poses, turned
from adapters.frames.exudyn.spatial_shaft import SpatialShaft
from adapters.frames.exudyn.trapezoidal import Forces, Instant
from orchestrator.ports import Account, Array, Saved
from orchestrator.ports.plans import FramesPlan
from orchestrator.ports.state import restore_attributes, save_attributes

_SUMS = ("_outside_N_s", "_lost_J", "_exciter_J", "_received_J")


class Books:
    """Sums over steps and intervals since ``start``; ``carried`` are the reaction's points."""

    def __init__(self, plan: FramesPlan, forces: Forces, carried: Attached, start: Instant) -> None:
        self._plan, self._forces, self._start = plan, forces, start.poses
        self._mass_kg = np.array([body.mass_kg for body in plan.bodies])
        self._inertia_kg_m2 = np.array([body.inertia_kg_m2 for body in plan.bodies])
        self._drawn_m = np.array([body.center_of_mass_m for body in plan.bodies])
        self._driven, free = linear.driven(plan), linear.free(plan)
        self._drives = [PushesOnDriven(int(n), forces, carried) for n in self._driven]
        self._free_weight_N = self._mass_kg[free].sum() * plan.gravity_m_per_s2
        first, second = forces.bodies
        self._pulls_on_free = 1.0 * np.isin(first, free) - np.isin(second, free)
        self._not_free = ~np.isin(carried.body, free)
        self._outside_N_s = np.zeros(3)
        self._lost_J = self._exciter_J = self._received_J = 0.0

    def step(self, before: Instant, after: Instant, step_s: float) -> None:
        """What ground, driven bodies, exciters and weight did to the free bodies, and losses."""
        outside_N = self._pulls_on_free @ (before.pull_N + after.pull_N) / 2
        outside_N += (before.exciter_N + after.exciter_N).sum(axis=0) / 2
        self._outside_N_s += step_s * (outside_N + self._free_weight_N)
        self._lost_J += self._forces.lost_J(before, after)
        mean_N = (before.exciter_N + after.exciter_N) / 2
        self._exciter_J += float(np.sum(mean_N * (after.exciter_m - before.exciter_m)))
        for drive in self._drives:
            drive.step(before, after, step_s)

    def turned(self, force_N: Array, step_s: float) -> None:
        """The force of an unbalance that a motor turns (3,), constant over the step."""
        self._outside_N_s += step_s * force_N

    def interval(self, force_N: Array, moved_m: Array, length_s: float) -> None:
        """The reaction (n, 3) on points that moved by ``moved_m`` (n, 3)."""
        self._received_J += float(np.sum(force_N * moved_m))
        self._outside_N_s -= length_s * force_N[self._not_free].sum(axis=0)
        for drive in self._drives:
            drive.interval(force_N, moved_m)

    def account(self, now: Instant, shafts: Sequence[SpatialShaft]) -> Account:
        kinetic_J, gravitational_J = self._kinetic_J(now.poses), self._gravitational_J(now.poses)
        supplied_J = {"exciter": self._exciter_J}
        if self._drives:
            gained_J = kinetic_J - self._kinetic_J(self._start)
            gained_J += gravitational_J - self._gravitational_J(self._start)
            pushed_J = sum(drive.work_J for drive in self._drives)
            supplied_J["drive"] = float(gained_J[self._driven].sum()) - pushed_J
        stored_J, lost_J = {}, {"bushing_damping": self._lost_J}
        if shafts:
            supplied_J["motor"] = sum(shaft.motor_J for shaft in shafts)
            stored_J["shaft"] = sum(shaft.stored_J(shaft.velocity_m_per_s(now.poses)) for shaft in shafts)
            lost_J["shaft_bearing"] = sum(shaft.lost_J for shaft in shafts)
        speeded_m_per_s = (now.poses.velocity_m_per_s - self._start.velocity_m_per_s)[self._driven]
        return Account(
            self._mass_kg @ now.poses.velocity_m_per_s[:-1],
            self._outside_N_s + self._mass_kg[self._driven] @ speeded_m_per_s,
            stored_J={
                "kinetic": float(kinetic_J.sum()),
                "bushing_elastic": self._forces.elastic_J(now),
                "gravitational": float(gravitational_J.sum()),
                **stored_J,
            },
            lost_J=lost_J,
            supplied_J=supplied_J,
            received_J={"reaction": self._received_J},
        )

    def save(self) -> Saved:
        drives_J = np.array([drive.work_J for drive in self._drives])
        return save_attributes(self, *_SUMS) | {"drives_J": drives_J}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_SUMS)
        for drive, work_J in zip(self._drives, saved["drives_J"], strict=True):
            drive.work_J = float(work_J)

    def _kinetic_J(self, poses: Poses) -> Array:
        """(bodies,)"""
        velocity_m_per_s, spin_rad_per_s = poses.velocity_m_per_s[:-1], poses.spin_rad_per_s[:-1]
        body_spin = turned(poses.rotation[:-1].transpose(0, 2, 1), spin_rad_per_s)
        turning_J = np.sum(body_spin * turned(self._inertia_kg_m2, body_spin), axis=1) / 2
        return np.asarray(self._mass_kg * (velocity_m_per_s**2).sum(axis=1) / 2 + turning_J)

    def _gravitational_J(self, poses: Poses) -> Array:
        """(bodies,), zero as drawn."""
        risen_m = poses.center_m[:-1] - self._drawn_m
        return np.asarray(-self._mass_kg * (risen_m @ self._plan.gravity_m_per_s2))


class PushesOnDriven:
    """``work_J`` that bushings and reactions have done on one driven body."""

    def __init__(self, body: int, forces: Forces, carried: Attached) -> None:
        first, second = forces.bodies
        self._body = body
        self._first, self._second = np.flatnonzero(first == body), np.flatnonzero(second == body)
        self._points = np.flatnonzero(carried.body == body)
        self.work_J = 0.0

    def step(self, before: Instant, after: Instant, step_s: float) -> None:
        """Mean force times displacement, and mean couple times mean spin."""
        mean_N, first, second = (before.pull_N + after.pull_N) / 2, self._first, self._second
        work_J = np.sum(mean_N[first] * (after.from_m - before.from_m)[first])
        work_J -= np.sum(mean_N[second] * (after.to_m - before.to_m)[second])
        couple_N_m = before.couple_N_m[self._body] + after.couple_N_m[self._body]
        spins = before.poses.spin_rad_per_s[self._body] + after.poses.spin_rad_per_s[self._body]
        self.work_J += float(work_J + step_s / 4 * (couple_N_m @ spins))

    def interval(self, force_N: Array, moved_m: Array) -> None:
        """The reaction on all points, and how far they moved, (n, 3) each."""
        self.work_J += float(np.sum(force_N[self._points] * moved_m[self._points]))
