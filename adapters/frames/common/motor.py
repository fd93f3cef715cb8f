"""What an induction motor gives its shaft.

Torque after Kloss, Archiv fuer Elektrotechnik 5, 1916, 59-87: 2 T d D / (d^2 + D^2) at the lag d
behind the synchronous speed, T the breakdown torque at the lag D.  The synchronous speed runs up
as an exciter's does, at constant voltage over frequency.
"""

from __future__ import annotations

import math

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.plans import Exciter, Motor


def torque_N_m(motor: Motor, lag_rad_per_s: Array) -> Array:
    """``lag_rad_per_s``: synchronous speed less the shaft's."""
    rated_rad_per_s = motor.rated_slip * motor.synchronous_rad_per_s
    rated_N_m = motor.rated_power_W / (motor.synchronous_rad_per_s - rated_rad_per_s)
    surplus = motor.breakdown_ratio
    breakdown_rad_per_s = rated_rad_per_s * (surplus + math.sqrt(surplus**2 - 1))
    twice_N_m = 2 * surplus * rated_N_m * breakdown_rad_per_s
    return np.asarray(twice_N_m * lag_rad_per_s / (lag_rad_per_s**2 + breakdown_rad_per_s**2))


def synchronous_rad_per_s(exciter: Exciter, motor: Motor, time_s: Array) -> Array:
    full, run_up_s = motor.synchronous_rad_per_s, exciter.run_up_s
    if run_up_s <= 0:
        return np.full_like(time_s, full)
    share = np.clip((time_s - exciter.start_s) / run_up_s, 0.0, 1.0)
    return np.asarray(full * (1 - np.cos(np.pi * share)) / 2)
