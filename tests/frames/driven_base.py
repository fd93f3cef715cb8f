"""A mass that hangs by a bushing on a base moved as prescribed, and where it goes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from orchestrator.ports import Array
from orchestrator.ports.plans import BodyPlan, BushingPlan, DrivePlan, FramesPlan
from tests.frames.machines import body

MASS_kg, STIFFNESS_N_per_m, DAMPING_N_s_per_m, SPEED_rad_per_s = 20.0, 1e5, 600.0, 60.0
NONE = np.zeros(3)


def shaken(amplitude_m: Array, rotation_rad: Array = NONE, run_up_s: float = 0.0) -> DrivePlan:
    return DrivePlan("base", NONE, SPEED_rad_per_s, amplitude_m, NONE, rotation_rad, NONE, run_up_s)


def on_a_base(base: DrivePlan, bushing: BushingPlan, step_s: float) -> FramesPlan:
    """A mass whose centre is at the bushing, so that the bushing does not turn it."""
    free = BodyPlan("mass", MASS_kg, 0.5 * MASS_kg * np.eye(3), bushing.position_m)
    return FramesPlan(
        bodies=(body("base", 50.0), free),
        bushings=(bushing,),
        exciters=(),
        drives=(base,),
        gravity_m_per_s2=NONE,
        points_m=bushing.position_m[None],
        carrier=("mass",),
        reaction_N=np.zeros((1, 3)),
        drawn_at_rest=True,
        step_s=step_s,
        sync_interval_s=step_s,
    )


def isotropic(position_m: Array, bodies: tuple[str, str] = ("base", "mass")) -> BushingPlan:
    size = np.ones(3)
    k, c = STIFFNESS_N_per_m * size, DAMPING_N_s_per_m * size
    return BushingPlan("spring", bodies, position_m, np.eye(3), k, c)


def rocked(step_s: float, turn_rad: Array, bodies: tuple[str, str], stiffness_N_per_m: Array) -> FramesPlan:
    """The base swings by ``turn_rad``, with the bushing 0.7 m from its centre."""
    shift_m = np.array([2e-3, 1e-3 if turn_rad[0] else 0.0, 3e-3])
    base = shaken(shift_m, turn_rad, run_up_s=0.1)
    spring = isotropic(np.array([0.6, 0.2, 0.3]), bodies)
    damping_N_s_per_m = 3e-3 * stiffness_N_per_m
    spring = replace(spring, stiffness_N_per_m=stiffness_N_per_m, damping_N_s_per_m=damping_N_s_per_m)
    return on_a_base(base, spring, step_s)


def carried_along_m(plan: FramesPlan, duration_s: float) -> Array:
    """The mass of ``rocked`` by an integrator of high order, from Newton's law written out:
    m x'' = A (k e + c e'),  e = A^T (mount - x),  e' = A^T (mount' - x'),  A turning with the
    base.  The mount's place is written out, too; its velocity by differences (1e-10)."""
    base, spring = plan.drives[0], plan.bushings[0]

    def ramp(time_s: float) -> float:
        return float((1 - np.cos(np.pi * min(time_s / base.run_up_s, 1.0))) / 2)

    def turned(time_s: float) -> Rotation:
        return Rotation.from_rotvec(ramp(time_s) * base.rotation_rad * np.sin(SPEED_rad_per_s * time_s))

    def mount_m(time_s: float) -> Array:
        shift_m = ramp(time_s) * base.amplitude_m * np.sin(SPEED_rad_per_s * time_s)
        return np.asarray(shift_m + turned(time_s).apply(spring.position_m))

    def rate(time_s: float, state: Array) -> Array:
        axes, h = turned(time_s).as_matrix(), 1e-6
        mount_m_per_s = (mount_m(time_s + h) - mount_m(time_s - h)) / (2 * h)
        stretch_m, stretch_m_per_s = ((axes.T @ (mount_m(time_s) - state[:3])), mount_m_per_s - state[3:])
        pull_N = spring.stiffness_N_per_m * stretch_m + spring.damping_N_s_per_m * (axes.T @ stretch_m_per_s)
        return np.concatenate([state[3:], axes @ pull_N / MASS_kg])

    start = np.concatenate([spring.position_m, NONE])
    done = solve_ivp(rate, (0.0, duration_s), start, "DOP853", rtol=1e-10, atol=1e-11)
    return np.asarray(done.y[:3, -1])
