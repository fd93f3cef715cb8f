"""The shape in which a panel hangs at rest between its clamps.

The potential energy is minimised by pseudo-transient continuation: each iteration is one implicit
step of a motion that starts at rest, so that it always goes downhill, with steps that grow until
they are Newton iterations (Kelley and Keyes, SIAM J. Numer. Anal. 35 (1998) 508-523,
doi:10.1137/S0036142996304796).  It needs no damping, and slack or flat panels whose stiffness is
indefinite at first are no harder than taut ones.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.optimize import brentq

from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import Rectangle
from orchestrator.ports.plans import SolverFailed

TOLERANCE = 1e-7  # rounding in a solid leaves 1e-9 of the clamps' force
NEGLIGIBLE_MOVE = 1e-10  # of the panel's size
FIRST_STEP_S = 1e-3
GROWTH = 4.0
LARGEST_STEP_S = 1e3
ITERATIONS = 400
STEEPEST_RAD = 2.0


def first_guess_m(rectangle: Rectangle, side: float, material_m: Array) -> Array:
    """Return world positions (n, 3) of material points (n, 3): s, y, and height over the mid-surface.

    A taut panel is straight between its clamps.  A slack one is unstretched with the slope angle
    of a lightly buckled clamped beam (a sine), bulging up or down as ``side`` is 1 or -1.
    """
    s, height = material_m[:, 0], material_m[:, 2]
    end = rectangle.end(material_m[:, :2])
    clamped = ~np.isnan(end)
    straight = rectangle.mounted(material_m[:, :2])
    straight += height[:, None] * _normals(rectangle, end)
    if rectangle.span_m >= rectangle.length_m:
        return np.asarray(straight)
    fine = np.linspace(0.0, rectangle.length_m, 4001)
    angle = side * _angle_rad(rectangle.length_m, rectangle.span_m, fine)
    turn = np.interp(s, fine, angle)
    x = np.interp(s, fine, cumulative_trapezoid(np.cos(angle), fine, initial=0.0))
    z = np.interp(s, fine, cumulative_trapezoid(np.sin(angle), fine, initial=0.0))
    bulging = (
        rectangle.corner_m
        + np.outer(x - height * np.sin(turn), rectangle.along)
        + np.outer(material_m[:, 1], rectangle.across)
        + np.outer(z + height * np.cos(turn), rectangle.normal)
    )
    return np.where(clamped[:, None], straight, bulging)


def _normals(rectangle: Rectangle, end: Array) -> Array:
    """Return the unit normals (n, 3) of a straight panel between its clamps, which may be turned.

    ``end`` (n,) is the clamp of each point, 0 or 1, or NaN between them.
    """
    normals = np.tile(rectangle.normal, (len(end), 1))
    if rectangle.clamp_angle_deg:
        for number, tangent in enumerate(rectangle.clamp_tangents):
            normals[end == number] = np.cross(tangent, rectangle.across)
    return normals


def _angle_rad(length_m: float, span_m: float, s_m: Array) -> Array:
    """Return the slope angle along an unstretched strip whose ends are ``span_m`` apart."""
    wave = np.sin(2 * np.pi * s_m / length_m)

    def too_long_m(amplitude_rad: float) -> float:
        return float(trapezoid(np.cos(amplitude_rad * wave), s_m)) - span_m

    if too_long_m(STEEPEST_RAD) > 0.0:
        raise ValueError(f"span {span_m} m is too short for a panel of {length_m} m")
    angle: Array = brentq(too_long_m, 0.0, STEEPEST_RAD) * wave
    return angle


def settle(structure: Structure, tangent: Tangent, start_m: Array, weight_N: Array) -> Array:
    """Return the positions (nodes, 3) at which ``weight_N`` and the internal force balance, from ``start_m``.

    The forces balance within ``TOLERANCE`` of the clamps' force or, where rounding forbids that, a Newton
    iteration moves the nodes by less than ``NEGLIGIBLE_MOVE``.  Raises SolverFailed if such positions cannot
    be found.
    """
    free, size_m = ~structure.fixed, float(np.ptp(start_m, axis=0).max())
    position, step_s, moved_m = start_m.copy(), FIRST_STEP_S, np.inf
    force = structure.force_N(position)
    for _ in range(ITERATIONS):
        imbalance = _norm(weight_N - force, free)
        scale = max(_norm(force, structure.held), _norm(weight_N, free))
        if imbalance <= TOLERANCE * scale or moved_m <= NEGLIGIBLE_MOVE * size_m:
            return position
        structure.force_N(position)
        tangent.factorise(step_s**-2, 1.0)
        move = tangent.solve(weight_N - force)
        trial = structure.force_N(position + move)
        # downhill, by the mean force on the way: the energy itself loses digits near the end
        gained_J = np.vdot((weight_N - 0.5 * (force + trial))[free], move[free])
        if gained_J > 0.0 or _norm(weight_N - trial, free) < imbalance:
            position, force = position + move, trial
            moved_m = float(np.abs(move).max()) if step_s == LARGEST_STEP_S else np.inf
            step_s = min(GROWTH * step_s, LARGEST_STEP_S)
        else:
            step_s *= 0.25
    raise SolverFailed(
        f"no resting shape after {ITERATIONS} iterations; out of balance by "
        f"{imbalance / scale:.1e} of the clamps' force (wanted {TOLERANCE:.0e})"
    )


def _norm(force_N: Array, chosen: Indices | npt.NDArray[np.bool_]) -> float:
    return float(np.linalg.norm(force_N[chosen]))
