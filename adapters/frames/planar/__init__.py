"""Rigid bodies in the machine's vertical plane: up, along, and turning about the cross axis y.

    M q'' + C q' + K q = f(t, q, q')

with the linearised bushings on the left and, on the right, weight, exciters, reaction and all
that finite rotations add: arms that turn, spring axes that turn with their first body.  Each
step is Gauss-Legendre collocation with six stages (order 12; Hairer, Lubich, Wanner, Geometric
Numerical Integration, 2nd ed. 2006, section II.1.3).  The right side is iterated at the stages;
as only rotations change it, it converges in one to three rounds.  With steps of  w h <= 1/2  the
error is rounding, as in ``two_mass``; and momentum and energy close to rounding.

Bodies with a drive move as prescribed.  Equations and limits: docs/theory/frames.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.collocation import STAGES, Gauss, gauss, onward
from adapters.frames.common.drive import DrivenPoints
from adapters.frames.planar.books import Books, Step
from adapters.frames.planar.drive import planar_drives
from adapters.frames.planar.forces import Bushings, Forces, Pulls
from adapters.frames.planar.plane import Complex, Poses, carrying, in_space, wrench
from adapters.frames.planar.rounds import Rounds
from adapters.frames.planar.shaft import shafts
from orchestrator.ports import Account, Array, Known, Load, Motion, Saved, counted
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import FramesPlan, SolverFailed
from orchestrator.ports.state import put_back, taken

_STATE = ("_coordinates", "_poses", "_added")
LARGEST_STEP = 0.5
"""In 1 / rad, times the fastest rate of the machine."""
MOST_ROUNDS = 50
TOLERANCE = 1e-13
"""Of the largest force: what a step's forces may get wrong."""


def build(plan: FramesPlan) -> PlanarFrames:
    """Raises ValueError for unknown bodies, drives that make no sense or leave the plane, or
    bushings that cannot hold the weight.  ``plan.step_s`` = 0 takes the largest step without
    error."""
    return PlanarFrames(plan)


@dataclass(frozen=True)
class Nodes:
    """At the nodes of a step: ``load`` (nodes, freedoms), the equations' right side, all bodies'
    poses and the bushings' pulls."""

    load: Array
    poses: Poses
    pulls: Pulls


class PlanarFrames:
    """``Frames`` that stay in the plane."""

    def __init__(self, plan: FramesPlan) -> None:
        self._plan = plan = linear.free_first(plan)
        self._drives, self._driven_points = planar_drives(plan), DrivenPoints(plan)
        self._free = slice(0, len(linear.free(plan)))
        machine = linear.linearised(plan, linear.PLANE)
        self._mass, self._damping = machine.mass, machine.damping
        self._stiffness = machine.stiffness
        self._largest_step_s = _largest_step_s(plan, machine)
        self._step_s, self._rounds = 0.0, Rounds(TOLERANCE)
        sag = np.zeros(len(machine.mass))
        if plan.drawn_at_rest:
            load = linear.resting_load(plan)[:, linear.PLANE].ravel()
            sag = machine.sag(load, linear.in_play_N(plan))
        drawn_m = np.array([body.center_of_mass_m for body in plan.bodies])
        carrier = linear.numbers(plan, plan.carrier)
        self._carried = carrying(carrier, plan.points_m, drawn_m)
        self._bushings = Bushings(plan, drawn_m, (machine.stretch @ sag).reshape(-1, 3))
        self._shafts = shafts(plan, drawn_m)
        self._inertia = np.full((len(plan.bodies), 3), np.inf)  # driven bodies feel nothing
        self._inertia[self._free] = np.diag(machine.mass).reshape(-1, 3)
        self._forces = Forces(plan, drawn_m, self._carried)
        self._coordinates = self._driven_at(np.zeros(1))
        self._poses = Poses.of(*self._coordinates)
        self._added = np.zeros((STAGES, sag.size))  # by finite rotations, at the last step's nodes
        self._onward = onward()
        self._books = Books(plan, carrier, self._poses)

    def initial(self) -> Motion:
        return self._moved()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        counted("frames' reaction", reaction, len(self._plan.points_m))
        steps = interval.steps(self._largest_step_s)
        self._prepare(interval.length_s / steps)
        on_bodies, before = self._forces.reaction(reaction.force_N), self._poses.place[0]
        for step in range(steps):
            self._step(interval.start_s + step * self._step_s, on_bodies)
        moved = self._poses.place[0] - before
        self._books.interval(reaction.force_N, on_bodies, moved, interval.length_s)
        return self._moved()

    def ahead(self, interval: Interval) -> Known | None:
        return self._driven_points.ahead(interval)

    def account(self) -> Account:
        elastic_J = self._bushings.elastic_J(self._bushings.pulls(self._poses))
        return self._books.account(self._poses, elastic_J, self._shafts)

    def save(self) -> Saved:
        ratio = np.array(self._rounds.ratio)
        turning = {str(number): shaft.save() for number, shaft in enumerate(self._shafts)}
        return taken(self, *_STATE) | {"ratio": ratio, "books": self._books.save(), "shafts": turning}

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_STATE)
        self._rounds.ratio = float(saved["ratio"])
        self._books.restore(saved["books"])
        for number, shaft in enumerate(self._shafts):
            shaft.restore(saved["shafts"][str(number)])

    def close(self) -> None:
        pass

    def _prepare(self, step_s: float) -> None:
        """The collocation's matrices for this step length."""
        if step_s != self._step_s:
            self._step_s = step_s
            self._gauss: Gauss = gauss(self._mass, self._damping, self._stiffness, step_s)

    def _step(self, start_s: float, reaction: Complex) -> None:
        time_s = start_s + self._gauss.node_s
        exciter_N = self._forces.exciter_N(time_s)
        nodes = self._nodes(start_s, self._forces.given(exciter_N, reaction))
        self._book(nodes, exciter_N, reaction)
        for shaft in self._shafts:
            shaft.end(self._gauss)
        coordinates = self._driven_at(np.array([start_s + self._step_s]))
        x, v = self._freedoms()
        ends = self._gauss.end(x, v, nodes.load)
        coordinates[:, 0, self._free] = np.reshape(ends, (2, -1, 3))
        self._coordinates, self._poses = coordinates, Poses.of(*coordinates)

    def _nodes(self, start_s: float, given: Complex) -> Nodes:
        """The collocation's equations, solved in rounds: each shrinks what the last got wrong
        by the share that finite rotations have in the bushings' forces, times (step w)^2."""
        x, v = self._freedoms()
        time_s = start_s + self._gauss.node_s
        coordinates = self._driven_at(time_s)
        ahead = np.exp(1j * self._poses.spin_rad_per_s * self._gauss.node_s[:, None])
        expected = wrench(given, self._poses.turn * ahead)[:, self._free].reshape(len(time_s), -1)
        load = expected + self._onward @ self._added
        self._rounds.begin()
        for _ in range(MOST_ROUNDS):
            xs, vs = self._gauss.stages(x, v, load)
            coordinates[:, :, self._free] = np.reshape((xs, vs), (2, len(time_s), -1, 3))
            poses = Poses.of(*coordinates)
            pulls = self._bushings.pulls(poses)
            force = given + pulls.force
            for shaft in self._shafts:
                force = force + shaft.force(self._gauss, start_s)
            total = wrench(force, poses.turn)
            total[..., 2] += pulls.couple_N_m
            for shaft in self._shafts:
                shaft.feel(self._acceleration(poses, total))
            before, load = load, total[:, self._free].reshape(xs.shape) + self._linear(xs, vs)
            size = np.abs(load).max(initial=0.0) + np.abs(pulls.pull_N).max(initial=0.0)
            if self._rounds.settled(np.abs(load - before).max(initial=0.0), size):
                self._added = load - expected
                return Nodes(load, poses, pulls)
        raise SolverFailed(
            f"planar frames at {start_s} s: its rounds do not end; take a smaller frames.step_s"
        )

    def _acceleration(self, poses: Poses, total: Array) -> Complex:
        """Of the natural coordinates of free bodies, (nodes, 2 bodies); 0 for driven ones."""
        share = total / self._inertia
        return poses.acceleration(share[..., 0] + 1j * share[..., 1], share[..., 2])

    def _linear(self, xs: Array, vs: Array) -> Array:
        """What the left side of the equations says of the bushings, (nodes, freedoms)."""
        return np.asarray(xs @ self._stiffness + vs @ self._damping)

    def _book(self, nodes: Nodes, exciter_N: Complex, reaction: Complex) -> None:
        """Momentum by the forces of the step's own equations."""
        x, v = self._freedoms()
        xs, vs = self._gauss.stages(x, v, nodes.load)
        force_N = (nodes.load - self._linear(xs, vs)).reshape(len(xs), -1, 3).sum(axis=1)
        driven_W = np.zeros(len(xs))
        for drive in self._drives:
            driven_W += self._bushings.work_W(nodes.poses, nodes.pulls, drive.body)
        self._books.step(
            Step(
                self._gauss.weight_s,
                force_N[:, 0] + 1j * force_N[:, 1] - reaction[self._free].sum(),
                self._bushings.lost_W(nodes.poses, nodes.pulls),
                self._forces.exciter_W(nodes.poses, exciter_N),
                driven_W,
            )
        )

    def _freedoms(self) -> Array:
        """(2, freedoms): coordinates of the free bodies, and their rates."""
        return self._coordinates[:, 0, self._free].reshape(2, -1)

    def _driven_at(self, time_s: Array) -> Array:
        """(2, times, bodies, 3): places and rates of the driven bodies, zero for the others."""
        found = np.zeros((2, len(time_s), len(self._plan.bodies), 3))
        for drive in self._drives:
            found[:, :, drive.body] = drive.coordinates(time_s)
        return found

    def _moved(self) -> Motion:
        poses = self._poses
        position_m = self._plan.points_m + in_space((poses.place @ self._carried)[0])
        return Motion(position_m, in_space((poses.rate @ self._carried)[0]))


def _largest_step_s(plan: FramesPlan, machine: linear.LinearMachine) -> float:
    fastest_rad_per_s = max([machine.fastest_rad_per_s(), *linear.rates_rad_per_s(plan)])
    limit_s = LARGEST_STEP / fastest_rad_per_s if fastest_rad_per_s > 0 else plan.sync_interval_s
    return min(limit_s, plan.step_s) if plan.step_s > 0 else limit_s
