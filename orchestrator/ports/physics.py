"""Constants and formulas of physics that every room shares."""

from __future__ import annotations

import math

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import MotorPlan

STANDARD_GRAVITY_M_PER_S2 = 9.80665
"""The acceleration that is called 1 g (3rd General Conference on Weights and Measures, 1901)."""


def motor_torque_N_m(motor: MotorPlan, lag_rad_per_s: Array) -> Array:
    """Return an induction motor's torque at a lag of its shaft behind the synchronous speed.

    Kloss, Archiv fuer Elektrotechnik 5, 1916, 59-87: 2 T d D / (d^2 + D^2) at the lag d, where T is
    the breakdown torque, at the lag D.
    """
    rated_rad_per_s = motor.rated_slip * motor.synchronous_rad_per_s
    rated_N_m = motor.rated_power_W / (motor.synchronous_rad_per_s - rated_rad_per_s)
    surplus = motor.breakdown_ratio
    breakdown_rad_per_s = rated_rad_per_s * (surplus + math.sqrt(surplus**2 - 1))
    twice_N_m = 2 * surplus * rated_N_m * breakdown_rad_per_s
    return np.asarray(twice_N_m * lag_rad_per_s / (lag_rad_per_s**2 + breakdown_rad_per_s**2))
