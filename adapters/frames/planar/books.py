"""The books of planar frames: momentum and energy, summed with the collocation's own weights.

Driven bodies belong to the outside as the ground does, but have momentum and energy: their
drives give them whatever bushings and reactions do not (d'Alembert).  So do the guides that keep
all bodies in the plane: what pushes across goes into them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from adapters.frames.common import linear
from adapters.frames.planar.plane import Complex, Poses, in_plane, in_space, power
from adapters.frames.planar.shaft import Shaft
from orchestrator.ports import Account, Array, Indices, Saved
from orchestrator.ports.plans import FramesPlan
from orchestrator.ports.state import put_back, taken

_SUMS = ("_outside_N_s", "_lost_J", "_exciter_J", "_received_J", "_pushed_J")


@dataclass(frozen=True)
class Step:
    """At a step's nodes, (nodes,) each: ``outside_N`` on the free bodies less the reaction, and
    the power of losses, exciters, and bushings on driven bodies."""

    weight_s: Array
    outside_N: Complex
    lost_W: Array
    exciter_W: Array
    driven_W: Array


class Books:
    """Sums over steps and intervals since ``start``; ``carrier`` (n,) of the reaction's points."""

    def __init__(self, plan: FramesPlan, carrier: Indices, start: Poses) -> None:
        self._start = start
        self._mass_kg = np.array([body.mass_kg for body in plan.bodies])
        self._inertia_kg_m2 = np.array([body.inertia_kg_m2[1, 1] for body in plan.bodies])
        self._gravity_m_per_s2 = in_plane(plan.gravity_m_per_s2)
        self._driven = linear.driven(plan)
        self._into_outside = np.ones((len(carrier), 3))
        self._into_outside[np.isin(carrier, linear.free(plan))] = [0.0, 1.0, 0.0]
        self._outside_N_s = np.zeros(3)
        self._lost_J = self._exciter_J = self._received_J = self._pushed_J = 0.0

    def step(self, step: Step) -> None:
        weight_s = step.weight_s
        self._outside_N_s += in_space(np.asarray(weight_s @ step.outside_N))
        self._lost_J += float(weight_s @ step.lost_W)
        self._exciter_J += float(weight_s @ step.exciter_W)
        self._pushed_J += float(weight_s @ step.driven_W)

    def interval(self, force_N: Array, reaction: Complex, moved: Complex, length_s: float) -> None:
        """The reaction (n, 3), the same ``reaction`` on the natural coordinates, which ``moved``
        by so much, (2 bodies,) each."""
        work_J = power(reaction, moved).reshape(2, -1).sum(axis=0)
        self._received_J += float(work_J.sum())
        self._pushed_J += float(work_J[self._driven].sum())
        self._outside_N_s -= length_s * (force_N * self._into_outside).sum(axis=0)

    def account(self, now: Poses, elastic_J: float, shafts: Sequence[Shaft]) -> Account:
        """``now`` at one time."""
        kinetic_J, gravitational_J = self._kinetic_J(now), self._gravitational_J(now)
        supplied_J = {"exciter": self._exciter_J}
        if len(self._driven):
            gained_J = kinetic_J - self._kinetic_J(self._start)
            gained_J += gravitational_J - self._gravitational_J(self._start)
            supplied_J["drive"] = float(gained_J[self._driven].sum()) - self._pushed_J
        stored_J, lost_J = {"bushing_elastic": elastic_J}, {"bushing_damping": self._lost_J}
        if shafts:
            supplied_J["motor"] = sum(shaft.motor_J for shaft in shafts)
            stored_J["shaft"] = sum(shaft.stored_J(now.rate[0]) for shaft in shafts)
            lost_J["shaft_bearing"] = sum(shaft.lost_J for shaft in shafts)
        momentum = self._mass_kg * now.velocity_m_per_s[0]
        gained = momentum - self._mass_kg * self._start.velocity_m_per_s[0]
        return Account(
            in_space(momentum.sum()),
            self._outside_N_s + in_space(gained[self._driven].sum()),
            stored_J={
                "kinetic": float(kinetic_J.sum()),
                "gravitational": float(gravitational_J.sum()),
                **stored_J,
            },
            lost_J=lost_J,
            supplied_J=supplied_J,
            received_J={"reaction": self._received_J},
        )

    def save(self) -> Saved:
        return taken(self, *_SUMS)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_SUMS)

    def _kinetic_J(self, now: Poses) -> Array:
        """(bodies,)"""
        moving = self._mass_kg * np.abs(now.velocity_m_per_s[0]) ** 2
        return np.asarray(moving + self._inertia_kg_m2 * now.spin_rad_per_s[0] ** 2) / 2

    def _gravitational_J(self, now: Poses) -> Array:
        """(bodies,), zero as drawn."""
        return -self._mass_kg * power(self._gravity_m_per_s2, now.moved_m[0])
