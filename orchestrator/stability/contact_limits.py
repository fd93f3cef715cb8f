"""The longest stable sync interval for contacts on a surface point, scheme by scheme.

A contact of stiffness k and damping g (its force k times overlap + g times its rate) touches a
surface point of effective mass M.  ``mode_rad_s`` is the highest angular frequency w with which
that point can vibrate; 0 for a free mass.  Derivations and the limits found by bisection:
docs/theory/stability.md.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from scipy.optimize import brentq

HELD = 0.8
"""Share of the mass that counts: a sphere as heavy as the point it rests on makes the interval up
to a tenth shorter than a held one does (scan of 288 linear pairs: docs/theory/stability.md)."""


def light_point_s(
    stiffness_N_m: float, damping_N_s_m: float, mass_kg: float, mode_rad_s: float = 0.0
) -> float:
    """particles-first: the surface drifts through the interval H, so the contact pushes it back
    too late.  The point swings from side to side, interval by interval, from

        (g + k H / 2) tan(w H / 2) = M w,

    on; of a free mass (w = 0) from H = (sqrt(g^2 + 4 k M) - g) / k.
    """
    k, g, mass = stiffness_N_m, damping_N_s_m, HELD * mass_kg
    free_s = 2 * mass / g if k == 0 else 4 * mass / (math.sqrt(g * g + 4 * k * mass) + g)
    if mode_rad_s == 0:
        return free_s
    w, end = mode_rad_s, math.pi / mode_rad_s

    def excess(share: float) -> float:
        h = share * end
        return (g + k * h / 2) * math.sin(w * h / 2) - mass * w * math.cos(w * h / 2)

    return end * _root(excess)


def resting_mode_s(stiffness_N_m: float, damping_N_s_m: float, mode_rad_s: float) -> float:
    """particles-first, a contact that lasts on a vibrating surface: within the interval its damper
    sees an old velocity and its spring an old place, and together they drive the mode unless

        tan(w H / 2) - w H / 2 < g w / k.

    Infinite without a damper: such a contact does not last.
    """
    k, g, w = stiffness_N_m, damping_N_s_m, mode_rad_s
    if g == 0 or w == 0:
        return math.inf
    return 2 / w * _phase(g * w / k if k > 0 else math.inf)


def rocking_s(
    stiffness_N_m: float, damping_N_s_m: float, sphere_kg: float, mass_kg: float
) -> float:
    """particles-first, a free sphere m that stays on a free point: like ``resting_mode_s`` with the
    frequency of the pair, w^2 = k / m + k / M, and the point's share in it, m / (m + M)."""
    k, g = stiffness_N_m, damping_N_s_m
    if g == 0 or k == 0:
        return math.inf
    w = math.sqrt(k / sphere_kg + k / mass_kg)
    share = sphere_kg / (sphere_kg + mass_kg)
    return 2 / w * _phase(g * w / k / share)


def late_contact_s(
    stiffness_N_m: float, damping_N_s_m: float, mass_kg: float, mode_rad_s: float = 0.0
) -> float:
    """serial-staggered: the force comes an interval late, which is the damping -k H; and a damper
    that comes late overshoots.  Stable below

        1 / H = w / arctan(g w / k) + g / (2 M),    k / g + g / (2 M) for w = 0;

    0 without a damper: nothing takes out what the late force adds.
    """
    k, g, w = stiffness_N_m, damping_N_s_m, mode_rad_s
    if k == 0 and g == 0:
        return math.inf
    if g == 0:
        return 0.0
    late = k / g if w == 0 else w / math.atan2(g * w, k)
    return 1 / (late + g / (2 * mass_kg))


def late_rocking_s(
    stiffness_N_m: float, damping_N_s_m: float, sphere_kg: float, mass_kg: float
) -> float:
    """serial-staggered, a free sphere m on a free point; as ``late_contact_s`` with the frequency
    of the pair, and the damper over the point's share m / (m + M)."""
    k, g = stiffness_N_m, damping_N_s_m
    if g == 0:
        return 0.0 if k > 0 else math.inf
    w = math.sqrt(k / sphere_kg + k / mass_kg)
    share = sphere_kg / (sphere_kg + mass_kg)
    late = w / math.atan2(g * w, k * share)
    return 1 / (late + g / (2 * mass_kg))


def _phase(ratio: float) -> float:
    """x in (0, pi/2) with tan(x) - x = ratio."""
    if math.isinf(ratio):
        return math.pi / 2

    def excess(share: float) -> float:
        x = share * math.pi / 2
        return math.sin(x) - (x + ratio) * math.cos(x)

    return math.pi / 2 * _root(excess)


def _root(excess: Callable[[float], float]) -> float:
    """The share in [0, 1] where ``excess``, negative before and positive after, is zero."""
    return float(brentq(excess, 0.0, 1.0))
