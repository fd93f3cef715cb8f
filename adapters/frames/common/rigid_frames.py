"""Common parts of all solvers of rigid frames that forces move, however they treat rotations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

import numpy as np

from adapters.frames.common.drive import DrivenBodies
from adapters.frames.common.elements import BushingElements
from adapters.frames.common.exciter import Shaft
from adapters.frames.common.ledger import FramesLedger
from orchestrator.ports import Array, Indices, Known, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.linear_frames import LinearMachine, free, linearise, numbers
from orchestrator.ports.plans import DrivePlan, ExciterPlan, FramesPlan
from orchestrator.ports.state import SavedAttributes
from orchestrator.ports.unbalance import Unbalance

ELEMENT_STEP_RAD = 0.1
"""Largest angle by which the machine's fastest rate turns in a step, with elements in the bushings."""


class RigidFrames(SavedAttributes):
    """The frames of a plan, whose bodies have some of six coordinates each (``ports/linear_frames.py``).

    ``_free`` are the numbers of the bodies that no drive moves.  ``_held`` is the load on their coordinates
    that the bushings hold at rest, and ``_sag`` are the coordinates at which the bushings hold it; both are
    zero unless the machine is drawn at rest; ``_sag_m`` (bushings, 3) are the stretches there.  ``_plan`` has
    the linear springs of bushings with measured curves or characteristics, and ``_elements`` what is beside
    them.  Raises ValueError for unknown bodies, drives that make no sense, and bushings that cannot hold the
    weight.
    """

    COORDINATES: ClassVar[tuple[int, ...]]
    PARTS = ("_ledger",)
    _ledger: FramesLedger

    def __init__(self, plan: FramesPlan) -> None:
        whole = plan
        plan = replace(plan, bushings=tuple(bushing.beside_elements() for bushing in plan.bushings))
        self._plan, self._driven_bodies = plan, DrivenBodies(plan)
        self._carrier, self._free = numbers(plan, plan.carrier), free(plan)
        self._drawn_m = np.array([body.center_of_mass_m for body in plan.bodies])
        self._machine = linearise(plan, self.COORDINATES)
        self._held = np.zeros(len(self._machine.mass))
        if plan.drawn_at_rest:
            self._held = _resting_load(plan, self._carrier)[self._free][:, self.COORDINATES].ravel()
        weight_N = sum(body.mass_kg for body in plan.bodies) * np.linalg.norm(plan.gravity_m_per_s2)
        in_play_N = float(weight_N + np.linalg.norm(plan.reaction_N, axis=1).sum())
        self._sag = self._machine.sag(self._held, in_play_N)
        self._sag_m = (self._machine.stretch @ self._sag).reshape(-1, 3)
        self._elements = BushingElements(whole, self._sag_m)
        self._shafts: Sequence[Shaft] = ()

    def ahead(self, interval: Interval) -> Known | None:
        return self._driven_bodies.ahead(interval)

    def save(self) -> Saved:
        shafts = {str(number): shaft.save() for number, shaft in enumerate(self._shafts)}
        turning: Saved = {"shafts": shafts} if shafts else {}
        return super().save() | turning | self._elements.save()

    def restore(self, saved: Saved) -> None:
        super().restore(saved)
        for number, shaft in enumerate(self._shafts):
            shaft.restore(saved["shafts"][str(number)])
        self._elements.restore(saved)

    def element_forces_N(self) -> Array | None:
        """Return the forces (bushings, 3) of elements along the bushings' axes, None without elements."""
        return self._elements.force_N if self._elements else None

    def shaft_angles_rad(self) -> Mapping[str, float]:
        """Return the angles of the shafts that motors turn, by the exciters' names."""
        return {shaft.name: shaft.angle_rad for shaft in self._shafts}

    def _stiffest(self) -> LinearMachine:
        """Return the linear machine with friction elements that hold, Maxwell elements that do not relax,
        and closed gaps."""
        if not self._elements:
            return self._machine
        more_N_per_m = self._elements.stiffness_N_per_m.ravel()
        return replace(self._machine, stiffness_N_per_m=self._machine.stiffness_N_per_m + more_N_per_m)

    def _largest_step_s(self, largest_rad: float) -> float:
        """Return the step in which the fastest rate turns by ``largest_rad``, or the plan's if it is less.

        The rates are the natural frequencies, the speeds of exciters and drives, and the rates of their
        run-ups.  Where bushings have elements, whose force has an error of second order, steps are no longer
        than ``ELEMENT_STEP_RAD`` and half of a relaxation time.
        """
        plan, elements = self._plan, self._elements
        shaking: list[ExciterPlan | DrivePlan] = [*plan.exciters, *plan.drives]
        run_ups = [math.pi / source.run_up_s for source in shaking if source.run_up_s > 0]
        run_ups += [math.pi / row.run_down_s for row in plan.exciters if row.run_down_s > 0]
        speeds = [source.speed_rad_per_s for source in shaking]
        fastest = max(self._stiffest().fastest_rad_per_s(), *speeds, *run_ups, 0.0)
        if elements:
            largest_rad = min(largest_rad, ELEMENT_STEP_RAD, fastest * elements.hysteresis.shortest_s / 2)
        limit_s = largest_rad / fastest if fastest > 0 else plan.sync_interval_s
        return min(limit_s, plan.step_s) if plan.step_s > 0 else limit_s


class BushingTable:
    """The bushings of a plan: places (n, 3), spring axes (n, 3, 3), stiffness and damping along the axes (n,
    3), and the numbers (n,) of their first and second bodies, -1 for the ground."""

    def __init__(self, plan: FramesPlan) -> None:
        every = plan.bushings
        self.first, self.second = (numbers(plan, tuple(b.bodies[end] for b in every)) for end in (0, 1))
        self.place_m = np.array([b.position_m for b in every]).reshape(-1, 3)
        self.axes = np.array([b.axes for b in every]).reshape(-1, 3, 3)
        self.stiffness_N_per_m = np.array([b.stiffness_N_per_m for b in every]).reshape(-1, 3)
        self.damping_N_s_per_m = np.array([b.damping_N_s_per_m for b in every]).reshape(-1, 3)


class Unbalances:
    """The exciters of a plan at their given speeds: places (n, 3), and numbers (n,) of bodies."""

    def __init__(self, plan: FramesPlan, exciters: Sequence[ExciterPlan]) -> None:
        self.body = numbers(plan, tuple(exciter.body for exciter in exciters))
        self.place_m = np.array([exciter.position_m for exciter in exciters]).reshape(-1, 3)
        self._every = [Unbalance(exciter) for exciter in exciters]

    def force_N(self, time_s: Array) -> Array:
        """Return the forces of the exciters, (times, n, 3), at the times."""
        force_N = np.zeros((len(time_s), len(self._every), 3))
        for number, unbalance in enumerate(self._every):
            force_N[:, number] = unbalance.force_N(time_s)
        return force_N


def onto_bodies(plan: FramesPlan, carrier: Indices) -> Array:
    """Return the matrix (bodies, points) that sums the effect on points over the bodies that carry them."""
    carried = np.arange(len(plan.bodies))[:, None] == carrier
    return np.asarray(carried, dtype=np.float64)


def _resting_load(plan: FramesPlan, carrier: Indices) -> Array:
    """Return weight and initial reaction as forces and moments about the centres of mass, (bodies, 6)."""
    load = np.zeros((len(plan.bodies), 6))
    for number, body in enumerate(plan.bodies):
        points = carrier == number
        arms_m, force_N = plan.points_m[points] - body.center_of_mass_m, plan.reaction_N[points]
        load[number, :3] = body.mass_kg * plan.gravity_m_per_s2 + force_N.sum(axis=0)
        load[number, 3:] = np.cross(arms_m, force_N).sum(axis=0)
    return load
