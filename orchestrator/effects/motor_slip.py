"""Motors lag behind under load: change of the stroke by the mean lag."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.casefile.case import Case
from orchestrator.planning import KNOW_MOTORS
from orchestrator.plans import Exciter
from orchestrator.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.scene.scene import Scene
from orchestrator.scene.shaking import Shaking, shakings
from orchestrator.scene.strokes import largest_stroke_m
from orchestrator.tables.frames import Motor


def judge(scene: Scene) -> Verdict | None:
    """None without motors, or without forces on the frames."""
    if not scene.plan.exciters:
        return None
    rows = scene.case.screen.exciters.values()
    plans = zip(scene.plan.exciters, (row.motor for row in rows), strict=True)
    slips = [_slip(scene, plan, motor) for plan, motor in plans if motor is not None]
    if not slips:
        return None
    slip, share = max(slips)
    slower = tuple(
        replace(one, speed_rad_s=(1 - slip) * one.speed_rad_s) for one in scene.plan.exciters
    )
    now_m = largest_stroke_m(scene, scene.shaken)
    then = shakings(replace(scene.plan, exciters=slower), scene.springs)
    change = abs(largest_stroke_m(scene, then) / now_m - 1) if now_m else 0.0
    weak = share > 1.0
    return Verdict(
        number="change of the stroke by slip",
        value=change,
        threshold="0.1",
        matters=weak or change > TENTH,
        why=f"the machine takes {share:.2g} of the rated power in the mean: a slip of {slip:.2g}",
        cost="half a millisecond per step of the frames",
    )


def _slip(scene: Scene, exciter: Exciter, motor: Motor) -> tuple[float, float]:
    """Mean slip, in proportion to the mean power, and that power over the rated one."""
    power_W = sum(_power_W(exciter, one) for one in scene.shaken)
    power_W += motor.bearing_loss_N_m_s * exciter.speed_rad_s**2
    share = power_W / motor.rated_power_W
    return motor.rated_slip * share, share


def _power_W(exciter: Exciter, shaking: Shaking) -> float:
    """Mean power of its force on the frame's motion, at its own speed."""
    if shaking.speed_rad_s != exciter.speed_rad_s:
        return 0.0
    size_N = exciter.mass_moment_kg_m * exciter.speed_rad_s**2 * np.exp(1j * exciter.phase_rad)
    force_N = size_N * (exciter.start - 1j * np.cross(exciter.axis, exciter.start))
    velocity_m_s = 1j * exciter.speed_rad_s * shaking.amplitude_m[exciter.body]
    return float((force_N.conj() @ velocity_m_s).real / 2)


def described(case: Case) -> bool:
    return any(exciter.motor for exciter in case.screen.exciters.values())


def left_out(case: Case) -> str:
    solver = case.frames.solver
    lacks = described(case) and solver not in KNOW_MOTORS
    return f"frames.solver {solver}: shafts turn at their speed_rad_s" if lacks else ""


def overlay(case: Case) -> Overlay:
    rows = {name: {"motor": None} for name, row in case.screen.exciters.items() if row.motor}
    return {"screen": {"exciters": rows}} if rows else {}


EFFECT = Effect(
    part="frames",
    judge=judge,
    described=described,
    left_out=left_out,
    overlay=overlay,
    needs=("frame-dynamics",),
    key="screen.exciters.<name>.motor",
)
