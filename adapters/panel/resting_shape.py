"""The shape in which a panel hangs at rest between its clamps.

The potential energy is minimised by pseudo-transient continuation: each iteration is one implicit
step of a motion that starts at rest, so that it always goes downhill, with steps that grow until
they are Newton iterations (Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523,
doi:10.1137/S0036142996304796).  It needs no damping, and slack or flat panels whose stiffness is
indefinite at first are no harder than taut ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.optimize import brentq

from adapters.panel.structure import Structure
from adapters.panel.tangent import Tangent
from orchestrator.geometry import Rectangle
from orchestrator.plans import SolverFailed
from orchestrator.ports import Array, Indices

TOLERANCE = 1e-9  # out-of-balance force over the forces at the clamps
FIRST_STEP_S = 1e-3
LARGEST_STEP_S = 1e6
ITERATIONS = 400
STEEPEST_RAD = 2.0


@dataclass(frozen=True)
class Guess:
    """Mid-surface positions and unit normals, each (n, 3)."""

    position_m: Array
    normal: Array


def first_guess(rectangle: Rectangle, gravity_m_s2: Array, coordinates_m: Array) -> Guess:
    """A taut panel straight between its clamps; a slack one unstretched, with the slope angle of
    a lightly buckled clamped beam (a sine), bulging with gravity or, without it, downwards."""
    if rectangle.span_m >= rectangle.length_m:
        normal = np.broadcast_to(rectangle.normal, (len(coordinates_m), 3))
        return Guess(rectangle.mounted(coordinates_m), normal)
    s, length_m = coordinates_m[:, 0], rectangle.length_m
    side = 1.0 if gravity_m_s2 @ rectangle.normal > 0.0 else -1.0
    fine = np.linspace(0.0, length_m, 4001)
    angle = side * _angle_rad(length_m, rectangle.span_m, fine)
    along = cumulative_trapezoid(np.cos(angle), fine, initial=0.0)
    bulge = cumulative_trapezoid(np.sin(angle), fine, initial=0.0)
    x = np.interp(s, fine, along) + s - np.clip(s, 0.0, length_m)
    position = (
        rectangle.corner_m
        + np.outer(x, rectangle.along)
        + np.outer(coordinates_m[:, 1], rectangle.across)
        + np.outer(np.interp(s, fine, bulge), rectangle.normal)
    )
    clamped = ~np.isnan(rectangle.end(coordinates_m))
    position[clamped] = rectangle.mounted(coordinates_m[clamped])
    turn = np.interp(s, fine, angle)
    normal = np.outer(np.cos(turn), rectangle.normal) - np.outer(np.sin(turn), rectangle.along)
    return Guess(position, normal)


def _angle_rad(length_m: float, span_m: float, s_m: Array) -> Array:
    """Slope angle along an unstretched strip whose ends are ``span_m`` apart."""
    wave = np.sin(2 * np.pi * s_m / length_m)

    def too_long_m(amplitude_rad: float) -> float:
        return float(trapezoid(np.cos(amplitude_rad * wave), s_m)) - span_m

    if too_long_m(STEEPEST_RAD) > 0.0:
        raise ValueError(f"span {span_m} m is too short for a panel of {length_m} m")
    angle: Array = brentq(too_long_m, 0.0, STEEPEST_RAD) * wave
    return angle


def settle(
    structure: Structure, tangent: Tangent, start_m: Array, weight_N: Array, name: str
) -> Array:
    """Positions (nodes, 3) at which ``weight_N`` and the internal force balance, from
    ``start_m``; SolverFailed with ``name`` if they cannot be found."""
    free = structure.free
    position, step_s = start_m.copy(), FIRST_STEP_S
    force = structure.force_N(position)
    imbalance = _norm(weight_N - force, free)
    for _ in range(ITERATIONS):
        scale = max(_norm(force, structure.held), _norm(weight_N, free))
        if imbalance <= TOLERANCE * scale:
            return position
        structure.force_N(position)
        tangent.factorise(step_s**-2, 1.0)
        move = tangent.solve(weight_N - force)
        trial_force = structure.force_N(position + move)
        # downhill, by the mean force on the way: the energy itself loses digits near the end
        gained_J = np.vdot((weight_N - 0.5 * (force + trial_force))[free], move[free])
        trial_imbalance = _norm(weight_N - trial_force, free)
        if np.isfinite(trial_imbalance) and (gained_J > 0.0 or trial_imbalance < imbalance):
            position += move
            force, imbalance = trial_force, trial_imbalance
            step_s = min(2.0 * step_s, LARGEST_STEP_S)
        else:
            step_s *= 0.25
    raise SolverFailed(
        f"panel {name}, t = 0: no resting shape after {ITERATIONS} iterations; out of balance "
        f"by {imbalance / scale:.1e} of the clamps' force (wanted {TOLERANCE:.0e})"
    )


def _norm(force_N: Array, nodes: Indices) -> float:
    return float(np.linalg.norm(force_N[nodes]))
