"""Translating bodies on bushings: linear equations, integrated to rounding.

    M x'' + C x' + K x = weight + reaction + exciters

for any number of bodies, without rotations.  Each step is Gauss-Legendre collocation
(``common/collocation.py``) with  w h <= 1.

A machine drawn at rest starts with its bushings stretched by the static sag, so that they carry
weight and initial reaction: nothing moves before an exciter starts.  What is integrated is the
displacement since then, under what the loads differ from those: soft springs sag by metres, and
stiff ones beside them would turn the rounding of metres into forces.
"""

from __future__ import annotations

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.collocation import STAGES, Collocation
from adapters.frames.common.exciter import Unbalance
from adapters.frames.common.ledger import BodySums, FramesLedger
from orchestrator.ports import Account, Array, Load, Motion, Saved, check_point_count, linear_frames
from orchestrator.ports.adapters import FramesAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import Cost, FramesPlan, FramesWork
from orchestrator.ports.state import restore_attributes, save_attributes

_STATE = ("_displacement_m", "_velocity_m_per_s")
LARGEST_STEP_RAD = 1.0
"""Of the machine's fastest rate: agrees with the closed form to rounding."""


def build(plan: FramesPlan) -> TwoMassFrames:
    """Open the frames of ``plan``.

    Raises ValueError for drives, unknown bodies, or bushings that cannot hold the weight.
    """
    if plan.drives:
        raise ValueError(
            f"two_mass moves bodies by forces; the drive of {plan.drives[0].body!r} needs planar, "
            "exudyn or, where every body is driven, prescribed"
        )
    return TwoMassFrames(plan)


class TwoMassFrames:
    """``Frames`` that translate; ``plan.step_s`` = 0 takes the largest step without error."""

    def __init__(self, plan: FramesPlan) -> None:
        self._plan = plan
        self._carrier = linear_frames.numbers(plan, plan.carrier)
        excited = linear_frames.numbers(plan, tuple(exciter.body for exciter in plan.exciters))
        unbalances = [Unbalance(exciter) for exciter in plan.exciters]
        self._exciters = list(zip(excited, unbalances, strict=True))
        self._onto_bodies = linear.onto_bodies(plan, self._carrier)
        self._machine = machine = linear_frames.linearise(plan, linear_frames.TRANSLATIONS)
        self._mass_kg = np.array([body.mass_kg for body in plan.bodies])
        self._weight_N = np.outer(self._mass_kg, plan.gravity_m_per_s2)
        load = linear.resting_load(plan)[:, :3].ravel()
        held = load if plan.drawn_at_rest else np.zeros_like(load)
        self._sag_m = machine.sag(held, linear.in_play_N(plan))
        self._held_N = held.reshape(-1, 3)
        self._displacement_m, self._velocity_m_per_s = np.zeros_like(load), np.zeros_like(load)
        self._largest_step_s = linear.largest_step_s(plan, machine, LARGEST_STEP_RAD)
        self._collocation = Collocation(machine)
        to_ground = [bushing.bodies.count("ground") == 1 for bushing in plan.bushings]
        ground = np.repeat(np.array(to_ground, dtype=bool), 3)
        self._ground_stiffness = _by_bushings(machine.stretch, machine.stiffness_N_per_m * ground)
        self._ground_damping = _by_bushings(machine.stretch, machine.damping_N_s_per_m * ground)
        self._ledger = FramesLedger(self._sums(), linear_frames.driven(plan))

    def initial(self) -> Motion:
        return self._carried()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        check_point_count("frames' reaction", reaction, len(self._carrier))
        steps = interval.steps(self._largest_step_s)
        self._collocation.set_step(interval.length_s / steps)
        reaction_N = self._onto_bodies @ reaction.force_N
        before_m = self._displacement_m
        for step in range(steps):
            self._step(interval.start_s + step * self._collocation.step_s, reaction_N)
        ledger, outside = self._ledger, self._carrier < 0
        ledger.reaction_J += float(reaction_N.ravel() @ (self._displacement_m - before_m))
        ledger.outside_N_s -= interval.length_s * reaction.force_N[outside].sum(axis=0)
        return self._carried()

    def account(self) -> Account:
        stretch_m = self._machine.stretch @ (self._sag_m + self._displacement_m)
        elastic_J = float(self._machine.stiffness_N_per_m @ stretch_m**2) / 2
        return self._ledger.account(self._sums(), elastic_J)

    def save(self) -> Saved:
        return save_attributes(self, *_STATE) | {"ledger": self._ledger.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_STATE)
        self._ledger.restore(saved["ledger"])

    def close(self) -> None:
        pass

    def _step(self, start_s: float, reaction_N: Array) -> None:
        collocation, state = self._collocation, (self._displacement_m, self._velocity_m_per_s)
        exciter_N = np.zeros((STAGES, *reaction_N.shape))
        for number, exciter in self._exciters:
            exciter_N[:, number] += exciter.force_N(start_s + collocation.node_s)
        load_N = exciter_N + (reaction_N + self._weight_N - self._held_N)
        self._book(exciter_N, *collocation.stages(*state, load_N))
        self._displacement_m, self._velocity_m_per_s = collocation.end(*state, load_N)

    def _book(self, exciter_N: Array, x_m: Array, v_m_per_s: Array) -> None:
        """Book impulse from outside, work and loss of one step, by the collocation's own weights."""
        weight_s, ledger = self._collocation.weight_s, self._ledger
        ground_N = -(x_m @ self._ground_stiffness + v_m_per_s @ self._ground_damping)
        constant_N = self._weight_N - self._held_N  # the ground holds the bodies at rest
        outside_N = (exciter_N + ground_N.reshape(exciter_N.shape) + constant_N).sum(axis=1)
        ledger.outside_N_s += weight_s @ outside_N
        ledger.damping_J += float(weight_s @ np.sum(v_m_per_s * (v_m_per_s @ self._machine.damping), axis=1))
        power_W = np.sum(exciter_N.reshape(v_m_per_s.shape) * v_m_per_s, axis=1)
        ledger.exciter_J += float(weight_s @ power_W)

    def _sums(self) -> BodySums:
        velocity_m_per_s = self._velocity_m_per_s.reshape(-1, 3)
        momentum_kg_m_per_s = self._mass_kg[:, None] * velocity_m_per_s
        return BodySums(
            momentum_kg_m_per_s,
            np.sum(momentum_kg_m_per_s * velocity_m_per_s, axis=1) / 2,
            -np.sum(self._weight_N * self._displacement_m.reshape(-1, 3), axis=1),
        )

    def _carried(self) -> Motion:
        position_m, velocity_m_per_s = (self._plan.points_m.copy(), np.zeros_like(self._plan.points_m))
        held = self._carrier >= 0
        moved_m = self._displacement_m.reshape(-1, 3)
        position_m[held] += moved_m[self._carrier[held]]
        velocity_m_per_s[held] = self._velocity_m_per_s.reshape(-1, 3)[self._carrier[held]]
        return Motion(position_m, velocity_m_per_s)


def _by_bushings(stretch: Array, per_axis: Array) -> Array:
    return np.asarray(stretch.T @ (per_axis[:, None] * stretch))


def cost(work: FramesWork) -> Cost:
    """A call in each interval."""
    return Cost(0.02, work.runs * 2e-4)


ADAPTER = FramesAdapter(
    about="linear, without rotation and drives",
    build=build,
    cost=cost,
    leaves_out={
        "frame-rotation": "frames translate only",
        "motor-slip": "shafts turn at their speed_rad_per_s",
    },
    drives=False,
    rotates=False,
    motors=False,
    fidelity=1,
)
