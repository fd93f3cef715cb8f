"""The motion of the frames while a machine starts, by the linear equations of its steady motion.

    M x'' + C x' + K x = F(t)

from rest, with panels as the springs that they are at the full stroke.  Shafts and drives run up as in a run
(``ports/plans.py``); a motor, whose shaft would lag, is taken to turn at its synchronous speed.  The
equations are solved exactly for forces that are straight lines between times ``FINE`` to a turn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from orchestrator.ports import Array, linear_frames
from orchestrator.ports.plans import ExciterPlan, FramesPlan
from orchestrator.ports.unbalance import Unbalance, run_up
from orchestrator.preflight.scene.shaking import PanelSpring, Shaking, carry_panels, free_frames

STEPS, FINE = 50, 200
"""Times to a turn, of a motion and of the forces that make it."""
MOST_RUN_UP_TURNS = 24
"""A longer run-up is shortened to it: it is slow against everything in a machine already."""


def run_up_turns(plan: FramesPlan, speed_rad_per_s: float) -> float:
    """Return the turns of the longest run-up at a speed."""
    rows = [(row.speed_rad_per_s, row.run_up_s) for row in plan.exciters]
    rows += [(row.speed_rad_per_s, row.run_up_s) for row in plan.drives]
    longest_s = max((run_up_s for speed, run_up_s in rows if speed == speed_rad_per_s), default=0.0)
    return min(longest_s * speed_rad_per_s / (2 * math.pi), MOST_RUN_UP_TURNS)


def find_transients_m(
    plan: FramesPlan, springs: Sequence[PanelSpring], shaking: Shaking, turns: int
) -> dict[str, Array]:
    """Return what the displacement of each frame and the ground differs from the steady one by.

    Each is (``turns`` STEPS + 1, 3), from the start of the machine on, ``STEPS`` to a turn.  Shafts start at
    such an angle that they end in the phase of the steady motion.
    """
    speed = shaking.speed_rad_per_s
    time_s = np.arange(FINE * turns + 1) / FINE * 2 * math.pi / speed
    wave = np.exp(1j * speed * time_s)[:, None]
    steady_m = {name: (wave * amplitude_m).real for name, amplitude_m in shaking.amplitude_m.items()}
    place_m = {name: np.zeros_like(moved_m) for name, moved_m in steady_m.items()}
    loads_N = {body.name: np.zeros((len(time_s), 3)) for body in plan.bodies}
    longest_s = MOST_RUN_UP_TURNS * 2 * math.pi / speed
    for exciter in plan.exciters:
        if exciter.speed_rad_per_s == speed:
            loads_N[exciter.body] += _exciter_N(exciter, min(exciter.run_up_s, longest_s), time_s)
    names, free = [body.name for body in plan.bodies], free_frames(plan)
    machine = linear_frames.linearise(
        carry_panels(plan, springs), linear_frames.TRANSLATIONS, np.arange(len(names))
    )
    columns = np.add.outer(3 * np.array([names.index(name) for name in free], dtype=int), [0, 1, 2]).ravel()
    for drive in plan.drives:
        if drive.speed_rad_per_s == speed:
            share, _ = run_up(time_s, min(drive.run_up_s, longest_s))
            place_m[drive.body] = share[:, None] * steady_m[drive.body]
    if free:
        driven_m = np.hstack([place_m[name] for name in names])
        driven_m_per_s = np.gradient(driven_m, time_s[1], axis=0)
        load_N = np.hstack([loads_N[name] for name in names])
        load_N -= driven_m @ machine.stiffness + driven_m_per_s @ machine.damping
        moved_m = _from_rest(machine, columns, load_N[:, columns], time_s)
        for number, name in enumerate(free):
            place_m[name] = moved_m[:, 3 * number : 3 * number + 3]
    return {name: (place_m[name] - steady_m[name])[:: FINE // STEPS] for name in place_m}


def _exciter_N(exciter: ExciterPlan, run_up_s: float, time_s: Array) -> Array:
    """Return the forces (times, 3) of an unbalance whose shaft runs up from time 0 on."""
    phase_rad = exciter.phase_rad + exciter.speed_rad_per_s * run_up_s / 2
    plan = replace(exciter, run_up_s=run_up_s, phase_rad=phase_rad, start_s=0.0, stop_s=math.inf)
    return Unbalance(plan).force_N(time_s)


def _from_rest(machine: linear_frames.LinearMachine, columns: Array, load_N: Array, time_s: Array) -> Array:
    """Return the displacements (times, columns) of a machine's free coordinates under loads on them."""
    import scipy.linalg
    import scipy.signal

    own, count = np.ix_(columns, columns), len(columns)
    per_kg = scipy.linalg.inv(machine.mass[own])
    zero, one = np.zeros((count, count)), np.eye(count)
    rates = np.block([[zero, one], [-per_kg @ machine.stiffness[own], -per_kg @ machine.damping[own]]])
    system = rates, np.vstack([zero, per_kg]), np.hstack([one, zero]), zero
    return np.asarray(scipy.signal.lsim(system, load_N, time_s)[1]).reshape(-1, count)
