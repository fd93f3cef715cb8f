"""Slip of motors under load.

The mean slip changes the stroke, and a load that is too large for a motor keeps it from passing the
resonances during the run-up.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.ports.physics import motor_torque_N_m
from orchestrator.ports.plans import ExciterPlan, MotorPlan
from orchestrator.preflight.scene.clamp_motion import largest_stroke_m
from orchestrator.preflight.scene.effect import Effect, Overlay, Verdict, compare, overlay_of_rows
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import exciter_power_W, solve_shakings

COST = "half a millisecond per step of the frames"
SPEEDS = 200  # number of speeds at which a resonance during the run-up is searched
ENOUGH = 1 / 3  # share of the motor's torque below which the load surely lets it pass


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the change of the stroke or on the torque; None without motors."""
    exciters, exciter_load = scene.plan.exciters, scene.observed.exciter_load
    motors = [(exciter, exciter.motor) for exciter in exciters if exciter.motor is not None]
    if not motors:
        return None
    slip, share = max(_slip(scene, exciter, motor) for exciter, motor in motors)
    slower = tuple(replace(row, speed_rad_per_s=(1 - slip) * row.speed_rad_per_s) for row in exciters)
    now_m = largest_stroke_m(scene, scene.shaken)
    then = solve_shakings(replace(scene.plan, exciters=slower), scene.springs)
    change = abs(largest_stroke_m(scene, then) / now_m - 1) if now_m else 0.0
    why = f"the machine takes {share:.2g} of the rated power in the mean: a slip of {slip:.2g}"
    slipping = compare("change of the stroke by slip", change, why, cost=COST)
    if share > 1.0:
        slipping = replace(slipping, matters=True)
    torque_share, at_rad_per_s = max(_torque_share(scene, exciter, motor) for exciter, motor in motors)
    if slipping.matters or torque_share <= ENOUGH:
        return slipping
    takes = "took" if exciter_load is not None else "takes, if it stays there,"
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
    """Return the mean slip and the mean power over the rated power, to which the slip is proportional."""
    power_W = sum(exciter_power_W(exciter, shaking) for shaking in scene.shaken)
    if scene.observed.exciter_load is not None:
        power_W = scene.observed.exciter_load.power_W
    power_W += motor.bearing_N_m_s * exciter.speed_rad_per_s**2
    share = power_W / motor.rated_power_W
    return motor.rated_slip * share, share


def _torque_share(scene: Scene, exciter: ExciterPlan, motor: MotorPlan) -> tuple[float, float]:
    """Return the largest share of the motor's torque that the machine takes during the run-up, and the speed.

    A machine that passes a resonance slowly takes the power of the steady motion there, which is an
    upper bound (Sommerfeld's effect; Kononenko, V. O., Vibrating Systems with a Limited Power Supply,
    1969).  The motor has the torque that its curve gives while the supply is at full speed.
    """

    def available_N_m(speed_rad_per_s: float) -> float:
        return float(motor_torque_N_m(motor, np.array(motor.synchronous_rad_per_s - speed_rad_per_s)))

    shares = []
    for speed_rad_per_s in (np.linspace(0.1, 0.95, SPEEDS) * exciter.speed_rad_per_s).tolist():
        slow = replace(exciter, speed_rad_per_s=speed_rad_per_s)
        shaken = solve_shakings(replace(scene.plan, exciters=(slow,)), scene.springs)
        load_N_m = sum(exciter_power_W(slow, shaking) for shaking in shaken) / speed_rad_per_s
        load_N_m += motor.bearing_N_m_s * speed_rad_per_s
        shares.append((load_N_m / available_N_m(speed_rad_per_s), speed_rad_per_s))
    most, at_rad_per_s = max(shares)
    if scene.observed.exciter_load is not None:
        most = scene.observed.exciter_load.largest_N_m / available_N_m(at_rad_per_s)
    return most, at_rad_per_s


def overlay(case: Case) -> Overlay:
    """Return the overlay that takes the motors off their exciters."""
    names = [name for name, row in case.screen.exciters.items() if row.motor]
    return overlay_of_rows("screen.exciters", names, {"motor": None})


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=lambda case: any(exciter.motor for exciter in case.screen.exciters.values()),
    overlay=overlay,
    needs=("frame-dynamics",),
    key="screen.exciters.<name>.motor",
    checked_by="exciter_load",
    saves=True,
)
