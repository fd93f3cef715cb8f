"""Resting shapes of the sheet against beams, strings and the elastica."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Load
from orchestrator.ports.clock import Interval
from tests.panel.elastic_plans import C01_PA, C10_PA, height_m, plan, pull_N, shaken

pytestmark = pytest.mark.solver


def opened(**given):
    from adapters.panel import sheet

    return sheet.build(plan(**given))


def sag_m(panel, given_plan_z=0.3) -> float:
    return given_plan_z - height_m(panel.initial())


def test_built_in_beam_under_its_weight():
    """q L^4 / (384 E I), S. Timoshenko, Strength of Materials, with the beam's E I as the strip is
    as narrow as it is thick.  1 %: the clamps keep it flat across, which stiffens it by 0.5 % at
    this width (1.5 % at 10 mm, 0.1 % at 2 mm, measured)."""
    length, thickness = 0.3, 0.004
    panel = opened(
        length_m=length, thickness_m=thickness, width_m=0.004, gravity_m_per_s2=0.02, cells=(30, 1)
    )
    exact = 1200 * 0.02 * thickness * length**4 / (384 * 21e6 * thickness**3 / 12)
    assert sag_m(panel) == pytest.approx(exact, rel=0.01)
    panel.close()


@pytest.mark.parametrize(
    ("closing", "height", "over_critical"),
    [(0.005, 0.0449, 1.0025), (0.02, 0.0895, 1.0101), (0.05, 0.1401, 1.0257), (0.10, 0.1949, 1.0530)],
)
def test_clamped_elastica(closing, height, over_critical):
    """A slack panel without weight: height and end force of the inextensible clamped elastica
    (elliptic integrals; A. E. H. Love, Mathematical Theory of Elasticity, art. 263), ends moved
    together by D = closing L.  1 %; the critical force 4 pi^2 D b / L^2 with the plate's D, as the
    strip is wide.  48 cells: 24 lock by 8 % in force (2 % at t = 2 mm)."""
    length, thickness, width = 0.3, 0.001, 0.4
    panel = opened(
        length_m=length,
        span_m=length * (1 - closing),
        thickness_m=thickness,
        width_m=width,
        gravity_m_per_s2=0.0,
        cells=(48, 1),
    )
    assert sag_m(panel) / length == pytest.approx(height, rel=0.01)
    critical_N = 4 * np.pi**2 * 21e6 * thickness**3 / 9 * width / length**2
    assert pull_N(panel, panel.initial()) == pytest.approx(over_critical * critical_N, rel=0.01)
    panel.close()


@pytest.mark.parametrize(("closing", "height"), [(0.01, 0.0612), (0.02, 0.0866), (0.03, 0.1061)])
def test_catenary(closing, height):
    """A heavy panel with little bending stiffness hangs like a chain, h/L = sqrt(3 D / (8 L));
    2 %: shallow-chain formula, boundary layers at the clamps, and stretch."""
    length = 0.3
    panel = opened(
        length_m=length,
        span_m=length * (1 - closing),
        thickness_m=0.00005,
        width_m=0.02,
        cells=(30, 1),
        gravity_m_per_s2=2.0,
    )
    assert sag_m(panel) / length == pytest.approx(height, rel=0.02)
    panel.close()


def test_taut_panel_sags_like_a_string():
    """q l^2 / (8 T), T = 2511.5 N/m * t / 5 mm at 2.5 % stretch; 1.5 %: bending and the clamps,
    which keep the width."""
    length, stretch, thickness = 0.3, 1.025, 0.0005
    panel = opened(
        length_m=length,
        span_m=length * stretch,
        thickness_m=thickness,
        width_m=0.01,
        cells=(24, 1),
        gravity_m_per_s2=1.0,
    )
    tension_N_per_m = 2511.5 * thickness / 0.005
    per_length_N_per_m2 = 1200 * thickness * 1.0 / stretch
    exact = per_length_N_per_m2 * (length * stretch) ** 2 / (8 * tension_N_per_m)
    assert sag_m(panel) == pytest.approx(exact, rel=0.015)
    assert -pull_N(panel, panel.initial()) == pytest.approx(tension_N_per_m * 0.01, rel=0.015)
    panel.close()


@pytest.mark.parametrize("span_m", [0.325, 0.33, 0.338])
def test_at_rest_the_clamps_carry_the_weight(span_m):
    """Static reaction: all of the weight, and what one clamp pulls the other pulls back, to the
    balance that ``resting_shape`` promises."""
    panel = opened(span_m=span_m, width_m=0.2, cells=(12, 3))
    force = panel.initial().reaction.force_N
    weight_N = 1200 * 0.004 * 0.2 * (0.33 + 0.04) * 9.81
    np.testing.assert_allclose(force.sum(axis=0), [0, 0, -weight_N], atol=1e-7 * np.abs(force).sum())
    np.testing.assert_array_equal(panel.initial().surface.velocity_m_per_s, 0.0)
    panel.close()


@pytest.mark.parametrize("stretch", [1.02, 1.2])
def test_a_taut_panel_with_joined_sides_is_in_pure_shear(stretch):
    """Sides that go on cannot contract: the nominal stress of an incompressible Mooney-Rivlin sheet is
    2 (C10 + C01) (stretch - 1/stretch^3) (R. S. Rivlin, Phil. Trans. R. Soc. A 241, 1948, 379).  1e-4: the
    end of the stretch at the clamps counts as bent, which is 1e-5 in a sheet so thin and 1.2e-3 at 4 mm.
    With free sides the middle contracts, and the pull is 0.8 of that."""
    given = {"span_m": 0.33 * stretch, "gravity_m_per_s2": 0.0, "cells": (8, 2), "thickness_m": 0.0004}
    panel, free = opened(**given, joined_sides=True), opened(**given)
    expected_N = 2 * (C10_PA + C01_PA) * (stretch - stretch**-3) * 0.05 * 0.0004
    assert -pull_N(panel, panel.initial()) == pytest.approx(expected_N, rel=1e-4)
    assert -pull_N(free, free.initial()) < 0.9 * expected_N
    for opened_panel in (panel, free):
        opened_panel.close()


def test_joined_sides_move_alike_and_take_no_momentum():
    """The load is on one side: both sides have the same velocity to the bit, and what weight, load and
    clamps give is the momentum to rounding, also along y."""
    given = plan(cells=(8, 2), joined_sides=True)
    panel = opened(cells=(8, 2), joined_sides=True)
    rest_m, interval_s, weight_N = (
        panel.initial().surface.position_m,
        1e-4,
        given.mass_kg * given.gravity_m_per_s2,
    )
    force_N = np.zeros_like(rest_m)
    force_N[5 * (len(rest_m) // 10)] = [0.3, 0.5, -2.0]
    given_N_s = panel.account().momentum_kg_m_per_s
    for k in range(50):
        state = panel.advance(Interval(k, interval_s), shaken(panel, (k + 1) * interval_s), Load(force_N))
        given_N_s += interval_s * (weight_N + force_N.sum(axis=0) - state.reaction.force_N.sum(axis=0))
    momentum_N_s = panel.account().momentum_kg_m_per_s
    np.testing.assert_allclose(momentum_N_s, given_N_s, rtol=0, atol=1e-12 * np.abs(momentum_N_s).max())
    rows = state.surface.velocity_m_per_s.reshape(-1, 5, 3)
    assert np.array_equal(rows[:, 0], rows[:, -1])
    assert np.abs(rows[:, 0] - rows[:, 2]).max() > 1e-3
    panel.close()
