"""The longest stable sync intervals for contacts on a surface point and for panels on frames.

A contact of stiffness k and damping g touches a surface point of effective mass M; its force is k
times the overlap plus g times the rate of the overlap.  ``mode_rad_per_s`` is the highest angular
frequency w at which that point can vibrate; it is 0 for a free mass.  Frames have matrices over the
free frames' coordinates: M of the frames alone, K of the panels as massless springs, and X with the
shapes of all modes of the whole machine.  docs/theory/stability.md has the derivations, and limits
that a bisection found.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

from orchestrator.ports import Array

MASS_SHARE = 0.8
"""Share of the mass that counts.  A sphere as heavy as the point on which it rests makes the interval
up to a tenth shorter than a fixed sphere does (scan of 288 linear pairs: docs/measured/stability.md)."""
SPHERE_SHARE = 0.5
"""Share of the estimate for a free sphere under robin that counts.  The real limit was 0.57 to 1.06 of
the estimate for m/M from 1 to 10^4 and restitution from 0.13 to 0.99."""


def light_point_s(
    stiffness_N_per_m: float, damping_N_s_per_m: float, mass_kg: float, mode_rad_per_s: float = 0.0
) -> float:
    """Return the limit of particles-first for a contact on a surface point.

    The surface drifts through the interval H, so the contact pushes it back too late.  The point
    swings from side to side, interval by interval, if H is above the solution of

        (g + k H / 2) tan(w H / 2) = M w,

    or, for a free mass (w = 0), above (sqrt(g^2 + 4 k M) - g) / k.
    """
    k, g, mass = stiffness_N_per_m, damping_N_s_per_m, MASS_SHARE * mass_kg
    free_s = 2 * mass / g if k == 0 else 4 * mass / (math.sqrt(g * g + 4 * k * mass) + g)
    if mode_rad_per_s == 0:
        return free_s
    w, end = mode_rad_per_s, math.pi / mode_rad_per_s

    def excess(share: float) -> float:
        h = share * end
        return (g + k * h / 2) * math.sin(w * h / 2) - mass * w * math.cos(w * h / 2)

    return end * float(brentq(excess, 0.0, 1.0))


def resting_mode_s(stiffness_N_per_m: float, damping_N_s_per_m: float, mode_rad_per_s: float) -> float:
    """Return the limit of particles-first for a contact that lasts on a vibrating surface.

    Within the interval, its damper sees an old velocity and its spring an old place.  Together they
    drive the mode unless

        tan(x) - x < g w / k,    x = w H / 2.

    The limit is infinite without a damper, because such a contact does not last.
    """
    k, g, w = stiffness_N_per_m, damping_N_s_per_m, mode_rad_per_s
    if g == 0 or w == 0:
        return math.inf
    if k == 0:
        return math.pi / w

    def excess(share: float) -> float:
        x = share * math.pi / 2
        return math.sin(x) - (x + g * w / k) * math.cos(x)

    return math.pi / w * float(brentq(excess, 0.0, 1.0))


def rocking_s(stiffness_N_per_m: float, damping_N_s_per_m: float, sphere_kg: float, mass_kg: float) -> float:
    """Return the limit of particles-first for a free sphere m that stays on a free point.

    ``resting_mode_s`` gives it with the frequency of the pair and the damping over the point's share.
    """
    w, share = _pair(stiffness_N_per_m, sphere_kg, mass_kg)
    return resting_mode_s(stiffness_N_per_m, damping_N_s_per_m / share, w)


def _pair(stiffness_N_per_m: float, sphere_kg: float, mass_kg: float) -> tuple[float, float]:
    """Return the frequency of a free sphere m on a free point and the point's share in the motion.

    The frequency follows from w^2 = k / m + k / M, and the share is m / (m + M).
    """
    w = math.sqrt(stiffness_N_per_m / sphere_kg + stiffness_N_per_m / mass_kg)
    return w, sphere_kg / (sphere_kg + mass_kg)


def foreseen_mode_s(
    stiffness_N_per_m: float, damping_N_s_per_m: float, mass_kg: float, mode_rad_per_s: float
) -> float:
    """Return the limit of robin for a fixed sphere on a vibrating point.

    robin predicts the chord of the point as if a change of the load moved a free mass.  A mode moves
    less, by b = H^2 / (2 M) (1 - sin^2(w H / 2) / (w H / 2)^2), and robin learns that an interval
    later.  The sphere cannot drive the mode while

        2 b max_u u (k^2 H / (4 g) (1 + u) + g / H (1 - u)) < 1,    0 < u < 1.

    The limit is infinite for a free mass.  Contacts without a damper do not last, and have the limit
    of ``light_point_s``.
    """
    k, g, w = stiffness_N_per_m, damping_N_s_per_m, mode_rad_per_s
    if w == 0:
        return math.inf
    if g == 0:
        return light_point_s(k, g, mass_kg, w)

    def excess(exponent: float) -> float:
        h = math.exp(exponent) / w
        surplus = h * h / (2 * mass_kg) * (1 - (math.sin(w * h / 2) / (w * h / 2)) ** 2)
        return 2 * surplus * _largest(k * k * h / (4 * g), g / h) - 1

    return math.exp(_crossing(excess)) / w


def foreseen_sphere_s(
    stiffness_N_per_m: float, damping_N_s_per_m: float, sphere_kg: float, mass_kg: float
) -> float:
    """Return the limit of robin for a free sphere m on a free point M.

    The midpoint rule that predicts the load of the sphere is off by the shares k H^2 / (12 m) of the
    spring's part and (g H / m)^2 / 12 of the damper's.  These parts act on the point by k H^2 / (2 M)
    and g H / (2 M).  The scheme is stable below ``SPHERE_SHARE`` times the solution H of

        (k H^2 / (2 M)) (k H^2 / (12 m)) + (g H / (2 M)) (g H / m)^2 / 12 = 1.

    This estimate was checked against the loop, and is not derived.
    """
    k, g, m = stiffness_N_per_m, damping_N_s_per_m, sphere_kg
    if k == 0 and g == 0:
        return math.inf
    unit_s = math.sqrt(m / k) if k > 0 else m / g

    def excess(exponent: float) -> float:
        h = math.exp(exponent) * unit_s
        spring = k * h * h / (2 * mass_kg) * (k * h * h / (12 * m))
        return spring + g * h / (2 * mass_kg) * (g * h / m) ** 2 / 12 - 1

    return SPHERE_SHARE * math.exp(_crossing(excess)) * unit_s


def late_contact_s(
    stiffness_N_per_m: float, damping_N_s_per_m: float, mass_kg: float, mode_rad_per_s: float = 0.0
) -> float:
    """Return the limit of serial-staggered for a contact on a surface point.

    The force comes an interval late, which acts like the damping -k H, and a late damper overshoots.
    The scheme is stable below the H from

        1 / H = w / arctan(g w / k) + g / (2 M),    or k / g + g / (2 M) for w = 0.

    The limit is 0 without a damper, because nothing removes the energy that the late force adds.
    """
    k, g, w = stiffness_N_per_m, damping_N_s_per_m, mode_rad_per_s
    if k == 0 and g == 0:
        return math.inf
    if g == 0:
        return 0.0
    late = k / g if w == 0 else w / math.atan2(g * w, k)
    return 1 / (late + g / (2 * mass_kg))


def late_rocking_s(
    stiffness_N_per_m: float, damping_N_s_per_m: float, sphere_kg: float, mass_kg: float
) -> float:
    """Return the limit of serial-staggered for a free sphere m on a free point.

    The formula of ``late_contact_s`` gives it with the frequency of the pair and, inside the
    arctangent, the damping over the point's share.
    """
    k, g = stiffness_N_per_m, damping_N_s_per_m
    if g == 0:
        return 0.0 if k > 0 else math.inf
    w, share = _pair(k, sphere_kg, mass_kg)
    late = w / math.atan2(g * w, k * share)
    return 1 / (late + g / (2 * mass_kg))


def _largest(one: float, other: float) -> float:
    """Return the largest value of u (one (1 + u) + other (1 - u)) for u from 0 to 1."""
    if other <= 3 * one:  # it grows up to u = 1
        return 2 * one
    return (one + other) ** 2 / (4 * (other - one))


def _crossing(excess: Callable[[float], float]) -> float:
    """Return the lowest exponent at which ``excess``, negative far below, is zero."""
    before, step = -20.0, 0.05
    while excess(before + step) < 0:
        before += step
    return float(brentq(excess, before, before + step))


EXTRAPOLATING = ("particles-first", "robin", "aitken", "quasi-newton")  # schemes that extrapolate the clamps
LARGEST_MASS = dict.fromkeys(EXTRAPOLATING, 1 / 3) | {"serial-staggered": 0.95}
"""Largest ratio r of the mass that a frame carries stiffly to its own mass, by scheme.

Above it, the frame's acceleration, fed back through the panels' inertia, grows at any interval.
``EXTRAPOLATING`` schemes extrapolate the acceleration, z^2 + 2 r z - r = 0.  serial-staggered returns it,
z = -r, and is stable below 1, less a margin for bushings (measured: 0.99 if they swing by a quarter of
a radian in an interval).  Causin, P., Gerbeau, J.-F. and Nobile, F., Computer Methods in Applied
Mechanics and Engineering 194, 2005, 4506-4527, doi 10.1016/j.cma.2004.12.005, treat loads from more
mass than they act on."""


def extrapolated_clamps_s(mass: Array, panels_N_per_m: Array) -> float:
    """Return the limit of ``EXTRAPOLATING`` schemes, which extrapolate the clamps with the last acceleration.

    They are stable, and damped, for w H < 1, where w is the highest frequency of the frames on the
    panels' springs alone.
    """
    highest_rad_per_s = swing_on_panels_rad_per_s(mass, panels_N_per_m)
    return 1 / highest_rad_per_s if highest_rad_per_s > 0 else math.inf


def swing_on_panels_rad_per_s(mass: Array, panels_N_per_m: Array) -> float:
    """Return the highest angular frequency of the frames on the panels' springs alone."""
    highest = float(eigh(panels_N_per_m, mass, eigvals_only=True)[-1])
    return math.sqrt(max(highest, 0.0))


GROWING = 1.373, 4.017
"""The radians in an interval between which a panel's vibration along itself grows."""
GROWTH = 0.480
"""The most that such a vibration grows in a radian, over the square of the frames' radians in an interval.

Both numbers follow from one vibration of a bar on a frame with extrapolated clamps, to first order in the
bar's mass over the frame's (docs/theory/stability.md, vibrating panels)."""


def vibrating_panels_s(
    frames_rad_per_s: float, panels_rad_per_s: float, loss_factor: Callable[[float], float]
) -> float:
    """Return the limit of ``EXTRAPOLATING`` schemes for the panels' vibrations along themselves.

    A frame returns the force of a vibration late.  An interval is short enough if it resolves the panels'
    highest frequency, ``panels_rad_per_s``, or if their damping outweighs the growth.  ``loss_factor`` gives
    it at an angular frequency, and ``frames_rad_per_s`` is the highest of the frames on the panels' springs
    alone.  The limit is 0 if the frequency is infinite and nothing damps it.
    """

    def is_damped(interval_s: float) -> bool:
        least = min(loss_factor(radians / interval_s) for radians in GROWING)
        return GROWTH * (frames_rad_per_s * interval_s) ** 2 < least / 2

    resolved_s = GROWING[0] / panels_rad_per_s
    longest_s = 1 / frames_rad_per_s
    damped = filter(is_damped, np.geomspace(longest_s, max(resolved_s, 1e-6 * longest_s), 300))
    return max(resolved_s, next(damped, 0.0)) if resolved_s < longest_s else longest_s


def late_reaction_s(shapes: Array, panels_N_per_m: Array, damping_N_s_per_m: Array) -> float:
    """Return the limit of serial-staggered for the panels' force on the frames.

    The force comes an interval late, which acts like the damping -K H.  The machine's own damping of
    every mode X (a column of ``shapes``) must be larger, so that H < X C X / X K X.
    """
    driven = np.einsum("im,ij,jm->m", shapes, panels_N_per_m, shapes)
    damped = np.einsum("im,ij,jm->m", shapes, damping_N_s_per_m, shapes)
    felt = driven > 1e-9 * driven.max(initial=0.0)
    return float(np.min(damped[felt] / driven[felt], initial=math.inf))


def carried_share(mass: Array, carried: Array) -> float:
    """Return the largest ratio of carried mass to the frames' own, over all their motions."""
    return float(eigh(carried, mass, eigvals_only=True)[-1])
