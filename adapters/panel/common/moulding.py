"""The stress-free shape of a panel that is moulded with a sag, and its curvature.

The slope angle along the free length L is  -A sin(2 pi s / L):  a full wave, whose ends are parallel to the
line between them, as those of a flat panel are.  Its middle hangs  h = L/2 H0(A)  below the ends, with the
Struve function H0 (Abramowitz and Stegun, Handbook of Mathematical Functions, 1964, 12.1.7), so that A is
nearly pi h / L.  A uniform curvature would not do: between clamps that hold position and slope it makes a
moment alike everywhere, which moves nothing.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq
from scipy.special import struve

from orchestrator.ports.plans import PanelPlan

STEEPEST_RAD = 1.5


def slope_amplitude_rad(length_m: float, sag_m: float) -> float:
    """Return the amplitude A of the slope angle; 0 for a panel without a moulded sag.

    Raises ValueError for a sag that no such shape has.
    """
    if not sag_m:
        return 0.0
    if 2 * sag_m / length_m >= float(struve(0, STEEPEST_RAD)):
        raise ValueError(f"a moulded sag of {sag_m:g} m is too deep for a panel of {length_m:g} m")
    return float(brentq(lambda angle: struve(0, angle) - 2 * sag_m / length_m, 0.0, STEEPEST_RAD))


def curvature_amplitude_1_m(plan: PanelPlan) -> float:
    """Return the amplitude of the moulded curvature  -amplitude cos(2 pi s / L), positive where the shape
    turns up.

    It is a turn per length of the stress-free panel.
    """
    length_m = plan.rectangle.length_m
    return 2 * math.pi / length_m * slope_amplitude_rad(length_m, plan.moulded_sag_m)


def side_of_sag(plan: PanelPlan) -> float:
    """Return 1 if a slack panel bulges up when it is opened, and -1 if it bulges down.

    It bulges to where its clamps point or to its moulded sag, else with gravity or, without it, downwards.
    """
    pointed = plan.rectangle.clamp_angle_deg or plan.moulded_sag_m
    if pointed:
        return -1.0 if pointed > 0.0 else 1.0
    return 1.0 if plan.gravity_m_per_s2 @ plan.rectangle.normal > 0.0 else -1.0
