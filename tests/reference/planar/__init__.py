"""Rigid bodies in the machine's vertical plane: up, along, and turning about the cross axis y.

    M q'' + C q' + K q = f(t, q, q')

with the linearised bushings on the left.  On the right are weight, exciters, reaction and the additional
forces of finite rotations, which turn arms, and spring axes with their first body.  Each step is
Gauss-Legendre collocation (``common/collocation.py``).  The right side is iterated at the stages; as only
rotations change it, it converges in one to three rounds.  With steps of  w h <= 1/2 the error is rounding, as
in ``two_mass``; and momentum and energy close to rounding.

Bodies with a drive move as prescribed.  Guides keep all bodies in the plane: what pushes across goes
into them, and so into the outside.  Equations and limits: docs/theory/frames.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from adapters.frames.common.collocation import STAGES, Collocation, tableau
from adapters.frames.common.ledger import BodyMotion, FramesLedger
from adapters.frames.common.rigid_frames import RigidFrames
from orchestrator.ports import Account, Array, Load, Motion, Pose, check_point_count, linear_frames
from orchestrator.ports.adapters import FramesAdapter, Objection
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import Cost, FramesPlan, FramesWork, SolverFailed
from tests.reference.planar.forces import Bushings, OutsideForces, PlanarShaft, Pulls
from tests.reference.planar.plane import Complex, PlanarDrive, PlanarPoses, carrying, in_space, power, wrench

PLANE = (2, 0, 4)
"""Up, along and about the cross axis, of the six coordinates of a body."""
LARGEST_STEP_RAD = 0.5
"""The angle by which the machine's fastest rate turns in a step; the error is then rounding."""
MOST_ROUNDS = 50
TOLERANCE = 1e-13
"""The largest error of a step's forces, as a share of the largest force."""
ROUNDING = 1e-15


@dataclass(frozen=True)
class Nodes:
    """The solution at the nodes of a step: the load, all bodies' poses and the bushings' pulls.

    ``load`` (nodes, freedoms) is the right side of the equations.
    """

    load: Array
    poses: PlanarPoses
    pulls: Pulls


class PlanarFrames(RigidFrames):
    """A solver of ``Frames`` that stay in the plane.

    With ``plan.step_s`` = 0 it takes the largest step without error.  Raises ValueError for unknown bodies,
    drives that make no sense or leave the plane, or bushings that cannot hold the weight.
    """

    COORDINATES = PLANE
    STATE = ("_coordinates", "_poses", "_added", "_ratio")
    _shafts: list[PlanarShaft]

    def __init__(self, plan: FramesPlan) -> None:
        self._order = np.argsort([*linear_frames.free(plan), *linear_frames.driven(plan)])
        super().__init__(free_first(plan))
        plan, drawn_m, machine = self._plan, self._drawn_m, self._machine
        driven = zip(linear_frames.driven(plan), plan.drives, strict=True)
        self._drives = [PlanarDrive(int(number), plan.bodies[number], drive) for number, drive in driven]
        self._moving = slice(0, len(self._free))  # the free bodies, which come first
        self._damping, self._stiffness = machine.damping, machine.stiffness
        self._longest_s = self._largest_step_s(LARGEST_STEP_RAD)
        self._collocation, self._ratio = Collocation(machine), 1.0
        self._carried = carrying(self._carrier, plan.points_m, drawn_m)
        self._bushings = Bushings(plan, drawn_m, self._sag_m)
        self._shafts = [
            PlanarShaft(exciter, exciter.motor, plan, drawn_m)
            for exciter in plan.exciters
            if exciter.motor is not None
        ]
        self._inertia = np.full((len(plan.bodies), 3), np.inf)  # driven bodies feel nothing
        self._inertia[self._moving] = np.diag(machine.mass).reshape(-1, 3)
        self._forces = OutsideForces(plan, drawn_m, self._carried)
        self._coordinates = self._driven_at(np.zeros(1))
        self._poses = PlanarPoses.of(*self._coordinates)
        self._added = np.zeros((STAGES, self._sag.size))  # by finite rotations, at the last step's nodes
        self._onward = onward()
        self._spun_kg_m2 = np.array([body.inertia_kg_m2[1, 1] for body in plan.bodies])
        self._into_outside = np.ones((len(self._carrier), 3))
        self._into_outside[np.isin(self._carrier, self._free)] = [0.0, 1.0, 0.0]
        self._ledger = FramesLedger(plan, self._bodies())

    def initial(self) -> Motion:
        return self._moved()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        check_point_count("frames' reaction", reaction, len(self._plan.points_m))
        steps = interval.steps(self._longest_s)
        self._collocation.set_step(interval.length_s / steps)
        on_bodies, before = self._forces.reaction(reaction.force_N), self._poses.place[0]
        for step in range(steps):
            self._step(interval.start_s + step * self._collocation.step_s, on_bodies)
        work_J = power(on_bodies, self._poses.place[0] - before).reshape(2, -1).sum(axis=0)
        ledger = self._ledger
        ledger.reaction_J += float(work_J.sum())
        ledger.pushed_J += float(work_J[self._moving.stop :].sum())
        ledger.outside_N_s -= interval.length_s * (reaction.force_N * self._into_outside).sum(axis=0)
        return self._moved()

    def pose(self) -> Pose:
        moved, order = self._bodies(), self._order
        turn, spin_rad_per_s = self._poses.turn[0, order], self._poses.spin_rad_per_s[0, order]
        rotation = np.zeros((len(order), 3, 3))
        rotation[:, 0, 0] = rotation[:, 2, 2] = turn.real
        rotation[:, 0, 2], rotation[:, 2, 0], rotation[:, 1, 1] = turn.imag, -turn.imag, 1.0
        return Pose(
            (self._drawn_m + moved.moved_m)[order],
            rotation,
            moved.velocity_m_per_s[order],
            np.outer(spin_rad_per_s, [0.0, 1.0, 0.0]),
        )

    def account(self) -> Account:
        elastic_J = self._bushings.elastic_J(self._bushings.pulls(self._poses))
        elastic_J += self._elements.stored_J()
        shafts = [(shaft, shaft.velocity_m_per_s(self._poses)) for shaft in self._shafts]
        return self._ledger.account(self._bodies(), elastic_J, shafts)

    def _step(self, start_s: float, reaction: Complex) -> None:
        time_s = start_s + self._collocation.node_s
        exciter_N = self._forces.exciter_N(time_s)
        nodes = self._nodes(start_s, self._forces.given(exciter_N, reaction))
        self._book(nodes, exciter_N, reaction)
        for shaft in self._shafts:
            shaft.end(self._collocation.weight_s)
        coordinates = self._driven_at(np.array([start_s + self._collocation.step_s]))
        x, v = self._freedoms()
        ends = self._collocation.end(x, v, nodes.load)
        coordinates[:, 0, self._moving] = np.reshape(ends, (2, -1, 3))
        self._coordinates, self._poses = coordinates, PlanarPoses.of(*coordinates)

    def _nodes(self, start_s: float, given: Complex) -> Nodes:
        """Solve the collocation's equations in rounds.

        Each round shrinks the remaining error by the share that finite rotations have in the bushings'
        forces, times (step w)^2.

        The error after a round is  q / (1 - q)  times its change, with q the last ratio of changes; before
        there is one, it is the ratio of the last step to the power 0.8, which forgets it slowly (Hairer and
        Wanner, Solving Ordinary Differential Equations II, 2nd ed. 1996, section IV.8).
        """
        x, v = self._freedoms()
        time_s, step_s = start_s + self._collocation.node_s, self._collocation.step_s
        elements = bool(self._elements)
        coordinates = self._driven_at(time_s)
        ahead = np.exp(1j * self._poses.spin_rad_per_s * self._collocation.node_s[:, None])
        expected = wrench(given, self._poses.turn * ahead)[:, self._moving].reshape(len(time_s), -1)
        load = expected + self._onward @ self._added
        self._ratio, change_before = max(self._ratio, ROUNDING) ** 0.8, math.inf
        for _ in range(MOST_ROUNDS):
            xs, vs = self._collocation.stages(x, v, load)
            coordinates[:, :, self._moving] = np.reshape((xs, vs), (2, len(time_s), -1, 3))
            poses = PlanarPoses.of(*coordinates)
            element_N = self._elements.mean_N(self._moved_apart_m(poses), step_s) if elements else None
            pulls = self._bushings.pulls(poses, element_N)
            force = given + pulls.force
            for shaft in self._shafts:
                force = force + shaft.force(self._collocation, start_s)
            total = wrench(force, poses.turn)
            total[..., 2] += pulls.couple_N_m
            for shaft in self._shafts:
                shaft.feel(self._acceleration(poses, total))
            before, load = load, total[:, self._moving].reshape(xs.shape) + self._linear(xs, vs)
            size = np.abs(load).max(initial=0.0) + np.abs(pulls.pull_N).max(initial=0.0)
            change = np.abs(load - before).max(initial=0.0)
            if 0.0 < change_before < math.inf:
                self._ratio = change / change_before
            change_before = change
            left = change * self._ratio / (1 - self._ratio) if self._ratio < 1 else math.inf
            if change == 0 or left <= TOLERANCE * size:
                self._added = load - expected
                return Nodes(load, poses, pulls)
        raise SolverFailed(
            f"planar frames at {start_s:.6g} s: its rounds do not end; take a smaller frames.step_s"
        )

    def _acceleration(self, poses: PlanarPoses, total: Array) -> Complex:
        """Return the acceleration of the natural coordinates, (nodes, 2 bodies); 0 for driven bodies."""
        share = total / self._inertia
        return poses.acceleration(share[..., 0] + 1j * share[..., 1], share[..., 2])

    def _linear(self, xs: Array, vs: Array) -> Array:
        """Return the bushings' load by the left side of the equations, (nodes, freedoms)."""
        return np.asarray(xs @ self._stiffness + vs @ self._damping)

    def _book(self, nodes: Nodes, exciter_N: Complex, reaction: Complex) -> None:
        """Book a step: its momentum by the forces of its own equations, and its energies."""
        x, v = self._freedoms()
        xs, vs = self._collocation.stages(x, v, nodes.load)
        force_N = (nodes.load - self._linear(xs, vs)).reshape(len(xs), -1, 3).sum(axis=1)
        driven_W = np.zeros(len(xs))
        for drive in self._drives:
            driven_W += self._bushings.work_W(nodes.poses, nodes.pulls, drive.body)
        weight_s, ledger = self._collocation.weight_s, self._ledger
        outside_N = force_N[:, 0] + 1j * force_N[:, 1] - reaction[self._moving].sum()
        ledger.outside_N_s += in_space(np.asarray(weight_s @ outside_N))
        ledger.damping_J += float(weight_s @ self._bushings.lost_W(nodes.poses, nodes.pulls))
        ledger.exciter_J += float(weight_s @ self._forces.exciter_W(nodes.poses, exciter_N))
        ledger.pushed_J += float(weight_s @ driven_W)
        if self._elements:
            moved_m = self._moved_apart_m(nodes.poses)
            ledger.damping_J += self._elements.accept(moved_m, self._collocation.step_s)

    def _moved_apart_m(self, poses: PlanarPoses) -> Array:
        """Return how far the ends of the bushings move apart along their axes in a step, (bushings, 3)."""
        return self._bushings.moved_m(poses, self._collocation.weight_s)

    def _bodies(self) -> BodyMotion:
        poses = self._poses
        turning_J = self._spun_kg_m2 * poses.spin_rad_per_s[0] ** 2 / 2
        return BodyMotion(in_space(poses.velocity_m_per_s[0]), in_space(poses.moved_m[0]), turning_J)

    def _freedoms(self) -> Array:
        """Return coordinates of the free bodies, and their rates: (2, freedoms)."""
        return self._coordinates[:, 0, self._moving].reshape(2, -1)

    def _driven_at(self, time_s: Array) -> Array:
        """Return places and rates of driven bodies, (2, times, bodies, 3); they are zero for other bodies."""
        coordinates = np.zeros((2, len(time_s), len(self._plan.bodies), 3))
        for drive in self._drives:
            coordinates[:, :, drive.body] = drive.coordinates(time_s)
        return coordinates

    def _moved(self) -> Motion:
        poses = self._poses
        position_m = self._plan.points_m + in_space((poses.place @ self._carried)[0])
        return Motion(position_m, in_space((poses.rate @ self._carried)[0]))


build = PlanarFrames


def free_first(plan: FramesPlan) -> FramesPlan:
    """Return the same machine with its driven bodies last, in the order of the drives."""
    order = [*linear_frames.free(plan), *linear_frames.driven(plan)]
    return replace(plan, bodies=tuple(plan.bodies[number] for number in order))


def onward() -> Array:
    """Return the matrix (stages, stages) that extrapolates values at a step's nodes to the next step's nodes.

    It uses the parabola that fits best.
    """
    node, _, _ = tableau()
    fitted = np.linalg.pinv(np.vander(node, 3))
    return np.asarray(np.vander(node + 1, 3) @ fitted)


def objections(plan: FramesPlan) -> Iterator[Objection]:
    """Yield objections to drives out of the vertical plane, and to motors' shafts that are not across it."""
    for drive in plan.drives:
        if any((drive.amplitude_m[1], drive.rotation_rad[0], drive.rotation_rad[2])):
            what = "leaves the vertical plane, to which frames.solver planar is bound"
            hint = 'frames.solver = "exudyn" has no such bounds'
            yield Objection(what, hint, ("screen", "frames", drive.body, "drive"))
    for exciter in plan.exciters:
        if exciter.motor is not None and (exciter.axis[0] or exciter.axis[2]):
            what = "turns a shaft that is not across the deck, which planar frames know alone"
            hint = 'axis = [0, 1, 0], or frames.solver = "exudyn"'
            yield Objection(what, hint, ("screen", "exciters", exciter.name, "motor"))


def cost(work: FramesWork) -> Cost:
    """Return the measured time of a call in each interval; motors add iterations in each step."""
    return Cost(0.02, work.runs * (2.4e-4 + 6e-4 * work.motors))


ADAPTER = FramesAdapter(
    about="rigid bodies in the vertical plane, free or driven",
    build=build,
    cost=cost,
    objections=objections,
    fidelity=2,
)
