"""What every solver of frames makes of the linear machine: loads at rest, the order of bodies, the step."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.linear_frames import LinearMachine, driven, free, numbers
from orchestrator.ports.plans import DrivePlan, ExciterPlan, FramesPlan


def resting_load(plan: FramesPlan) -> Array:
    """Return weight and initial reaction as forces and moments about the centres of mass of the bodies that
    no drive moves, (free bodies, 6)."""
    load = np.zeros((len(plan.bodies), 6))
    carrier = numbers(plan, plan.carrier)
    for number, body in enumerate(plan.bodies):
        points = carrier == number
        arms_m = plan.points_m[points] - body.center_of_mass_m
        force_N = plan.reaction_N[points]
        load[number, :3] = body.mass_kg * plan.gravity_m_per_s2 + force_N.sum(axis=0)
        load[number, 3:] = np.cross(arms_m, force_N).sum(axis=0)
    return load[free(plan)]


def in_play_N(plan: FramesPlan) -> float:
    """Return the sum of the sizes of all forces that ``resting_load`` adds up."""
    weight_N = sum(body.mass_kg for body in plan.bodies) * np.linalg.norm(plan.gravity_m_per_s2)
    return float(weight_N + np.linalg.norm(plan.reaction_N, axis=1).sum())


def onto_bodies(plan: FramesPlan, carrier: Indices) -> Array:
    """Return the matrix (bodies, points) that sums what acts on points over the bodies that carry them."""
    carried = np.arange(len(plan.bodies))[:, None] == carrier
    return np.asarray(carried, dtype=np.float64)


def free_first(plan: FramesPlan) -> FramesPlan:
    """Return the same machine with its driven bodies last, in the order of the drives."""
    order = [*free(plan), *driven(plan)]
    return replace(plan, bodies=tuple(plan.bodies[number] for number in order))


def largest_step_s(plan: FramesPlan, machine: LinearMachine, largest_rad: float) -> float:
    """Return the step in which the fastest rate turns by ``largest_rad``, or the plan's if it is less.

    Rates are the natural frequencies, the speeds of exciters and drives, and those of their run-ups.
    """
    shaking: list[ExciterPlan | DrivePlan] = [*plan.exciters, *plan.drives]
    run_ups = [math.pi / source.run_up_s for source in shaking if source.run_up_s > 0]
    rates = [machine.fastest_rad_per_s(), *(source.speed_rad_per_s for source in shaking), *run_ups]
    limit_s = largest_rad / max(rates) if max(rates) > 0 else plan.sync_interval_s
    return min(limit_s, plan.step_s) if plan.step_s > 0 else limit_s
