"""Rigid bodies with six degrees of freedom on bushings, by Exudyn.

The bodies move by Newmark's trapezoidal rule (beta = 1/4, gamma = 1/2: second order, no numerical damping;
Newmark, Journal of the Engineering Mechanics Division 85, 1959, 67-94), in a whole number of steps per sync
interval, which are made by hand.  The reaction is constant over the interval.  At its start the accelerations
take the jump from the last load, so that the discrete impulse is the load's impulse to rounding.  The lever
arms of the points are extrapolated to the middle of the interval.

Bodies with a drive move as prescribed, to rounding, under any forces; the other bodies are free.

A machine drawn at rest has its bushings stretched so that they carry weight and initial
reaction in the drawn position.  Equations and limits: docs/theory/frames.md.
Exudyn: Gerstmayr, Multibody System Dynamics 60, 2024, 533-561, doi 10.1007/s11044-023-09937-1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from adapters.frames.common.ledger import FramesLedger
from adapters.frames.common.rigid_frames import RigidFrames
from adapters.frames.exudyn import LARGEST_TILT_RAD
from adapters.frames.exudyn.compiled import CompiledBodies
from adapters.frames.exudyn.shaft import SpatialShaft
from orchestrator.ports import Account, Array, Load, Motion, Pose, Saved, check_point_count, linear_frames
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import FrameLoads
from orchestrator.ports.plans import FramesPlan, SolverFailed, SolverMissing

try:
    from adapters.frames.exudyn import system as exudyn_system
except ImportError as missing:
    raise SolverMissing("the exudyn frames need Exudyn, which docker/setup.sh installs") from missing


class ExudynFrames(RigidFrames):
    """A solver of ``Frames`` by Exudyn.

    With ``plan.step_s`` = 0 the step is 0.05 over the highest natural frequency, exciter speed or drive
    speed.  Its relative error in a frequency is (w h)^2 / 12 = 2e-4.
    """

    COORDINATES = linear_frames.SPACE
    STATE = ("_points",)
    _shafts: list[SpatialShaft]

    def __init__(self, plan: FramesPlan) -> None:
        self._driven = tuple(
            exudyn_system.Driven(int(number), plan.bodies[number], drive, LARGEST_TILT_RAD)
            for number, drive in zip(linear_frames.driven(plan), plan.drives, strict=True)
        )
        super().__init__(plan)
        plan = self._plan
        self._longest_s = exudyn_system.largest_step_s(plan, self._stiffest())
        self._longest_s = min(self._longest_s, self._elements.hysteresis.shortest_s / 2)
        self._shafts = [
            SpatialShaft(exciter, exciter.motor, plan, self._drawn_m)
            for exciter in plan.exciters
            if exciter.motor is not None
        ]
        steady = tuple(exciter for exciter in plan.exciters if exciter.motor is None)
        prescribed = replace(plan, exciters=steady)
        self._bodies = CompiledBodies(prescribed, self._carrier, self._drawn_m, self._sag_m)
        self._step_s = 0.0
        self._reaction, self._torque_N_m = Load.zero(len(plan.points_m)), np.zeros((len(plan.bodies), 3))
        self._multibody = exudyn_system.assemble_system(prescribed, self._sag_m, self._element_force_N)
        self._system = self._multibody.system
        self._data = self._system.systemData
        self._settings = exudyn_system.settings(plan, self._elements.stiffness_N_per_m.sum())
        exudyn_system.place_at_start(self._data, self._driven, len(plan.bodies))
        self._solver: Any = exudyn_system.open_solver(self._system, self._settings)
        self._bodies.kernel.start(
            coordinates=self._data.GetODE2Coordinates(), rates=self._data.GetODE2Coordinates_t()
        )
        self._points = self._bodies.carried()
        self._ledger = FramesLedger(plan, self._bodies.motion())

    def initial(self) -> Motion:
        return self._points

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        check_point_count("frames' reaction", reaction, len(self._plan.points_m))
        kernel, length_s = self._bodies.kernel, interval.length_s
        self._reaction = reaction
        reaction_N = np.ascontiguousarray(reaction.force_N)
        wrench = kernel.wrench_of(force_N=reaction_N, length_s=length_s)
        for shaft in self._shafts:
            wrench[shaft.body] += shaft.wrench
        self._apply(wrench)
        steps = interval.steps(self._longest_s)
        step_s = length_s / steps
        exudyn_system.start_interval(self._solver, step_s)
        for step in range(1, steps + 1):
            self._step(interval.start_s + step * step_s, step_s)
        before, self._points = self._points, self._bodies.carried()
        books = kernel.reaction(
            force_N=reaction_N, before_m=before.position_m, after_m=self._points.position_m, length_s=length_s
        )
        self._ledger.add(**books)
        return self._points

    def pose(self) -> Pose:
        return self._bodies.pose()

    def loads(self) -> FrameLoads | None:
        if self._driven:
            return None
        memory, poses, data = self._bodies.memory, self._bodies.poses, self._data
        rate, growth = (
            np.reshape(each, (-1, 6)) for each in (data.GetODE2Coordinates_t(), data.GetODE2Coordinates_tt())
        )
        steady, shafts = zip(memory["exciter_N"], memory["exciter_m"], strict=True), iter(self._shafts)
        lag_N_m = self._torque_N_m - memory["couple_N_m"]
        lag_N_m -= self._bodies.kernel.wrench_of(force_N=self._reaction.force_N, length_s=0.0)[:, 3:]
        exciter_N, exciter_m = np.empty((2, len(self._plan.exciters), 3))
        for n, exciter in enumerate(self._plan.exciters):
            if exciter.motor is None:
                exciter_N[n], exciter_m[n] = next(steady)
                continue
            shaft = next(shafts)
            exciter_N[n], exciter_m[n] = shaft.wrench[:3], shaft.place_m(poses)
            lag_N_m[shaft.body] -= np.cross(exciter_m[n] - poses.center_m[shaft.body], exciter_N[n])
        return FrameLoads(
            bushing_N=memory["pull_N"].copy(),
            bushing_m=memory["to_m"].copy(),
            exciter_N=exciter_N,
            exciter_m=exciter_m,
            lag_N_m=lag_N_m,
            acceleration_m_per_s2=growth[:, :3],
            angular_acceleration_rad_per_s2=poses.angular_acceleration_rad_per_s2(rate[:, 3:], growth[:, 3:]),
        )

    def account(self) -> Account:
        shafts = [(shaft, shaft.velocity_m_per_s(self._bodies.poses)) for shaft in self._shafts]
        elastic_J = self._bodies.elastic_J() + self._elements.stored_J()
        return self._ledger.account(self._bodies.motion(), elastic_J, shafts)

    def save(self) -> Saved:
        system = exudyn_system.save_system(self._system, self._solver)
        return super().save() | {"bodies": self._bodies.save(), "system": system}

    def restore(self, saved: Saved) -> None:
        super().restore(saved)
        self._bodies.restore(saved["bodies"])
        exudyn_system.restore_system(self._system, self._solver, saved["system"])

    def close(self) -> None:
        if self._solver is not None:
            self._solver.FinalizeSolver(self._system, self._settings)
            self._solver = None

    def _apply(self, wrench: Array) -> None:
        """Set the loads, and accelerate free bodies by their change."""
        for load, force_N in zip(self._multibody.forces, wrench[:, :3], strict=True):
            self._system.SetLoadParameter(load, "loadVector", force_N)
        self._accelerate(wrench)

    def _accelerate(self, wrench: Array) -> None:
        """Add the change of the loads over the mass to the accelerations of free bodies."""
        acceleration = self._data.GetODE2Coordinates_tt()
        self._bodies.kernel.apply(wrench=wrench, acceleration=acceleration)
        self._data.SetODE2Coordinates_tt(acceleration)

    def _element_force_N(self, bushing: int, apart_m: Sequence[float]) -> list[float]:
        """Return the force (3,) of a bushing's elements at the end of the present step, along its axes.

        Its ends are then ``apart_m`` (3,) apart, sag not included.
        """
        if self._step_s == 0:  # Exudyn opens at t = 0, where elements have no force
            return [0.0, 0.0, 0.0]
        start_m = self._bodies.memory["stretch_m"][bushing] - self._sag_m[bushing]
        moved_m = [end_m - at_m for end_m, at_m in zip(apart_m, start_m.tolist(), strict=True)]
        return self._elements.end_of_one_N(bushing, moved_m, self._step_s)

    def _stretch_elements(self, start_m: Array, step_s: float) -> None:
        """Go with the elements of bushings to the step's end; ``start_m`` (bushings, 3) are the stretches at
        its start.  Their forces are those that acted there."""
        moved_m = self._bodies.memory["stretch_m"] - start_m
        self._bodies.memory["element_N"][:] = self._elements.end_N(moved_m, step_s)
        self._ledger.damping_J += self._elements.accept(moved_m, step_s)

    def _begin_anew(self) -> None:
        """Give gap springs their force at the step's end in place of the one that acted there.

        The latter gives the step its mean force.  The next step begins with accelerations by the former.
        """
        wrench = self._bodies.replace_element_forces(self._elements.force_N)
        before = self._bodies.memory["wrench"].copy()
        self._accelerate(before + wrench)
        self._bodies.memory["wrench"][:] = before

    def _step(self, end_s: float, step_s: float) -> None:
        """Make a step under the loads at its end.

        Exudyn applies a bushing's force at its two ends, which lie a stretch apart, without the couple that
        balances the forces.  The torques have this couple, extrapolated to the end of the step.
        """
        bodies, system, solver = self._bodies, self._system, self._solver
        self._step_s = step_s
        for shaft in self._shafts:
            wrench = bodies.memory["wrench"].copy()
            wrench[shaft.body] += shaft.turn(bodies.poses, end_s, step_s)
            self._apply(wrench)
        exciter_N, self._torque_N_m = bodies.kernel.coming_loads(end_s=end_s)
        for load, force_N in zip(self._multibody.exciters, exciter_N, strict=True):
            system.SetLoadParameter(load, "loadVector", force_N)
        for load, couple_N_m in zip(self._multibody.torques, self._torque_N_m, strict=True):
            system.SetLoadParameter(load, "loadVector", couple_N_m)
        for driven in self._driven:
            driven.steer(self._data, step_s, end_s)
        solver.InitializeStep(system, self._settings)
        converged = solver.DiscontinuousIteration(system, self._settings)
        solver.FinishStep(system, self._settings)
        coordinates = self._data.GetODE2Coordinates()
        tilts_rad = [abs(angle_rad) for angle_rad in coordinates[4::6].tolist()]
        if not converged or not all(tilt < LARGEST_TILT_RAD for tilt in tilts_rad):  # nor is NaN smaller
            reason = (
                "its step did not converge" if not converged else f"a body tilts {max(tilts_rad):.3g} rad"
            )
            raise SolverFailed(f"exudyn frames at {end_s:.6g} s: {reason}")
        start_m = bodies.memory["stretch_m"].copy() if self._elements else None
        bodies.kernel.reach(coordinates=coordinates, rates=self._data.GetODE2Coordinates_t())
        if start_m is not None:
            self._stretch_elements(start_m, step_s)
        self._ledger.add(**bodies.kernel.book(step_s=step_s))
        if self._elements.gap_springs:
            self._begin_anew()
        for shaft in self._shafts:
            shaft.feel(bodies.poses, end_s, step_s)
            self._ledger.outside_N_s += step_s * shaft.wrench[:3]
