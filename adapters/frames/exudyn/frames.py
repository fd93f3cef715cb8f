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

from dataclasses import replace
from typing import Any

import numpy as np

from adapters.frames.common.rigid_frames import RigidFrames, onto_bodies
from adapters.frames.exudyn import LARGEST_TILT_RAD
from adapters.frames.exudyn.forces import SpatialForces, SpatialLedger, SpatialShaft
from adapters.frames.exudyn.poses import Attached, Poses, cross
from orchestrator.ports import Account, Array, Load, Motion, Saved, check_point_count, linear_frames
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import FramesPlan, SolverFailed, SolverMissing

try:
    from adapters.frames.exudyn import system as exudyn_system
except ImportError as missing:
    raise SolverMissing("the exudyn frames need: pip install exudyn==1.13.6") from missing


class ExudynFrames(RigidFrames):
    """A solver of ``Frames`` by Exudyn.

    With ``plan.step_s`` = 0 the step is 0.05 over the highest natural frequency, exciter speed or drive
    speed.  Its relative error in a frequency is (w h)^2 / 24 = 1e-4.
    """

    COORDINATES = linear_frames.SPACE
    STATE = ("_wrench", "_instant", "_couple_N_m", "_points")
    _shafts: list[SpatialShaft]
    _ledger: SpatialLedger

    def __init__(self, plan: FramesPlan) -> None:
        self._driven = tuple(
            exudyn_system.Driven(int(number), plan.bodies[number], drive, LARGEST_TILT_RAD)
            for number, drive in zip(linear_frames.driven(plan), plan.drives, strict=True)
        )
        super().__init__(plan)
        free = [plan.bodies[number] for number in self._free]
        self._mass_kg = np.array([body.mass_kg for body in free])
        self._inertia_kg_m2 = np.array([body.inertia_kg_m2 for body in free]).reshape(-1, 3, 3)
        self._longest_s = exudyn_system.largest_step_s(plan, self._machine)
        sag_m = (self._machine.stretch @ self._sag).reshape(-1, 3)
        self._carried = Attached.at(plan.points_m, self._carrier, self._drawn_m)
        self._onto_bodies = onto_bodies(plan, self._carrier)
        self._shafts = [
            SpatialShaft(exciter, exciter.motor, plan, self._drawn_m)
            for exciter in plan.exciters
            if exciter.motor is not None
        ]
        steady = tuple(exciter for exciter in plan.exciters if exciter.motor is None)
        prescribed = replace(plan, exciters=steady)
        self._forces = SpatialForces(prescribed, self._drawn_m, sag_m)
        self._bodies = exudyn_system.assemble_system(prescribed, sag_m)
        self._wrench = np.zeros((len(plan.bodies), 6))
        self._settings = exudyn_system.settings(plan)
        exudyn_system.place_at_start(self._bodies.system.systemData, self._driven, len(plan.bodies))
        self._solver: Any = exudyn_system.open_solver(self._bodies.system, self._settings)
        self._instant = self._forces.at(self._read(), self._forces.exciter_N(0.0))
        self._couple_N_m = self._instant.couple_N_m  # one step before ``_instant``
        self._points = self._moved()
        self._ledger = SpatialLedger(plan, self._forces, self._carried, self._instant.poses)

    def initial(self) -> Motion:
        return self._points

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        check_point_count("frames' reaction", reaction, len(self._plan.points_m))
        wrench = self._wrench_of(reaction, interval.length_s)
        for shaft in self._shafts:
            wrench[shaft.body] += shaft.wrench
        self._apply(wrench)
        steps = interval.steps(self._longest_s)
        step_s = interval.length_s / steps
        exudyn_system.start_interval(self._solver, step_s)
        for step in range(1, steps + 1):
            self._step(interval.start_s + step * step_s, step_s)
        before, self._points = self._points, self._moved()
        moved_m = self._points.position_m - before.position_m
        self._ledger.interval(reaction.force_N, moved_m, interval.length_s)
        return self._points

    def account(self) -> Account:
        now = self._instant.poses
        shafts = [(shaft, shaft.velocity_m_per_s(now)) for shaft in self._shafts]
        elastic_J = self._forces.elastic_J(self._instant)
        return self._ledger.account(self._ledger.bodies(now), elastic_J, shafts)

    def save(self) -> Saved:
        return super().save() | {"system": exudyn_system.save_system(self._bodies.system, self._solver)}

    def restore(self, saved: Saved) -> None:
        super().restore(saved)
        exudyn_system.restore_system(self._bodies.system, self._solver, saved["system"])

    def close(self) -> None:
        if self._solver is not None:
            self._solver.FinalizeSolver(self._bodies.system, self._settings)
            self._solver = None

    def _read(self) -> Poses:
        data = self._bodies.system.systemData
        coordinates, rates = data.GetODE2Coordinates(), data.GetODE2Coordinates_t()
        return Poses.of(self._drawn_m, coordinates.reshape(-1, 6), rates.reshape(-1, 6))

    def _moved(self) -> Motion:
        return Motion(*self._carried.motion(self._instant.poses))

    def _wrench_of(self, reaction: Load, length_s: float) -> Array:
        """Return the reaction's force and moment about the centres of mass, (bodies, 6).

        The lever arms are extrapolated to the middle of the interval.
        """
        body, poses, now = self._carried.body, self._instant.poses, self._points
        arm_m = now.position_m - poses.center_m[body]
        arm_m += length_s / 2 * (now.velocity_m_per_s - poses.velocity_m_per_s[body])
        moment_N_m = cross(arm_m, reaction.force_N)
        return np.asarray(self._onto_bodies @ np.hstack([reaction.force_N, moment_N_m]))

    def _apply(self, wrench: Array) -> None:
        """Set the loads, and add their change over the mass to the accelerations of free bodies."""
        system, free = self._bodies.system, self._free
        for load, force_N in zip(self._bodies.forces, wrench[:, :3], strict=True):
            system.SetLoadParameter(load, "loadVector", force_N)
        rotation = self._instant.poses.rotation[free]
        inertia = rotation @ self._inertia_kg_m2 @ rotation.transpose(0, 2, 1)
        inertia = inertia @ self._instant.poses.spin_per_rate[free]
        change = wrench[free] - self._wrench[free]
        data = system.systemData
        acceleration = data.GetODE2Coordinates_tt().reshape(-1, 6)
        acceleration[free, :3] += change[:, :3] / self._mass_kg[:, None]
        acceleration[free, 3:] += np.linalg.solve(inertia, change[:, 3:, None])[:, :, 0]
        data.SetODE2Coordinates_tt(acceleration.ravel())
        self._wrench = wrench

    def _torque_N_m(self) -> Array:
        """Return the torques at the end of the coming step.

        Exudyn applies a bushing's force at its two ends, which lie a stretch apart, without the couple that
        balances the forces.  The torques have this couple, extrapolated to the end of the step.
        """
        couple_N_m = 2 * self._instant.couple_N_m - self._couple_N_m
        return np.asarray(self._wrench[:, 3:] + couple_N_m)

    def _step(self, end_s: float, step_s: float) -> None:
        for shaft in self._shafts:
            wrench = self._wrench.copy()
            wrench[shaft.body] += shaft.turn(self._instant.poses, end_s, step_s)
            self._apply(wrench)
        exciter_N = self._forces.exciter_N(end_s)
        system, solver = self._bodies.system, self._solver
        for load, force_N in zip(self._bodies.exciters, exciter_N, strict=True):
            system.SetLoadParameter(load, "loadVector", force_N)
        for load, torque_N_m in zip(self._bodies.torques, self._torque_N_m(), strict=True):
            system.SetLoadParameter(load, "loadVector", torque_N_m)
        for driven in self._driven:
            driven.steer(system.systemData, step_s, end_s)
        solver.InitializeStep(system, self._settings)
        converged = solver.DiscontinuousIteration(system, self._settings)
        solver.FinishStep(system, self._settings)
        tilt = np.abs(system.systemData.GetODE2Coordinates().reshape(-1, 6)[:, 4]).max()
        if not converged or not tilt < LARGEST_TILT_RAD:  # NaN is not smaller either
            reason = "its step did not converge" if not converged else f"a body tilts {tilt} rad"
            raise SolverFailed(f"exudyn frames at {end_s} s: {reason}")
        before, self._instant = self._instant, self._forces.at(self._read(), exciter_N)
        self._couple_N_m = before.couple_N_m
        self._ledger.step(before, self._instant, step_s)
        for shaft in self._shafts:
            shaft.feel(self._instant.poses, end_s, step_s)
            self._ledger.outside_N_s += step_s * shaft.wrench[:3]
