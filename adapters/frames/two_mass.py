"""Translating bodies on bushings: linear equations, integrated to rounding.

    M x'' + C x' + K x = weight + reaction + exciters

for any number of bodies, without rotations.  Each step is Gauss-Legendre collocation
(``common/collocation.py``) with  w h <= 1.  Gap springs add their mean force over the step on the right,
which is iterated; the error is then of second order in the step (an exponential integrator with a discrete
gradient: Li and Wu, SIAM Journal on Scientific Computing 38, 2016, A1876-A1895, doi 10.1137/15M1023257).

A machine drawn at rest starts with its bushings stretched by the static sag, so that they carry
weight and initial reaction: nothing moves before an exciter starts.  What is integrated is the
displacement since then, under what the loads differ from those: soft springs sag by metres, and
stiff ones beside them would turn the rounding of metres into forces.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from adapters.frames.common.collocation import Collocation
from adapters.frames.common.drive import drawn_pose
from adapters.frames.common.ledger import BodyMotion, FramesLedger
from adapters.frames.common.rigid_frames import BushingTable, RigidFrames, Unbalances, onto_bodies
from orchestrator.ports import Account, Array, Load, Motion, Pose, check_point_count, linear_frames
from orchestrator.ports.adapters import FramesAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import FrameLoads
from orchestrator.ports.plans import Cost, FramesPlan, FramesWork, SolverFailed

LARGEST_STEP_RAD = 1.0
"""Of the machine's fastest rate: agrees with the closed form to rounding."""
MOST_ROUNDS = 50
TOLERANCE = 1e-14
"""Largest change of a step's load in the last round, as a share of the load."""


class TwoMassFrames(RigidFrames):
    """``Frames`` that translate; ``plan.step_s`` = 0 takes the largest step without error.

    Raises ValueError for drives, unknown bodies, and bushings with measured curves or that cannot hold the
    weight.
    """

    COORDINATES = linear_frames.TRANSLATIONS
    STATE = ("_displacement_m", "_velocity_m_per_s")

    def __init__(self, plan: FramesPlan) -> None:
        if plan.drives:
            raise ValueError(
                f"two_mass moves bodies by forces; the drive of {plan.drives[0].body!r} needs exudyn "
                "or, where every body is driven, prescribed"
            )
        if any(bushing.hysteresis for bushing in plan.bushings):
            raise ValueError("two_mass has linear bushings; measured curves need exudyn")
        super().__init__(plan)
        self._unbalances, self._bushings = Unbalances(plan, plan.exciters), BushingTable(plan)
        self._onto_excited = onto_bodies(plan, self._unbalances.body)
        self._onto_bodies = onto_bodies(plan, self._carrier)
        weight_N = np.outer([body.mass_kg for body in plan.bodies], plan.gravity_m_per_s2)
        self._unheld_N = weight_N - self._held.reshape(-1, 3)
        self._displacement_m, self._velocity_m_per_s = np.zeros((2, len(self._held)))
        self._ended_s, self._reaction_N = 0.0, np.zeros((len(plan.bodies), 3))  # of the last interval
        self._longest_s = self._largest_step_s(LARGEST_STEP_RAD)
        machine = self._machine
        self._collocation, self._damping = Collocation(machine), machine.damping
        to_ground = [bushing.bodies.count("ground") == 1 for bushing in plan.bushings]
        ground = np.repeat(np.array(to_ground, dtype=bool), 3)[:, None]
        spring_N, damper_N = (
            machine.stretch.T @ (ground * per_axis[:, None] * machine.stretch)
            for per_axis in (machine.stiffness_N_per_m, machine.damping_N_s_per_m)
        )
        self._ground_stiffness, self._ground_damping = spring_N, damper_N
        self._ground_stretch = ground * machine.stretch
        self._ledger = FramesLedger(plan, self._bodies())

    def initial(self) -> Motion:
        return self._carried()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        check_point_count("frames' reaction", reaction, len(self._carrier))
        steps = interval.steps(self._longest_s)
        self._collocation.set_step(interval.length_s / steps)
        reaction_N = self._onto_bodies @ reaction.force_N
        self._ended_s, self._reaction_N = interval.start_s + interval.length_s, reaction_N
        before_m = self._displacement_m
        for step in range(steps):
            self._step(interval.start_s + step * self._collocation.step_s, reaction_N)
        ledger, outside = self._ledger, self._carrier < 0
        ledger.reaction_J += float(reaction_N.ravel() @ (self._displacement_m - before_m))
        ledger.outside_N_s -= interval.length_s * reaction.force_N[outside].sum(axis=0)
        return self._carried()

    def pose(self) -> Pose:
        drawn, moved = drawn_pose(self._plan), self._bodies()
        position_m = drawn.position_m + moved.moved_m
        return replace(drawn, position_m=position_m, velocity_m_per_s=moved.velocity_m_per_s)

    def loads(self) -> FrameLoads:
        machine, moved = self._machine, np.vstack([self._bodies().moved_m, np.zeros(3)])
        x_m, v_m_per_s = self._displacement_m, self._velocity_m_per_s
        along_N = machine.stiffness_N_per_m * (machine.stretch @ (self._sag + x_m))
        along_N += machine.damping_N_s_per_m * (machine.stretch @ v_m_per_s)
        along_N += (element_N := self._elements.force_N.ravel())
        exciter_N = self._unbalances.force_N(np.array([self._ended_s]))[0]
        load_N = (self._onto_excited @ exciter_N + self._reaction_N + self._unheld_N).ravel()
        load_N -= machine.stiffness @ x_m + machine.damping @ v_m_per_s + machine.stretch.T @ element_N
        acceleration = np.linalg.solve(machine.mass, load_N).reshape(-1, 3)
        table = self._bushings
        return FrameLoads(
            bushing_N=np.einsum("nij,ni->nj", table.axes, along_N.reshape(-1, 3)),
            bushing_m=table.place_m + moved[table.second],
            exciter_N=exciter_N,
            exciter_m=self._unbalances.place_m + moved[self._unbalances.body],
            lag_N_m=np.zeros_like(acceleration),
            acceleration_m_per_s2=acceleration,
            angular_acceleration_rad_per_s2=np.zeros_like(acceleration),
        )

    def account(self) -> Account:
        stretch_m = self._machine.stretch @ (self._sag + self._displacement_m)
        elastic_J = float(self._machine.stiffness_N_per_m @ stretch_m**2) / 2
        return self._ledger.account(self._bodies(), elastic_J + self._elements.stored_J())

    def _step(self, start_s: float, reaction_N: Array) -> None:
        collocation, state = self._collocation, (self._displacement_m, self._velocity_m_per_s)
        exciter_N = self._onto_excited @ self._unbalances.force_N(start_s + collocation.node_s)
        load_N = exciter_N + (reaction_N + self._unheld_N)
        if self._elements:
            load_N = self._beside_elements(start_s, load_N)
        self._book(exciter_N, *collocation.stages(*state, load_N))
        self._displacement_m, self._velocity_m_per_s = collocation.end(*state, load_N)

    def _beside_elements(self, start_s: float, load_N: Array) -> Array:
        """Return the load of a step with the mean force of the elements, and take them to its end."""
        collocation, state = self._collocation, (self._displacement_m, self._velocity_m_per_s)
        stretch, step_s, given_N = self._machine.stretch, collocation.step_s, load_N
        for _ in range(MOST_ROUNDS):
            moved_m = (stretch @ (collocation.end(*state, load_N)[0] - state[0])).reshape(-1, 3)
            element_N = self._elements.mean_N(moved_m, step_s).ravel()
            before_N, load_N = load_N, given_N - (stretch.T @ element_N).reshape(-1, 3)
            if np.abs(load_N - before_N).max() <= TOLERANCE * (
                np.abs(load_N).max() + np.abs(element_N).max()
            ):
                self._elements.accept(moved_m, step_s)
                impulse_N_s = step_s * (self._ground_stretch.T @ element_N).reshape(-1, 3).sum(axis=0)
                self._ledger.outside_N_s -= impulse_N_s
                return load_N
        raise SolverFailed(
            f"two_mass at {start_s:.6g} s: its rounds do not end; take a smaller frames.step_s"
        )

    def _book(self, exciter_N: Array, x_m: Array, v_m_per_s: Array) -> None:
        """Book impulse from outside, work and loss of one step, by the collocation's own weights."""
        weight_s, ledger = self._collocation.weight_s, self._ledger
        ground_N = -(x_m @ self._ground_stiffness + v_m_per_s @ self._ground_damping)
        # the ground holds the bodies at rest
        outside_N = (exciter_N + ground_N.reshape(exciter_N.shape) + self._unheld_N).sum(axis=1)
        ledger.outside_N_s += weight_s @ outside_N
        ledger.damping_J += float(weight_s @ np.sum(v_m_per_s * (v_m_per_s @ self._damping), axis=1))
        power_W = np.sum(exciter_N.reshape(v_m_per_s.shape) * v_m_per_s, axis=1)
        ledger.exciter_J += float(weight_s @ power_W)

    def _bodies(self) -> BodyMotion:
        velocity_m_per_s = self._velocity_m_per_s.reshape(-1, 3)
        still_J = np.zeros(len(velocity_m_per_s))
        return BodyMotion(velocity_m_per_s, self._displacement_m.reshape(-1, 3), still_J)

    def _carried(self) -> Motion:
        """Return the motion of the points; the ground is the last row."""
        moved_m, velocity_m_per_s = (
            np.vstack([each.reshape(-1, 3), np.zeros(3)])[self._carrier]
            for each in (self._displacement_m, self._velocity_m_per_s)
        )
        return Motion(self._plan.points_m + moved_m, velocity_m_per_s)


build = TwoMassFrames


def cost(work: FramesWork) -> Cost:
    """Return the time of a call in each interval."""
    return Cost(0.01, work.runs * 8.5e-5)


ADAPTER = FramesAdapter(
    about="translations to rounding, without rotation and drives",
    build=build,
    cost=cost,
    leaves_out={
        "frame-rotation": "frames translate only",
        "motor-slip": "shafts turn at their speed_rad_per_s",
        "bushing-hysteresis": "each bushing has one stiffness and one damping",
    },
    drives=False,
    rotates=False,
    motors=False,
    hysteresis=False,
    fidelity=1,
)
