"""Motors lag behind under load: the mean lag changes the stroke, and a load too large for them keeps
them from getting past the resonances on their way up."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.ports.physics import motor_torque_N_m
from orchestrator.ports.plans import ExciterPlan, MotorPlan
from orchestrator.preflight.scene.clamp_motion import largest_stroke_m
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict, compare, overlay_of_rows
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import Shaking, exciter_N, solve_shakings

COST = "half a millisecond per step of the frames"
SPEEDS = 200  # at which a resonance on the way up is looked for
ENOUGH = 1 / 3  # of the motor's torque: what surely lets it pass


def judge(scene: Scene) -> Verdict | None:
    """Return None without motors, or without forces on the frames."""
    exciters, turned = scene.plan.exciters, scene.observed.turned
    motors = [(exciter, exciter.motor) for exciter in exciters if exciter.motor is not None]
    if not motors:
        return None
    slip, share = max(_slip(scene, *one) for one in motors)
    slower = tuple(replace(one, speed_rad_per_s=(1 - slip) * one.speed_rad_per_s) for one in exciters)
    now_m = largest_stroke_m(scene, scene.shaken)
    then = solve_shakings(replace(scene.plan, exciters=slower), scene.springs)
    change = abs(largest_stroke_m(scene, then) / now_m - 1) if now_m else 0.0
    why = f"the machine takes {share:.2g} of the rated power in the mean: a slip of {slip:.2g}"
    slipping = compare("change of the stroke by slip", change, why, cost=COST)
    if share > 1.0:
        slipping = replace(slipping, matters=True)
    torque_share, at_rad_per_s = max(_torque_share(scene, *one) for one in motors)
    if slipping.matters or torque_share <= ENOUGH:
        return slipping
    takes = "took" if turned is not None else "takes, if it stays there,"
    passing = (
        f"at {at_rad_per_s:.3g} rad/s, on its way up, the machine {takes} {torque_share:.2g} of the torque "
        "that the motor has"
    )
    return Verdict(
        number="torque taken / there, on the way up",
        value=torque_share,
        threshold="0.33 (a third of what would hold it)",
        matters=True if torque_share > 1.0 else None,
        why=f"{passing}; {why}",
        cost=COST,
    )


def _slip(scene: Scene, exciter: ExciterPlan, motor: MotorPlan) -> tuple[float, float]:
    """Return the mean slip, in proportion to the mean power, and that power over the rated one."""
    power_W = sum(_power_W(exciter, one) for one in scene.shaken)
    if scene.observed.turned is not None:
        power_W = scene.observed.turned.power_W
    power_W += motor.bearing_N_m_s * exciter.speed_rad_per_s**2
    share = power_W / motor.rated_power_W
    return motor.rated_slip * share, share


def _torque_share(scene: Scene, exciter: ExciterPlan, motor: MotorPlan) -> tuple[float, float]:
    """Return the largest share that the machine takes of the torque that the motor has, at any speed
    below its own, and that speed.

    A machine that is slow to pass a resonance takes the steady motion's power there: an upper bound
    (Sommerfeld's effect; Kononenko, V. O., Vibrating Systems with a Limited Power Supply, 1969).  The
    motor has its breakdown torque at most, and what is left of it where the supply is at its full
    speed already."""

    def left_N_m(speed_rad_per_s: float) -> float:
        return float(motor_torque_N_m(motor, np.array(motor.synchronous_rad_per_s - speed_rad_per_s)))

    shares = []
    for speed_rad_per_s in (np.linspace(0.1, 0.95, SPEEDS) * exciter.speed_rad_per_s).tolist():
        slow = replace(exciter, speed_rad_per_s=speed_rad_per_s)
        shaken = solve_shakings(replace(scene.plan, exciters=(slow,)), scene.springs)
        taken_N_m = sum(_power_W(slow, one) for one in shaken) / speed_rad_per_s
        taken_N_m += motor.bearing_N_m_s * speed_rad_per_s
        shares.append((taken_N_m / left_N_m(speed_rad_per_s), speed_rad_per_s))
    most, at_rad_per_s = max(shares)
    if scene.observed.turned is not None:
        most = scene.observed.turned.largest_N_m / left_N_m(at_rad_per_s)
    return most, at_rad_per_s


def _power_W(exciter: ExciterPlan, shaking: Shaking) -> float:
    """Return the mean power of an exciter's force on the frame's motion at its own speed."""
    if shaking.speed_rad_per_s != exciter.speed_rad_per_s:
        return 0.0
    velocity_m_per_s = 1j * exciter.speed_rad_per_s * shaking.amplitude_m[exciter.body]
    return float((exciter_N(exciter).conj() @ velocity_m_per_s).real / 2)


def overlay(case: Case) -> Overlay:
    names = [name for name, row in case.screen.exciters.items() if row.motor]
    return overlay_of_rows("screen.exciters", names, {"motor": None})


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: any(exciter.motor for exciter in case.screen.exciters.values()),
    overlay=overlay,
    needs=("frame-dynamics",),
    key="screen.exciters.<name>.motor",
    checked_by="turned",
    saves=True,
)
