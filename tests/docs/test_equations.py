"""Equations of the theory pages against the code, or against numbers where no code has them."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import trapezoid

from orchestrator.ports import HermitePath, Motion
from orchestrator.preflight.stability.limits import (
    MASS_SHARE,
    extrapolated_clamps_s,
    late_contact_s,
    light_point_s,
)
from tests.reference.spheres.laws import NormalLaw

PULL_OFF_N = 1.5 * math.pi  # of w = R* = 1
NECK_M = (math.pi / 8) ** (1 / 3)  # where it snaps, of w = E* = R* = 1
GAP_M = 3 * NECK_M**2


def spectral_radius(*coefficients: float) -> float:
    """The largest size of a root of a polynomial, highest power first."""
    return float(np.abs(np.roots(coefficients)).max())


def jkr(overlap_m: float) -> float:
    """Force over pull-off force at an overlap, with w = E* = R* = 1."""
    index = np.zeros(1, dtype=int)
    law = NormalLaw(np.ones((1, 1)), np.ones((1, 1)), np.zeros((1, 1)), 10.0)
    pair = SimpleNamespace(materials=(index, index), reduced_radius_m=np.ones(1))
    at = law.at(pair, np.array([overlap_m]))
    return float(at.force_N[0]) / PULL_OFF_N


def test_jkr_by_the_table_of_adhesion() -> None:
    assert jkr(0.0) == pytest.approx(-8 / 9, rel=1e-9)
    assert jkr(-GAP_M) == pytest.approx(-5 / 9, rel=1e-6)
    without_load_m = GAP_M * (36 ** (2 / 3) - 4 * 36 ** (1 / 6)) / 3
    assert jkr(without_load_m) == pytest.approx(0.0, abs=1e-9)
    slope = (jkr(without_load_m + 1e-6) - jkr(without_load_m - 1e-6)) / 2e-6 * GAP_M
    assert slope == pytest.approx(0.99, abs=1e-3)
    lost = -trapezoid([jkr(-GAP_M * s) for s in np.linspace(1, 0, 2001)], dx=GAP_M / 2000) * PULL_OFF_N
    assert lost == pytest.approx(7.09, rel=1e-3)


def test_the_hermite_path_is_off_by_384ths() -> None:
    """The path of t^4 is off by its fourth derivative, 24, over 384."""
    zero = np.zeros((1, 3))
    path = HermitePath(Motion(zero, zero), Motion(zero + 1, zero + 4), 1.0)
    t = np.linspace(0, 1, 2001)
    place = [path.position_m(share)[0, 0] - share**4 for share in t]
    velocity = [path.velocity_m_per_s(share)[0, 0] - 4 * share**3 for share in t]
    assert np.abs(place).max() == pytest.approx(24 / 384, rel=1e-5)
    assert np.abs(velocity).max() == pytest.approx(24 * math.sqrt(3) / 216, rel=1e-5)


@pytest.mark.parametrize(("stiffness", "damping"), [(3.0, 0.7), (1.0, 0.0), (0.5, 4.0)])
def test_a_light_point_leaves_the_unit_circle_at_its_limit(stiffness: float, damping: float) -> None:
    k, g, M = stiffness, damping, 1.0
    H = light_point_s(k, g, M / MASS_SHARE)
    trace, determinant = 2 - k * H**2 / M - g * H / M, 1 - g * H / M
    assert min(np.roots([1, -trace, determinant]).real) == pytest.approx(-1.0, abs=1e-9)


@pytest.mark.parametrize("damped", [0.05, 0.3, 1.0])
def test_a_late_contact_is_stable_by_jury_s_criterion(damped: float) -> None:
    """The bound lies on the safe side of the criterion."""
    limit = (damped - damped**2 / 2) / (1 - damped / 6)

    def radius(stiff: float) -> float:
        return spectral_radius(1, damped / 2 + stiff / 6 - 2, 1 + 2 * stiff / 3, stiff / 6 - damped / 2)

    assert radius(0.99 * limit) < 1 < radius(1.01 * limit)
    assert late_contact_s(limit, damped, 1.0) <= 1.0


def test_extrapolated_clamps_are_damped_below_their_limit() -> None:
    def radius(k: float) -> float:
        return spectral_radius(1, 5 * k / 6 - 2, 1 + 2 * k / 3, -5 * k / 6, k / 3)

    assert radius(0.99) < 1 < radius(1.01)
    assert extrapolated_clamps_s(np.eye(1), 4.0 * np.eye(1)) == pytest.approx(0.5)


def test_two_masses_by_the_published_amplitudes() -> None:
    """Resonances and the still driving frame of theory/machine.md."""
    M1, M2, ks, Kg = 762.0, 287.0, 2.37e6, 0.9e6
    squares = np.linalg.eigvals(np.linalg.solve(np.diag([M1, M2]), [[Kg + ks, -ks], [-ks, ks]]))
    assert math.sqrt(max(squares)) == pytest.approx(108, abs=0.5)
    assert math.sqrt(ks / M2) == pytest.approx(91, abs=0.5)
    assert math.sqrt(min(squares)) == pytest.approx(29, abs=0.5)


def test_the_layer_on_a_stop_keeps_areas() -> None:
    q = 1.3
    matrix = np.array([[1 - q / 2, 1 - q / 4], [-q, 1 - q / 2]])
    assert np.linalg.det(matrix) == pytest.approx(1.0)
    assert np.trace(matrix) == pytest.approx(2 - q)
