"""Maxwell branches against closed forms; no solver needed."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from adapters.panel.common.maxwell import Branches

RATIO, TIME_S = 0.3, 2e-3


def test_constant_rate_is_exact_for_any_step():
    """q = g tau rate (1 - exp(-t / tau)), to rounding."""
    branches = Branches(((RATIO, TIME_S),), 1)
    stress, rate, time_s = np.zeros(1), 5.0, 0.0
    for step_s in (1e-4, 3e-3, 2e-2):
        branches.begin(step_s, stress)
        change = np.array([rate * step_s])
        stress = stress + change
        overstress = branches.share * stress + branches.history
        branches.end(change, change)
        time_s += step_s
        exact = RATIO * TIME_S * rate * -np.expm1(-time_s / TIME_S)
        np.testing.assert_allclose(overstress, exact, rtol=1e-13)
        np.testing.assert_allclose(branches.energy_J, exact**2 / (2 * RATIO), rtol=1e-12)


def test_loss_per_cycle():
    """A cycle of amplitude 1 loses  pi g w tau / (1 + (w tau)^2)  (J. D. Ferry, Viscoelastic
    Properties of Polymers, Wiley 1980, chapter 3).  400 linear pieces per cycle: 1e-3."""
    speed = 1.0 / TIME_S
    times = np.linspace(0.0, 8 * 2 * np.pi / speed, 8 * 400 + 1)
    strain = np.sin(speed * times)
    branches = Branches(((RATIO, TIME_S),), 1)
    lost = []
    for before, after in pairwise(strain):
        branches.begin(times[1], np.array([before]))
        branches.end(np.array([after - before]), np.array([after - before]))
        lost.append(branches.lost_J)
    assert lost[-1] - lost[-401] == pytest.approx(np.pi * RATIO * 0.5, rel=1e-3)


def test_refuses_a_branch_without_time():
    with pytest.raises(ValueError, match="positive"):
        Branches(((0.1, 0.0),), 3)
