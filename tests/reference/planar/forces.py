"""The forces on bodies in the plane: bushings, exciters, shafts, weight and the panels' reaction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.frames.common.collocation import STAGES, Collocation, tableau
from adapters.frames.common.exciter import Shaft
from adapters.frames.common.rigid_frames import BushingTable, Unbalances, onto_bodies
from orchestrator.ports import Array, linear_frames
from orchestrator.ports.plans import ExciterPlan, FramesPlan, MotorPlan
from tests.reference.planar.plane import Complex, PlanarPoses, Symmetric, carrying, in_plane, in_space, power


@dataclass(frozen=True)
class Pulls:
    """The deformations and forces of bushings, (times, bushings) each.

    ``stretch_m`` and its rate are between the ends of a bushing; ``elongation_m`` is along the axes as drawn,
    with preload.  ``drag_N`` is the force of damping, and ``pull_N`` the whole force on the first body.
    ``force`` (times, 2 bodies) acts on the natural coordinates of the bodies, and ``couple_N_m`` (times,
    bodies) is their couple.
    """

    stretch_m: Complex
    stretch_m_per_s: Complex
    elongation_m: Complex
    drag_N: Complex
    pull_N: Complex
    force: Complex
    couple_N_m: Array


class Bushings:
    """The bushings, each stretched along its axes by ``sag_m`` (bushings, 3) as drawn."""

    def __init__(self, plan: FramesPlan, drawn_m: Array, sag_m: Array) -> None:
        table = BushingTable(plan)
        self._stretching = carrying(table.second, table.place_m, drawn_m)
        self._stretching -= carrying(table.first, table.place_m, drawn_m)
        self._first = onto_bodies(plan, table.first)
        self._on_ground = np.asarray(table.first < 0, dtype=np.float64)
        back = table.axes.transpose(0, 2, 1)
        self._preload_m = in_plane((back @ sag_m[:, :, None])[:, :, 0])
        self._stiffness = Symmetric.of(back @ (table.stiffness_N_per_m[:, :, None] * table.axes))
        self._damping = Symmetric.of(back @ (table.damping_N_s_per_m[:, :, None] * table.axes))
        self._axes = table.axes

    def moved_m(self, poses: PlanarPoses, weight_s: Array) -> Array:
        """Return how far the ends of the bushings move apart along the axes, (bushings, 3).

        The bodies have these poses at the nodes of a step, with the weights ``weight_s``.
        """
        turn = poses.turn @ self._first + self._on_ground
        turning_m_per_s = 1j * (poses.spin_rad_per_s @ self._first) * (poses.place @ self._stretching)
        moved_m: Complex = weight_s.astype(np.complex128) @ (
            turn.conj() * (poses.rate @ self._stretching - turning_m_per_s)
        )
        return np.asarray((self._axes @ in_space(moved_m)[:, :, None])[:, :, 0])

    def pulls(self, poses: PlanarPoses, element_N: Array | None = None) -> Pulls:
        """Return the pulls of the bushings between bodies in these poses.

        ``element_N`` (bushings, 3) are forces along the axes that act beside springs and dampers.

        The spring axes turn with the first body, which therefore gets the couple stretch x pull, too, so
        that no moment is lost between the ends.
        """
        turn = poses.turn @ self._first + self._on_ground
        stretch_m, stretch_m_per_s = poses.place @ self._stretching, poses.rate @ self._stretching
        back = turn.conj()
        elongation_m = back * stretch_m + self._preload_m
        drag_N = turn * self._damping.times(back * stretch_m_per_s)
        pull_N = turn * self._stiffness.times(elongation_m) + drag_N
        if element_N is not None:
            pull_N += turn * in_plane((element_N[:, None] @ self._axes)[:, 0])
        force = -pull_N @ self._stretching.conj().T
        couple_N_m = (stretch_m.conj() * pull_N).imag @ self._first.T
        return Pulls(stretch_m, stretch_m_per_s, elongation_m, drag_N, pull_N, force, couple_N_m)

    def lost_W(self, poses: PlanarPoses, pulls: Pulls) -> Array:
        """Return the power lost in W, (times,), by damping forces on elongations along the turning axes."""
        turning_m_per_s = 1j * (poses.spin_rad_per_s @ self._first) * pulls.stretch_m
        return np.asarray(power(pulls.drag_N, pulls.stretch_m_per_s - turning_m_per_s).sum(axis=1))

    def work_W(self, poses: PlanarPoses, pulls: Pulls, body: int) -> Array:
        """Return the power of the bushings on one body in W, (times,)."""
        both = [body, body + poses.turn.shape[1]]
        pushed_W = power(pulls.force[:, both], poses.rate[:, both]).sum(axis=1)
        return np.asarray(pushed_W + pulls.couple_N_m[:, body] * poses.spin_rad_per_s[:, body])

    def elastic_J(self, pulls: Pulls) -> float:
        """Return the elastic energy in the bushings at one time in J."""
        elongation_m = pulls.elongation_m
        return float(power(self._stiffness.times(elongation_m), elongation_m).sum()) / 2


class OutsideForces:
    """The forces on the natural coordinates, apart from bushings and unbalances with motors.

    ``carried`` (2 bodies, n) are the displacements, per coordinate, of the points on which the reaction acts.
    """

    def __init__(self, plan: FramesPlan, drawn_m: Array, carried: Complex) -> None:
        exciters = [exciter for exciter in plan.exciters if exciter.motor is None]
        self._unbalances = Unbalances(plan, exciters)
        self._excited = carrying(self._unbalances.body, self._unbalances.place_m, drawn_m)
        mass_kg = np.array([body.mass_kg for body in plan.bodies])
        self._weight = np.concatenate([mass_kg * in_plane(plan.gravity_m_per_s2), 0 * mass_kg])
        self._onto_bodies = carried.conj().T

    def exciter_N(self, time_s: Array) -> Complex:
        """Return the exciters' forces, (times, exciters)."""
        return in_plane(self._unbalances.force_N(time_s))

    def reaction(self, force_N: Array) -> Complex:
        """Return the force (2 bodies,) on the natural coordinates of forces (n, 3) on the carried points."""
        return np.asarray(in_plane(force_N) @ self._onto_bodies)

    def given(self, exciter_N: Complex, reaction: Complex) -> Complex:
        """Return the forces (times, 2 bodies) that do not depend on the places of the bodies."""
        return np.asarray(exciter_N @ self._excited.conj().T + (reaction + self._weight))

    def exciter_W(self, poses: PlanarPoses, exciter_N: Complex) -> Array:
        """Return the exciters' power, (times,)."""
        return np.asarray(power(exciter_N, poses.rate @ self._excited).sum(axis=1))


class PlanarShaft(Shaft):
    """A shaft across the plane, at the nodes of the frames' own collocation.

    In each round of the frames' iteration, ``force`` and then ``feel`` are called, and ``end`` when the step
    is accepted.  Raises ValueError for a shaft that does not lie across.
    """

    STATE = (*Shaft.STATE, "_felt_m_per_s2", "_growth_rad_per_s2")

    def __init__(self, exciter: ExciterPlan, motor: MotorPlan, plan: FramesPlan, drawn_m: Array) -> None:
        if abs(exciter.axis[1]) < 1 - 1e-12:
            raise ValueError("a motor's shaft must lie across, along y, where frames are planar")
        super().__init__(exciter, motor, plan)
        body = linear_frames.numbers(plan, (exciter.body,))
        self._at = carrying(body, exciter.position_m[None], drawn_m)[:, 0]  # per natural coordinate
        self._felt_m_per_s2, self._growth_rad_per_s2 = np.zeros((STAGES, 3)), np.zeros(STAGES)
        _, _, self._integral = tableau()

    def force(self, collocation: Collocation, start_s: float) -> Complex:
        """Return the force on the natural coordinates, (nodes, 2 bodies)."""
        time_s, integral_s = start_s + collocation.node_s, collocation.step_s * self._integral
        turns = time_s >= self._exciter.start_s  # until then a brake holds the shaft
        speed = self.speed_rad_per_s + integral_s @ self._growth_rad_per_s2
        angle = self.angle_rad + integral_s @ speed
        torque = turns * self.torque_N_m(speed, time_s)
        growth = turns * self.growth_rad_per_s2(angle, speed, torque, self._felt_m_per_s2)
        self._speed_rad_per_s, self._growth_rad_per_s2, self._torque_N_m = speed, growth, torque
        return np.outer(in_plane(self.inertia_force_N(angle, speed, growth)), self._at.conj())

    def feel(self, acceleration: Complex) -> None:
        """Take over the acceleration of the natural coordinates, (nodes, 2 bodies), from the frames."""
        self._felt_m_per_s2 = in_space(acceleration @ self._at)

    def end(self, weight_s: Array) -> None:
        """Accept the step, whose nodes have the weights ``weight_s``."""
        speed = self._speed_rad_per_s
        self.angle_rad += float(weight_s @ speed)
        self.speed_rad_per_s += float(weight_s @ self._growth_rad_per_s2)
        self.motor_J += float(weight_s @ (self._torque_N_m * speed))
        self.lost_J += self._motor.bearing_N_m_s * float(weight_s @ speed**2)

    def velocity_m_per_s(self, poses: PlanarPoses) -> Array:
        """Return the velocity (3,) of the shaft's place, at one time."""
        return in_space((poses.rate @ self._at)[0])
