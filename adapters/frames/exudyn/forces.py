"""Forces at an instant, shafts of motors, and the ledger of trapezoidal steps between two instants.

Newmark's step with beta = 1/4, gamma = 1/2 is  m (v1 - v0) = h/2 (f0 + f1)  and
x1 - x0 = h/2 (v0 + v1).  So the mean of the forces at the two ends of a step gives the step's impulse to
rounding, and mean force times displacement gives the work exactly where the equations are linear.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.frames.common.exciter import Shaft
from adapters.frames.common.ledger import BodyMotion, FramesLedger
from adapters.frames.common.rigid_frames import BushingTable, Unbalances, onto_bodies
from adapters.frames.exudyn.poses import Attached, Poses, cross, turn
from orchestrator.ports import Array, linear_frames
from orchestrator.ports.plans import ExciterPlan, FramesPlan, MotorPlan, SolverFailed

MOST_ROUNDS = 50
TOLERANCE = 1e-14
"""The largest error of a shaft's step, as a share of its synchronous speed."""


@dataclass(frozen=True)
class Instant:
    """Poses and forces at one time.

    ``stretch_m`` and ``stretch_m_per_s`` (bushings, 3) are along the spring axes.  ``pull_N`` (bushings, 3)
    acts on the first body at ``from_m``, and its opposite on the second body at ``to_m``.  ``couple_N_m``
    (bodies, 3) is the couple that a stretched bushing adds to its first body.  ``exciter_N`` and
    ``exciter_m`` (exciters, 3) are the forces and places of the exciters.
    """

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
    """The forces of bushings and exciters, with ``sag_m`` (bushings, 3) as in ``system.assemble_system``.

    ``bodies`` are the numbers of the bushings' first bodies and of their second bodies, (bushings,) each.
    """

    def __init__(self, plan: FramesPlan, drawn_m: Array, sag_m: Array) -> None:
        self._table, self._sag_m = BushingTable(plan), sag_m
        self.bodies = self._table.first, self._table.second
        first, second = (Attached.at(self._table.place_m, body, drawn_m) for body in self.bodies)
        self._ends = first, second
        self._onto_first = onto_bodies(plan, first.body)
        self._unbalances = Unbalances(plan, plan.exciters)
        self._excited = Attached.at(self._unbalances.place_m, self._unbalances.body, drawn_m)

    def exciter_N(self, time_s: float) -> Array:
        """Return the force of each exciter, (exciters, 3)."""
        return np.asarray(self._unbalances.force_N(np.array([time_s]))[0])

    def at(self, poses: Poses, exciter_N: Array) -> Instant:
        """Return the forces on bodies in these poses, with the forces of the exciters given."""
        (from_m, from_m_per_s), (to_m, to_m_per_s) = (end.motion(poses) for end in self._ends)
        axes = self._table.axes @ poses.rotation[self._ends[0].body].transpose(0, 2, 1)
        stretch_m = turn(axes, to_m - from_m) + self._sag_m
        stretch_m_per_s = turn(axes, to_m_per_s - from_m_per_s)
        pull_N = self._table.stiffness_N_per_m * stretch_m + self._table.damping_N_s_per_m * stretch_m_per_s
        pull_N = turn(axes.transpose(0, 2, 1), pull_N)
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
            self._excited.motion(poses)[0],
        )

    def elastic_J(self, now: Instant) -> float:
        """Return the elastic energy in the bushings in J."""
        return float(np.sum(self._table.stiffness_N_per_m * now.stretch_m**2)) / 2

    def lost_J(self, before: Instant, after: Instant) -> float:
        """Return the energy in J that bushings dissipate in the step from ``before`` to ``after``."""
        mean_m_per_s = (before.stretch_m_per_s + after.stretch_m_per_s) / 2
        moved_m = after.stretch_m - before.stretch_m
        return float(np.sum(self._table.damping_N_s_per_m * mean_m_per_s * moved_m))


class SpatialShaft(Shaft):
    """A shaft about any axis, in steps of the midpoint rule.

    In a step the frame gets the mean of the unbalance's force,  -u (r'1 - r'0) / h,  with the radial unit
    vector r, so that its impulse is the momentum lost by the unbalance, to rounding.  The step is predicted
    with the acceleration of the shaft's place, extrapolated from the last two steps, and accepted with the
    acceleration that the frame then had.  It is of second order, like the frames' own steps.

    ``wrench`` (6,) is the force and the moment about the centre of mass of body number ``body`` in the
    present step.  In each step ``turn`` is called first, then ``feel``.
    """

    STATE = (*Shaft.STATE, "wrench", "_given_1_s", "_felt_m_per_s2", "_felt_before_m_per_s2")

    def __init__(self, exciter: ExciterPlan, motor: MotorPlan, plan: FramesPlan, drawn_m: Array) -> None:
        super().__init__(exciter, motor, plan)
        numbers = linear_frames.numbers(plan, (exciter.body,))
        self.body = int(numbers[0])
        self._at = Attached.at(exciter.position_m[None], numbers, drawn_m)
        self.wrench: Array = np.zeros(6)
        self._given_1_s: Array = np.zeros(3)  # r' whose force the frame got
        self._felt_m_per_s2: Array = np.zeros(3)  # the mean over the last step
        self._felt_before_m_per_s2: Array = np.zeros(3)

    def velocity_m_per_s(self, poses: Poses) -> Array:
        """Return the velocity (3,) of the shaft's place."""
        return np.asarray(self._at.motion(poses)[1][0])

    def turn(self, poses: Poses, end_s: float, step_s: float) -> Array:
        """Turn the shaft in the step from ``poses`` on, and return the change (6,) of the wrench."""
        expected_m_per_s2 = 2 * self._felt_m_per_s2 - self._felt_before_m_per_s2
        angle_rad, speed_rad_per_s = self._ahead(expected_m_per_s2, end_s, step_s)
        given_1_s = speed_rad_per_s * self.tangent(angle_rad)
        force_N = self._exciter.mass_moment_kg_m * (self._given_1_s - given_1_s) / step_s
        place_m, self._velocity_m_per_s = (rows[0] for rows in self._at.motion(poses))
        arm_m = place_m - poses.center_m[self.body]
        arm_m += step_s / 2 * (self._velocity_m_per_s - poses.velocity_m_per_s[self.body])
        before, self._given_1_s = self.wrench, given_1_s
        self.wrench = np.concatenate([force_N, np.cross(arm_m, force_N)])
        return self.wrench - before

    def feel(self, poses: Poses, end_s: float, step_s: float) -> None:
        """Accept the step to ``poses``, with the acceleration that the frame had in it."""
        gained_m_per_s = self.velocity_m_per_s(poses) - self._velocity_m_per_s
        self._felt_before_m_per_s2, self._felt_m_per_s2 = self._felt_m_per_s2, gained_m_per_s / step_s
        angle_rad, speed_rad_per_s = self._ahead(self._felt_m_per_s2, end_s, step_s)
        turned_rad = angle_rad - self.angle_rad
        self.motor_J += self._mean_torque_N_m(speed_rad_per_s, end_s, step_s) * turned_rad
        self.lost_J += self._motor.bearing_N_m_s * turned_rad**2 / step_s
        self.angle_rad, self.speed_rad_per_s = angle_rad, speed_rad_per_s

    def _ahead(self, felt_m_per_s2: Array, end_s: float, step_s: float) -> tuple[float, float]:
        """Return angle and speed at the step's end, for this mean acceleration of the shaft's place."""
        if end_s - step_s < self._exciter.start_s - 1e-9 * step_s:  # until then a brake holds the shaft
            return self.angle_rad, 0.0
        speed = self.speed_rad_per_s
        for _ in range(MOST_ROUNDS):
            mean = np.array((self.speed_rad_per_s + speed) / 2)
            torque_N_m = self._mean_torque_N_m(speed, end_s, step_s)
            growth = self.growth_rad_per_s2(
                self.angle_rad + step_s / 2 * mean, mean, np.array(torque_N_m), felt_m_per_s2
            )
            before, speed = speed, self.speed_rad_per_s + step_s * float(growth)
            if abs(speed - before) <= TOLERANCE * self._motor.synchronous_rad_per_s:
                return self.angle_rad + step_s * (self.speed_rad_per_s + speed) / 2, speed
        raise SolverFailed(
            f"exudyn frames at {end_s} s: a motor's step does not settle; take a smaller frames.step_s"
        )

    def _mean_torque_N_m(self, speed_rad_per_s: float, end_s: float, step_s: float) -> float:
        """Return the mean of the torque over a step that ends at this speed."""
        ends_s = np.array([end_s - step_s, end_s])
        return float(self.torque_N_m(np.array([self.speed_rad_per_s, speed_rad_per_s]), ends_s).mean())


class SpatialLedger(FramesLedger):
    """The ledger of trapezoidal steps since ``start``; the reaction acts on the points ``carried``."""

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
        """Return the motion of bodies in these poses."""
        velocity_m_per_s, spin_rad_per_s = poses.velocity_m_per_s[:-1], poses.spin_rad_per_s[:-1]
        body_spin = turn(poses.rotation[:-1].transpose(0, 2, 1), spin_rad_per_s)
        turning_J = np.sum(body_spin * turn(self._inertia_kg_m2, body_spin), axis=1) / 2
        return BodyMotion(velocity_m_per_s, poses.center_m[:-1] - self._drawn_m, turning_J)

    def step(self, before: Instant, after: Instant, step_s: float) -> None:
        """Add a step to the ledger.

        It adds the impulse and work that ground, driven bodies, exciters and weight gave to the free bodies,
        the losses, and the work of bushings on driven bodies.
        """
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
        """Add the reaction (n, 3) on points that moved by ``moved_m`` (n, 3) to the ledger."""
        work_J = np.sum(force_N * moved_m, axis=1)
        self.reaction_J += float(work_J.sum())
        self.pushed_J += float(work_J @ self._on_driven)
        self.outside_N_s -= length_s * force_N[self._not_free].sum(axis=0)
