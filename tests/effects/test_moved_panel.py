"""Closed forms of a panel against integrals, other closed forms and numbers worked out by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid

from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.ports.plans import HyperelasticPlan
from orchestrator.preflight.scene.moved_panel import (
    MovedPanel,
    change_of_response,
    clamp_response,
    loss_factor,
    mooney_ratio,
    one_sided_share,
    sine_arch_m,
    stiffness_share,
)
from orchestrator.preflight.scene.scene import scene
from tests.cases import loaded

LAW = HyperelasticPlan(1150.0, 0.7e6, 2.8e6, 2e9)


@pytest.mark.parametrize("approach_m", [0.003, 0.0059, 0.009])
def test_the_arch_is_as_long_as_the_panel(approach_m: float) -> None:
    """Length of the sine over the shorter span by quadrature: the form is the first term of a
    series in (height / span)^2, so that 3 % of approach leave 0.1 % of the length."""
    span_m = 0.3 - approach_m
    x = np.linspace(0.0, span_m, 20001)
    slope = sine_arch_m(0.3, approach_m) * math.pi / span_m * np.cos(math.pi * x / span_m)
    length_m = trapezoid(np.hypot(1.0, slope), x)
    assert length_m - span_m == pytest.approx(approach_m, rel=0.03)
    assert length_m == pytest.approx(0.3, rel=1e-3)


def test_a_taut_panel_has_no_arch() -> None:
    assert sine_arch_m(0.3, -0.004) == 0.0


@pytest.mark.parametrize(
    ("stretch", "stress_Pa"), [(1.025, 502_300.0), (1.10, 1_775_610.0), (1.5, 5_418_520.0)]
)
def test_mooney_rivlin_against_the_uniaxial_law(stretch: float, stress_Pa: float) -> None:
    """Nominal stress 2 (l - l^-2)(C10 + C01 / l), worked out to six digits."""
    strain = stretch - 1
    assert mooney_ratio(LAW, strain) == pytest.approx(stress_Pa / (21e6 * strain), rel=1e-5)


def test_no_strain_no_difference() -> None:
    assert mooney_ratio(LAW, 0.0) == 1.0
    assert mooney_ratio(LAW, 1e-6) == pytest.approx(1.0, abs=1e-5)


def test_loss_factor_of_one_branch() -> None:
    """A branch of ratio g at w tau = 1 stores g/2 and loses g/2: g / (2 + g)."""
    law = HyperelasticPlan(1150.0, 0.7e6, 2.8e6, 2e9, ((0.2, 0.01),))
    assert loss_factor(law, 100.0) == pytest.approx(0.2 / 2.2, rel=1e-12)
    assert loss_factor(LAW, 100.0) == 0.0


def test_loss_factor_is_that_of_the_complex_modulus() -> None:
    branches = ((0.2, 1e-2), (0.2, 2e-3), (0.2, 4e-4))
    modulus = 1 + sum(g * 1j * 78.5 * tau / (1 + 1j * 78.5 * tau) for g, tau in branches)
    law = HyperelasticPlan(1150.0, 0.7e6, 2.8e6, 2e9, branches)
    assert loss_factor(law, 78.5) == pytest.approx(modulus.imag / modulus.real, rel=1e-12)


@pytest.mark.parametrize("ratio", [-0.5, 0.0, 0.3, 0.9])
def test_one_sided_spring_against_its_first_harmonic(ratio: float) -> None:
    """The harmonic is found by quadrature over a cycle, force = max(0, ratio + sin)."""
    angle = np.linspace(0.0, 2 * math.pi, 200_001)
    force = np.maximum(0.0, ratio + np.sin(angle))
    harmonic = trapezoid(force * np.sin(angle), angle) / math.pi
    assert one_sided_share(ratio) == pytest.approx(harmonic, rel=1e-6, abs=1e-9)


def test_one_sided_spring_at_its_ends() -> None:
    assert (one_sided_share(-3.0), one_sided_share(0.0), one_sided_share(3.0)) == (0.0, 0.5, 1.0)


def test_slots_take_their_part_of_the_stiffness() -> None:
    """Slots of 20 x 3 in cells of 25 x 6 over three quarters of the length and the whole width:
    a quarter is whole, of the rest 4/5 have half the section: 1 / (0.25 + 0.75 (0.2 + 1.6))."""
    along, across = np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    rectangle = Rectangle(np.zeros(3), along, across, 0.3, 0.3, 0.06, 0.0)
    slots = AperturePattern("slot", 0.02, 0.003, 0.025, 0.006, margin_along_m=0.0375)
    assert stiffness_share(slots, rectangle) == pytest.approx(1 / 1.6, rel=1e-9)
    assert stiffness_share(None, rectangle) == 1.0


def panel(folder: Path, *overrides: str) -> MovedPanel:
    """0.3 x 0.2 m, 4 mm, E = 21 MPa, 1150 kg/m3."""
    return scene(loaded(folder, overrides).case).panels[0]


def test_slack_frequency_by_hand(tmp_path: Path) -> None:
    """D = 21e6 * 64e-9 / 9 = 0.14933 Nm, 4.6 kg/m2: 22.37 * 0.18018 / 0.09 = 44.78 rad/s."""
    slack = panel(tmp_path, "screen.panels.deck.tension_m=-0.002")
    assert slack.frequency_rad_per_s == pytest.approx(44.78, rel=1e-3)


def test_taut_frequency_by_hand(tmp_path: Path) -> None:
    """2 mm on 0.3 m: string pi / 0.3 * sqrt(21e6 / 150 / 1150) = 115.54 rad/s, with the bending
    44.78: 123.9."""
    assert panel(tmp_path).frequency_rad_per_s == pytest.approx(123.9, rel=1e-3)


def test_stiffness_and_mass_by_hand(tmp_path: Path) -> None:
    """E W t / L = 21e6 * 0.2 * 0.004 / 0.3 = 56 kN/m; 1150 * 0.004 = 4.6 kg/m2."""
    deck = panel(tmp_path)
    assert deck.taut_stiffness_N_per_m == pytest.approx(56e3, rel=1e-9)
    assert deck.mass_kg_per_m2 == pytest.approx(4.6, rel=1e-9)
    assert deck.free_mass_kg == pytest.approx(0.276, rel=1e-9)


@pytest.mark.parametrize("ratio", [0.3, 0.9, 1.0, 2.0])
def test_what_loss_and_mass_change_of_a_taut_panels_middle(ratio: float) -> None:
    """The change is that of the forced motion of one damped oscillator, m x'' + k (1 + i eta) x = m w^2,
    and, for the loss factor at resonance, the textbook's 1/eta."""
    eta, mass = 0.2, 1.5
    stiffness = 1 / ratio**2  # m = w = 1
    of_base = 4 / math.pi / (stiffness * (1 + 1j * eta) - 1)
    undamped = math.inf if ratio == 1.0 else 4 / math.pi / (stiffness - 1)
    damped = abs(1 + of_base)
    change = change_of_response(ratio, eta, 0.0)
    if ratio == 1.0:
        assert damped == pytest.approx(4 / math.pi / eta, rel=0.02)
    assert change == pytest.approx(abs(abs(1 + undamped) / damped - 1), rel=1e-12)
    loaded_m = abs(1 + (1 + mass) * 4 / math.pi / (stiffness * (1 + 1j * eta) - (1 + mass)))
    expected = abs(abs(1 + undamped) / loaded_m - 1)
    assert change_of_response(ratio, eta, mass) == pytest.approx(expected, rel=1e-12)
    assert change_of_response(ratio, 0.0, 0.0) == 0.0


def test_far_below_its_frequency_nothing_changes() -> None:
    assert change_of_response(0.09, 0.06, 3.3) < 0.05
    assert change_of_response(0.09, 0.0, 0.0) == 0.0
    assert clamp_response(0.09) < 0.02
