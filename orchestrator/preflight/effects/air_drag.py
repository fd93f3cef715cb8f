"""Drag of still air, which slows grains down by the square of their speed over their terminal speed.

A grain that is thrown with its terminal speed is held back by a drag as large as its weight.  Air that moves
with the bed, or that openings and mats drive, is none of it: where grains are many, drag is an upper bound.
"""

from __future__ import annotations

import math

import numpy as np

from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.tables.case import Air, Case, has_particles
from orchestrator.ports.grains import Grain
from orchestrator.ports.physics import sphere_drag_N
from orchestrator.preflight.scene.effect import MARGIN, TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import Scene

SLOWEST_AND_FASTEST_M_PER_S = 1e-9, 1e4
"""Bounds of a terminal speed."""


def terminal_speed_m_per_s(grain: Grain[float], air: Air, gravity_m_per_s2: float) -> float:
    """Return the speed at which the drag of the sphere of equal volume is the grain's weight."""

    from scipy.optimize import brentq  # takes long to import, and few commands need it

    def surplus(speed_m_per_s: float) -> float:
        return _drag_over_weight(grain, speed_m_per_s, air, gravity_m_per_s2) - 1.0

    return float(brentq(surplus, *SLOWEST_AND_FASTEST_M_PER_S))


def _drag_over_weight(grain: Grain[float], speed_m_per_s: float, air: Air, gravity_m_per_s2: float) -> float:
    size_m, speed = np.array(grain.equivalent_diameter_m), np.array(speed_m_per_s)
    drag_N = sphere_drag_N(size_m, speed, air.density_kg_per_m3, air.viscosity_Pa_s)
    return float(drag_N) / (grain.mass_kg * gravity_m_per_s2)


def judge(scene: Scene) -> Verdict:
    """Return the verdict on the throw's speed over the terminal speed of the real grain that falls slowest.

    Drag goes with nearly the square of the speed: its share of the weight is within a factor of ``MARGIN`` of
    a tenth where this number is within the root of it.
    """
    air, k, g = scene.case.air or Air(), scene.case.particles.coarse_graining, scene.gravity_m_per_s2
    real = [each.resized(each.sieve_size_m / k) for each in smallest_grains(scene.case).values()]
    slowest = min(real, key=lambda grain: terminal_speed_m_per_s(grain, air, g))
    speed_m_per_s = terminal_speed_m_per_s(slowest, air, g)
    share = _drag_over_weight(slowest, scene.impact_m_per_s, air, g)
    ratio, limit = scene.impact_m_per_s / speed_m_per_s, math.sqrt(TENTH)
    return Verdict(
        number="throw / terminal speed",
        value=ratio,
        threshold=f"{limit:.2f} (drag a tenth of the weight)",
        matters=None if limit / math.sqrt(MARGIN) < ratio <= limit else ratio > limit,
        why=(
            f"grains of {slowest.sieve_size_m * 1e3:.2g} mm fall with {speed_m_per_s:.2g} m/s in the end; "
            f"thrown with {scene.impact_m_per_s:.2g} m/s, they feel {share:.1%} of their weight as drag"
        ),
        cost="a power of a number for each particle and step",
    )


def left_out(case: Case) -> str:
    """Return the setting that leaves out the drag of a case's air; empty without one."""
    off = case.particles.air_drag == "none" and case.air is not None and has_particles(case)
    return "particles.air_drag none: grains fly as in a vacuum" if off else ""


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: case.air is not None,
    left_out=left_out,
    overlay=lambda case: {"particles": {"air_drag": "none"}},
    laws={"schiller-naumann": {"particles": {"air_drag": "schiller-naumann"}}},
    key="air",
    saves=True,
    about=("particles",),
)
