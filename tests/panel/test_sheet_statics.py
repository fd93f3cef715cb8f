"""Resting shapes of the sheet against beams, strings and the elastica."""

from __future__ import annotations

import numpy as np
import pytest

from tests.panel.elastic_plans import height_m, plan, pull_N

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
