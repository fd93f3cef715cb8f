"""Translating bodies on bushings: linear equations, integrated to rounding.

    M x'' + C x' + K x = weight + reaction + exciters

for any number of bodies, without rotations.  Each step is Gauss-Legendre collocation with six
stages (order 12; Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed. 2006, section
II.1.3).  Its error per step is about 2e-16 (w h)^13, so steps with  w h <= 1  agree with the
closed form to rounding; and as it preserves quadratic invariants, momentum and energy close to
rounding at every step.

A machine drawn at rest starts with its bushings stretched by the static sag, so that they carry
weight and initial reaction: nothing moves before an exciter starts.  What is integrated is the
displacement since then, under what the loads differ from those: soft springs sag by metres, and
stiff ones beside them would turn the rounding of metres into forces.
"""

from __future__ import annotations

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.collocation import Gauss, gauss
from adapters.frames.common.unbalance import Unbalance
from orchestrator.ports import Account, Array, Load, Motion, Saved, counted
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import FramesPlan
from orchestrator.ports.state import put_back, taken

_SUMS = ("_outside_N_s", "_lost_J", "_supplied_J", "_received_J")
_STATE = ("_displacement_m", "_velocity_m_per_s", *_SUMS)


def build(plan: FramesPlan) -> TwoMassFrames:
    """Raises ValueError for drives, unknown bodies, or bushings that cannot hold the weight."""
    if plan.drives:
        raise ValueError(
            f"two_mass moves bodies by forces; the drive of {plan.drives[0].body!r} needs planar, "
            "exudyn or, where every body is driven, prescribed"
        )
    return TwoMassFrames(plan)


class TwoMassFrames:
    """``Frames`` that translate.  ``plan.step_s`` = 0 takes the largest step without error."""

    def __init__(self, plan: FramesPlan) -> None:
        self._plan = plan
        self._carrier = linear.numbers(plan, plan.carrier)
        excited = linear.numbers(plan, tuple(exciter.body for exciter in plan.exciters))
        unbalances = [Unbalance(exciter) for exciter in plan.exciters]
        self._exciters = list(zip(excited, unbalances, strict=True))
        self._onto_bodies = linear.onto_bodies(plan, self._carrier)
        self._machine = machine = linear.linearised(plan, linear.TRANSLATIONS)
        self._mass_kg = np.array([body.mass_kg for body in plan.bodies])
        self._weight_N = np.outer(self._mass_kg, plan.gravity_m_per_s2)
        load = linear.resting_load(plan)[:, :3].ravel()
        held = load if plan.drawn_at_rest else np.zeros_like(load)
        self._sag_m = machine.sag(held, linear.in_play_N(plan))
        self._held_N = held.reshape(-1, 3)
        self._displacement_m, self._velocity_m_per_s = np.zeros_like(load), np.zeros_like(load)
        self._largest_step_s = _largest_step_s(plan, machine)
        self._step_s = 0.0
        to_ground = [bushing.bodies.count("ground") == 1 for bushing in plan.bushings]
        ground = np.repeat(np.array(to_ground, dtype=bool), 3)
        self._ground_stiffness = _by_bushings(machine.stretch, machine.stiffness_N_per_m * ground)
        self._ground_damping = _by_bushings(machine.stretch, machine.damping_N_s_per_m * ground)
        self._outside_N_s = np.zeros(3)
        self._lost_J = self._supplied_J = self._received_J = 0.0

    def initial(self) -> Motion:
        return self._carried()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        counted("frames' reaction", reaction, len(self._carrier))
        steps = interval.steps(self._largest_step_s)
        self._prepare(interval.length_s / steps)
        reaction_N = self._onto_bodies @ reaction.force_N
        before_m = self._displacement_m
        for step in range(steps):
            self._step(interval.start_s + step * self._step_s, reaction_N)
        self._received_J += float(reaction_N.ravel() @ (self._displacement_m - before_m))
        self._outside_N_s -= interval.length_s * reaction.force_N[self._carrier < 0].sum(axis=0)
        return self._carried()

    def account(self) -> Account:
        machine, velocity_m_per_s = self._machine, self._velocity_m_per_s
        stretch_m = machine.stretch @ (self._sag_m + self._displacement_m)
        momentum = self._mass_kg @ velocity_m_per_s.reshape(-1, 3)
        fallen_J = self._weight_N.ravel() @ self._displacement_m
        return Account(
            momentum,
            self._outside_N_s.copy(),
            stored_J={
                "kinetic": float(velocity_m_per_s @ machine.mass @ velocity_m_per_s) / 2,
                "bushing_elastic": float(machine.stiffness_N_per_m @ stretch_m**2) / 2,
                "gravitational": -float(fallen_J),
            },
            lost_J={"bushing_damping": self._lost_J},
            supplied_J={"exciter": self._supplied_J},
            received_J={"reaction": self._received_J},
        )

    def save(self) -> Saved:
        return taken(self, *_STATE)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_STATE)

    def close(self) -> None:
        pass

    def _prepare(self, step_s: float) -> None:
        """The collocation's matrices for this step length."""
        if step_s != self._step_s:
            self._step_s = step_s
            machine = self._machine
            self._gauss: Gauss = gauss(machine.mass, machine.damping, machine.stiffness, step_s)

    def _step(self, start_s: float, reaction_N: Array) -> None:
        gauss = self._gauss
        exciter_N = np.zeros((len(gauss.weight_s), *reaction_N.shape))
        for number, exciter in self._exciters:
            exciter_N[:, number] += exciter.force_N(start_s + gauss.node_s)
        load_N = exciter_N + (reaction_N + self._weight_N - self._held_N)
        x_m, v_m_per_s = gauss.stages(self._displacement_m, self._velocity_m_per_s, load_N)
        self._displacement_m, self._velocity_m_per_s = gauss.end(
            self._displacement_m, self._velocity_m_per_s, load_N
        )
        self._book(exciter_N, x_m, v_m_per_s)

    def _book(self, exciter_N: Array, x_m: Array, v_m_per_s: Array) -> None:
        """Impulse from outside, work and loss of one step, by the collocation's own weights."""
        weight_s = self._gauss.weight_s
        ground_N = -(x_m @ self._ground_stiffness + v_m_per_s @ self._ground_damping)
        constant_N = self._weight_N - self._held_N  # the ground holds the bodies at rest
        outside_N = (exciter_N + ground_N.reshape(exciter_N.shape) + constant_N).sum(axis=1)
        self._outside_N_s += weight_s @ outside_N
        self._lost_J += float(weight_s @ np.sum(v_m_per_s * (v_m_per_s @ self._machine.damping), axis=1))
        power_W = np.sum(exciter_N.reshape(v_m_per_s.shape) * v_m_per_s, axis=1)
        self._supplied_J += float(weight_s @ power_W)

    def _carried(self) -> Motion:
        position_m, velocity_m_per_s = (self._plan.points_m.copy(), np.zeros_like(self._plan.points_m))
        held = self._carrier >= 0
        moved_m = self._displacement_m.reshape(-1, 3)
        position_m[held] += moved_m[self._carrier[held]]
        velocity_m_per_s[held] = self._velocity_m_per_s.reshape(-1, 3)[self._carrier[held]]
        return Motion(position_m, velocity_m_per_s)


def steady_amplitudes_m(plan: FramesPlan, speed_rad_per_s: float) -> Array:
    """Complex amplitudes X (bodies, 3) of the steady state at any constant speed of all exciters:
    x(t) = Re(X exp(i speed t)), with every exciter at its ``phase_rad`` at t = 0."""
    machine = linear.linearised(plan, linear.TRANSLATIONS)
    force_N = np.zeros((len(plan.bodies), 3), dtype=complex)
    for exciter in plan.exciters:
        turning = exciter.start - 1j * np.cross(exciter.axis, exciter.start)
        size_N = exciter.mass_moment_kg_m * speed_rad_per_s**2 * np.exp(1j * exciter.phase_rad)
        force_N[linear.numbers(plan, (exciter.body,))[0]] += size_N * turning
    dynamic = machine.stiffness + 1j * speed_rad_per_s * machine.damping
    dynamic = dynamic - speed_rad_per_s**2 * machine.mass
    return np.asarray(np.linalg.solve(dynamic, force_N.ravel()).reshape(-1, 3))


def _by_bushings(stretch: Array, per_axis: Array) -> Array:
    return np.asarray(stretch.T @ (per_axis[:, None] * stretch))


def _largest_step_s(plan: FramesPlan, machine: linear.LinearMachine) -> float:
    fastest = max([machine.fastest_rad_per_s(), *linear.rates_rad_per_s(plan)])
    limit_s = 1 / fastest if fastest > 0 else plan.sync_interval_s
    return min(limit_s, plan.step_s) if plan.step_s > 0 else limit_s
