"""What the clamps' forces of a run tell of its panels: as springs, and which frequencies move them.

Forces and motion are rows of the window that other motion is taken from.
"""

from __future__ import annotations

import math

import numpy as np

from orchestrator.case.file.loss_curve import moduli
from orchestrator.ports import Array
from orchestrator.ports.plans import Hyperelastic
from orchestrator.preflight.scene.moved_panel import MovedPanel


def spring_N_per_m(time_s: Array, pull_N: Array, stretch_m: Array, speed_rad_per_s: float) -> float | None:
    """Stiffness of the spring with the first harmonic of a panel's pull (rows,) in phase with the
    stretch of its ends (rows,); None where nothing stretches it."""
    stretch_m = np.broadcast_to(stretch_m, pull_N.shape)  # one row where both ends stand still
    pull, stretch = (_harmonic(time_s, one, speed_rad_per_s) for one in (pull_N, stretch_m))
    if abs(stretch) < 1e-9:
        return None
    return max(0.0, float((pull / stretch).real))


def _harmonic(time_s: Array, values: Array, speed_rad_per_s: float) -> complex:
    """Complex amplitude at one speed, by least squares."""
    phase = speed_rad_per_s * time_s
    columns = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])
    _, cosine, sine = np.linalg.lstsq(columns, values, rcond=None)[0]
    return complex(cosine, -sine)


def loss_factor(panel: MovedPanel, time_s: Array, pull_N: Array) -> float | None:
    """Of the panel's material, weighted with the square of the pull's amplitude at each
    frequency: as if stiffness did not depend on it, with the energy stored there."""
    steps = np.diff(time_s)
    power_N2 = np.abs(np.fft.rfft(np.hanning(len(pull_N)) * (pull_N - pull_N.mean()))) ** 2
    speed_rad_per_s = 2 * math.pi * np.fft.rfftfreq(len(pull_N), float(steps.mean()))
    if power_N2[1:].sum() == 0.0:
        return None
    return float(np.average(_factors(panel.material, speed_rad_per_s[1:]), weights=power_N2[1:]))


def _factors(law: Hyperelastic, speed_rad_per_s: Array) -> Array:
    return moduli(law.branches, speed_rad_per_s)[1]
