"""strip against closed forms of strings, bars and beams; sources and tolerances at each test."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from adapters.panel import strip
from adapters.panel.common.compiled_panel import CompiledPanel
from adapters.panel.common.panel import BodyPanel
from adapters.panel.strip.chain import build_chain, stretch_law
from adapters.panel.strip.motion import ChainMotion
from adapters.panel.strip.panel import build
from orchestrator.coupling.panel_set import PanelSet
from orchestrator.ports import Array, Load, Motion, Panel, PanelState
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import HyperelasticPlan, PanelPlan, SolverFailed
from tests.panel.contract import held, swung
from tests.panel.elastic_plans import BRANCHES, C01_PA, C10_PA, difference, plan, shaken

PRINTED = HyperelasticPlan(1200.0, C10_PA, C01_PA, 2e9)
SWAPPED = HyperelasticPlan(1200.0, C01_PA, C10_PA, 2e9)


def taut(cells: int = 24, **changed: object) -> PanelPlan:
    """0.3 m x 5 mm, stretched by 2.5 %."""
    given = {"length_m": 0.3, "span_m": 0.3075, "thickness_m": 0.005, "cells": (cells, 1)}
    return plan(**(given | changed))  # type: ignore[arg-type]


def middle_m(panel: strip.Strip) -> float:
    """Height of the middle over the clamps; the number of cells is even."""
    z = panel.initial().surface.position_m[:, 2]
    return float(z[len(z) // 2] - z[0])


@pytest.mark.parametrize(
    ("material", "stretch", "stress_MPa"),
    [
        (PRINTED, 1.025, "0.50230"),
        (PRINTED, 1.05, "0.96267"),
        (PRINTED, 1.10, "1.77561"),
        (PRINTED, 1.50, "5.41852"),
        (PRINTED, 2.0, "7.3500"),
        (PRINTED, 0.9, "-2.550"),
        (SWAPPED, 1.1, "1.8801"),
        (SWAPPED, 2.0, "11.0250"),
    ],
)
def test_uniaxial_law(material: HyperelasticPlan, stretch: float, stress_MPa: str) -> None:
    """P = 2 (l - l^-2)(C10 + C01 / l), evaluated independently; to the digits given."""
    stress_Pa = stretch_law(material, 0.0).stress_Pa(np.array([stretch]))[0]
    digits = len(stress_MPa.split(".")[1])
    assert stress_Pa / 1e6 == pytest.approx(float(stress_MPa), abs=0.51 * 10**-digits)


@pytest.mark.parametrize(
    ("stretch", "stress_MPa"), [(1.025, "0.67480"), (1.1, "2.44080"), (2.0, "13.12500"), (0.9, "-3.30219")]
)
def test_law_in_pure_shear(stretch: float, stress_MPa: str) -> None:
    """P = 2 (l - l^-3)(C10 + C01), evaluated independently, with C10 + C01 = 3.5 MPa; half hindered, the
    stress is the mean of both laws."""
    at = np.array([stretch])
    for material in (PRINTED, SWAPPED):
        free, half, sheared = (stretch_law(material, share).stress_Pa(at)[0] for share in (0.0, 0.5, 1.0))
        assert sheared / 1e6 == pytest.approx(float(stress_MPa), abs=0.51e-5)
        assert half == pytest.approx((free + sheared) / 2)


@pytest.mark.parametrize("hindered_share", [0.0, 0.4, 1.0])
def test_stress_and_stiffness_are_derivatives_of_the_energy(hindered_share: float) -> None:
    law, small = stretch_law(PRINTED, hindered_share), 1e-5
    at = np.array([0.8, 1.0, 1.3])
    for slope, value in ((law.stress_Pa, law.energy_J_per_m3), (law.stiffness_Pa, law.stress_Pa)):
        assert slope(at) == pytest.approx((value(at + small) - value(at - small)) / (2 * small), abs=1.0)
    assert law.stiffness_Pa(np.ones(1))[0] == pytest.approx(law.youngs_modulus_Pa)


MOUNTINGS = pytest.mark.parametrize(
    "mounting", [{}, {"clamp_angle_deg": 20.0, "moulded_sag_m": 0.03}], ids=["flat", "turned and moulded"]
)


@MOUNTINGS
def test_tangent_is_the_derivative_of_the_force(mounting: dict[str, float]) -> None:
    """Central differences, 1e-6 relative, on a bent and stretched chain."""
    links = build_chain(taut(6, **mounting))
    rng = np.random.default_rng(9)
    rows = len(links.rows_m)
    x = np.column_stack([links.rows_m, np.zeros(rows), np.zeros(rows)])
    x = x + 0.01 * rng.normal(size=x.shape)

    def force(at: Array) -> Array:
        return links.elastic_N(at).ravel()

    step = 1e-7 * rng.normal(size=x.shape)
    change = (force(x + step) - force(x - step)) / 2
    expected = -links.tangent_N_per_m(x) @ step.ravel()
    assert change == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@MOUNTINGS
def test_compiled_force_is_the_chain_s(mounting: dict[str, float]) -> None:
    """The forces are those of relaxed branches on a bent and stretched chain: 1e-13, rounding."""
    given = taut(6, branches=BRANCHES, **mounting)
    links = build_chain(given)
    rng = np.random.default_rng(11)
    rows = len(links.rows_m)
    x = np.column_stack([links.rows_m, np.zeros(rows), np.zeros(rows)])
    x = x + 0.01 * rng.normal(size=x.shape)
    moving = ChainMotion(links, given, x, np.zeros((4, 3)), 1e-5)
    assert difference(moving.internal_N, links.elastic_N(x)) < 1e-13


def test_frozen_branches_answer_stretch_and_bending_by_their_ratios() -> None:
    """Branches that relax in 1e6 s answer all change since the start elastically: springs with their
    stiffness at the start, bending springs with their own; to 1e-8 of the force, as 1e-9 relaxes in 2 ms."""
    panel = build(taut(8, branches=((0.3, 1e6), (0.2, 1e6))))
    links, body, rng = panel._chain, panel._body, np.random.default_rng(5)
    start_m = body.position_m.copy()
    _, start_length_m = links.spring_directions(start_m)
    for k in range(20):
        time_s = (k + 1) * 1e-4
        load = Load(rng.normal(scale=0.5, size=panel.initial().surface.position_m.shape))
        panel.advance(Interval(k, 1e-4), shaken(panel, time_s), load)
    along, length_m = links.spring_directions(body.position_m)
    pull_N = (links.rate_N_per_m(start_length_m) * (length_m - start_length_m))[:, None] * along
    bent_1_m = links.curvature_1_m(body.position_m) - links.curvature_1_m(start_m)
    bent_N = -links.curvature_1_m2.T @ (links.bending_N_m3[:, None] * bent_1_m)
    pulled_N = np.zeros_like(bent_N)
    pulled_N[links.springs][:-1] += pull_N
    pulled_N[links.springs][1:] -= pull_N
    for alone_N in (bent_N, pulled_N):
        assert np.abs(alone_N).max() > 1e-4 * np.abs(body.internal_N).max(), "it must be seen if it lacks"
    expected_N = links.elastic_N(body.position_m) + 0.5 * (pulled_N + bent_N)
    assert difference(body.internal_N, expected_N) < 1e-8


def test_the_compiled_strip_moves_as_the_python_one() -> None:
    """A tilting, skewed strip under loads that jump and differ from side to side: 1e-9 of the motion, of the
    reaction and of every entry of the account, since rounding is all that differs."""
    given = taut(8, branches=BRANCHES)
    python, compiled = strip.build(given), strip.build(given)
    rest_m, length_s = compiled.initial().surface.position_m, 1e-4
    rng = np.random.default_rng(2)
    turn = rng.normal(size=(2, len(compiled.mount.position_m), 3))
    for k in range(400):
        load = Load(rng.normal(scale=0.5, size=rest_m.shape))
        time_s = (k + 1) * length_s
        clamps = shaken(compiled, time_s)
        clamps = Motion(
            clamps.position_m + 1e-4 * (turn[0] * np.sin(40 * time_s) ** 2),
            clamps.velocity_m_per_s + 1e-4 * turn[0] * 40 * np.sin(80 * time_s),
        )
        expected = BodyPanel.advance(python, Interval(k, length_s), clamps, load)
        actual = compiled.advance(Interval(k, length_s), clamps, load)
        if k % 50 == 49:
            moved_m = expected.surface.position_m - rest_m
            assert difference(actual.surface.position_m - rest_m, moved_m) < 1e-9
            assert difference(actual.surface.velocity_m_per_s, expected.surface.velocity_m_per_s) < 1e-9
            assert difference(actual.reaction.force_N, expected.reaction.force_N) < 1e-9
    accounts = BodyPanel.account(python), compiled.account()
    for books in ("stored_J", "lost_J", "received_J"):
        assert getattr(accounts[1], books) == pytest.approx(getattr(accounts[0], books), rel=1e-9)
    assert min(map(abs, accounts[1].received_J.values())) > 1e-6


def test_strips_of_a_set_advance_together_as_they_do_alone() -> None:
    """The strips agree to the last bit; the one that blows up is named."""

    def opened(number: int) -> Panel:
        return strip.build(replace(taut([6, 8, 6][number], branches=BRANCHES), name=f"panel {number}"))

    alone, members = [opened(number) for number in range(3)], PanelSet(3, opened)
    assert len(members._groups) == 1
    rng = np.random.default_rng(3)
    for k in range(3):
        load = Load(rng.normal(scale=0.5, size=(len(members.initial().surface), 3)))
        clamps = shaken(members, (k + 1) * 1e-4)
        of_set = members.advance(Interval(k, 1e-4), clamps, load)
        for panel, points, held_points in zip(alone, members.surface, members.clamps, strict=True):
            state = panel.advance(Interval(k, 1e-4), clamps.part(held_points), load.part(points))
            assert np.array_equal(of_set.surface.position_m[points], state.surface.position_m)
            assert np.array_equal(of_set.surface.velocity_m_per_s[points], state.surface.velocity_m_per_s)
            assert np.array_equal(of_set.reaction.force_N[held_points], state.reaction.force_N)
    broken = members._own[1]
    assert isinstance(broken, CompiledPanel)
    broken._body.memory["position_m"][4, 0] = np.nan
    with pytest.raises(
        SolverFailed, match=r"panel panel 1: strip unstable before 0.0004 s: stretches are nan"
    ):
        members.advance(Interval(3, 1e-4), shaken(members, 4e-4), load)


@MOUNTINGS
def test_force_is_minus_the_derivative_of_the_energy(mounting: dict[str, float]) -> None:
    links = build_chain(taut(6, **mounting))
    rng = np.random.default_rng(10)
    rows = len(links.rows_m)
    x = np.column_stack([links.rows_m, np.zeros(rows), np.zeros(rows)])
    x = x + 0.01 * rng.normal(size=x.shape)

    def energy(at: Array) -> float:
        return links.membrane_J(at) + links.bending_J(at)

    step = 1e-6 * rng.normal(size=x.shape)
    work = np.sum(links.elastic_N(x) * step)
    assert (energy(x - step) - energy(x + step)) / 2 == pytest.approx(work, rel=1e-6)


def test_pull_of_a_stretched_strip_is_that_of_the_law() -> None:
    panel = strip.build(taut(gravity_m_per_s2=0.0))
    reaction = panel.initial().reaction.force_N
    first = np.array([frame == "driving" for frame in panel.mount.frame])
    pull_N = 0.50230e6 * 0.05 * 0.005
    assert reaction[first].sum(axis=0) == pytest.approx([pull_N, 0.0, 0.0], rel=1e-5, abs=1e-9)


def test_sag_of_a_taut_strip() -> None:
    """Clamped beam under tension T and load q (Timoshenko, Strength of Materials, part II, 1941,
    ch. II):  q L^2 / (8 T) - q L^2 tanh(u / 4) / (2 T u),  u = L sqrt(T / E I), where E I holds
    for curvature per material length, so 1.025^3 of it for the stretched strip.  Boundary layers
    L / u = 10 mm make the error 0.7 % at 48 cells; it falls with the square of the cell."""
    tension, length = 0.50230e6 * 0.005, 0.3075
    stiffness = 21e6 * 0.005**3 / 12 * 1.025**3
    q = 1200 * 0.005 * 9.81 / 1.025
    u = length * np.sqrt(tension / stiffness)
    expected = q * length**2 / (8 * tension) - q * length**2 / (2 * tension * u) * np.tanh(u / 4)
    error = [-middle_m(strip.build(taut(cells=cells))) / expected - 1 for cells in (48, 96)]
    assert error[1] == pytest.approx(0.0, abs=3e-3)
    assert error[0] / error[1] == pytest.approx(4.0, rel=0.1)


def test_taut_strip_frequency() -> None:
    """Pre-tensioned strip 0.3 m x 5 mm, rho 1200, 2.5 % stretch, no bending: T = 2511.5 N/m and
    f1 = sqrt(T / (rho t L 1.025 L)) / 2 = 33.68 Hz, whatever the thickness; here 0.5 mm between
    hinges (clamp_m = 0), so that bending adds 1e-4.  The chain of 24 cells: -7e-4."""
    panel = strip.build(taut(thickness_m=5e-4, clamp_m=0.0, gravity_m_per_s2=0.0))
    points = len(panel.initial().surface)
    wave = np.sin(np.pi * np.arange(points // 2) / (points // 2 - 1)).repeat(2)
    kick = Load(np.outer(wave, [0.0, 0.0, 1e-3]))
    interval_s, heights = 1e-4, []
    for index in range(2000):
        state = panel.advance(
            Interval(index, interval_s), held(panel), kick if index < 10 else Load.zero(points)
        )
        heights.append(state.surface.position_m[points // 2, 2] - 0.3)
    z = np.array(heights[10:])
    rising = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    crossed = rising + z[rising] / (z[rising] - z[rising + 1])
    frequency_Hz = (len(crossed) - 1) / (interval_s * (crossed[-1] - crossed[0]))
    assert frequency_Hz == pytest.approx(33.68, rel=1.5e-3)


def elastica(slack: float) -> float:
    """Midpoint height / length of a clamped inextensible elastica shortened by ``slack`` (Love,
    Mathematical Theory of Elasticity, 4th ed. 1927, art. 263): modulus k solves
    2 E(k) / K(k) - 1 = 1 - slack, height = k / K(k)."""
    k = brentq(lambda k: 2 * ellipe(k * k) / ellipk(k * k) - 2 + slack, 1e-6, 0.9)
    return float(k / ellipk(k * k))


def test_elastica_formula_gives_the_published_heights() -> None:
    slack = (0.005, 0.01, 0.02, 0.03, 0.05, 0.10)
    published = [0.0449, 0.0635, 0.0895, 0.1092, 0.1401, 0.1949]
    assert [elastica(d) for d in slack] == pytest.approx(published, abs=6e-5)


@pytest.mark.parametrize("slack", [0.01, 0.05, 0.10])
def test_slack_strip_is_an_elastica(slack: float) -> None:
    """1 % (48 cells; the strip is 1 mm thick, so compression by P_cr shortens it by 4e-5)."""
    panel = strip.build(
        plan(span_m=0.33 * (1 - slack), thickness_m=0.001, gravity_m_per_s2=0.0, cells=(48, 1))
    )
    assert -middle_m(panel) / 0.33 == pytest.approx(elastica(slack), rel=0.01)


def test_slack_strip_without_bending_is_a_catenary() -> None:
    """h / L = sqrt(3 D / 8 L): 0.0612 at D / L = 0.01 (2 %: the shallow limit)."""
    panel = strip.build(plan(span_m=0.33 * 0.99, thickness_m=1e-5, clamp_m=0.0, cells=(48, 1)))
    assert -middle_m(panel) / 0.33 == pytest.approx(0.0612, rel=0.02)


def test_clamped_beam_sag() -> None:
    """No tension, small load: q L^4 / (384 E I) (Timoshenko, Strength of Materials, part I); the
    difference falls with the square of the cell."""
    stiffness, g = 21e6 * 0.004**3 / 12, 1e-3
    expected = 1200 * 0.004 * g * 0.33**4 / (384 * stiffness)
    error = [
        -middle_m(strip.build(plan(gravity_m_per_s2=g, cells=(cells, 1)))) / expected - 1
        for cells in (24, 48)
    ]
    assert error[0] / error[1] == pytest.approx(4.0, rel=0.02)
    assert error[1] < 5e-3


def moved(step_s: float, interval_s: float) -> Array:
    """The strip's surface after 0.02 s of a smoothly swung clamp."""
    panel = strip.build(taut(12, step_s=step_s, branches=((0.2, 1e-3),)))
    unloaded = Load.zero(len(panel.initial().surface))
    for index in range(round(0.02 / interval_s)):
        end = swung(panel, (index + 1) * interval_s)
        state = panel.advance(Interval(index, interval_s), end, unloaded)
    return state.surface.position_m


def test_second_order_in_the_step() -> None:
    """Steps of 50 and 12.5 us (the limit is 185) against one of 1.5625 us: the ratio of the
    errors is (1 - 4^-5) / (4^-2 - 4^-5) = 16.24 for second order."""
    exact = moved(1.5625e-6, 1e-4)
    coarse, fine = (np.linalg.norm(moved(step_s, 1e-4) - exact) for step_s in (5e-5, 1.25e-5))
    assert coarse / fine == pytest.approx(16.24, rel=0.1)


def test_clamps_follow_the_smooth_path_whatever_the_interval() -> None:
    """Hermite's error on the clamp's path is 3e-9 m of some mm: both runs agree to 1e-4."""
    assert difference(moved(2.5e-5, 1e-4) - 0.3, moved(2.5e-5, 2e-4) - 0.3) < 1e-6


def test_maxwell_branch_relaxes_the_pull() -> None:
    """A branch of ratio g adds g E A strain at once, and exp(-t / tau) of it after t: after a
    quick, small stretch held for tau, 1/e is left.  2 %: the stretch takes tau / 100."""
    tau, g = 0.1, 0.5
    panel = strip.build(taut(4, gravity_m_per_s2=0.0, branches=((g, tau),)))
    unloaded = Load.zero(len(panel.initial().surface))
    second = np.array([frame == "driven" for frame in panel.mount.frame])
    resting_N = panel.initial().reaction.force_N[second].sum(axis=0)[0]
    small_m = 3e-5

    pulls = []
    for index in range(1000):
        share = min(1.0, (index + 1) / 100)
        smooth = share * share * (3 - 2 * share)
        rate = 6 * share * (1 - share) / 100e-4 * 1.0
        still = held(panel)
        moved_m = np.outer(second * small_m * smooth, [1.0, 0, 0])
        speed_m_per_s = np.outer(second * small_m * rate, [1.0, 0, 0])
        end = Motion(still.position_m + moved_m, speed_m_per_s)
        state = panel.advance(Interval(index, 1e-4), end, unloaded)
        pulls.append(state.reaction.force_N[second].sum(axis=0)[0])
    viscous_N = g * 21e6 * 0.05 * 0.005 * small_m / 0.3
    elastic_N = -(np.mean(pulls[-50:]) - resting_N) - viscous_N * np.exp(-0.094 / tau)
    modulus_Pa = stretch_law(PRINTED, 0.0).stiffness_Pa(np.array([1.025]))[0]
    assert elastic_N == pytest.approx(modulus_Pa * 0.05 * 0.005 * small_m / 0.3, rel=0.02)


def test_too_large_a_step_is_refused_with_the_value_to_use() -> None:
    limit_s = strip.largest_step_s(taut())
    with pytest.raises(ValueError, match=rf"{limit_s:.3g}\b.*\b{0.8 * limit_s:.3g}\b"):
        strip.build(taut(step_s=1.01 * limit_s))
    with pytest.raises(ValueError, match="explicit"):
        strip.build(taut(integrator="implicit"))


def test_limit_is_where_the_strip_goes_unstable() -> None:
    """A straight strip, tapped: stable at 0.98 of the limit and gone at 1.1 of it (built below
    the limit, then run with larger steps)."""

    def run(panel: strip.Strip, tap: Load) -> PanelState:
        for index in range(50):
            state = panel.advance(Interval(index, 1e-2), held(panel), tap)
        return state

    given = replace(taut(12, span_m=0.3, gravity_m_per_s2=0.0), sync_interval_s=1e-2)
    limit_s = strip.largest_step_s(given)
    for factor, fails in ((0.98, False), (1.1, True)):
        panel = strip.build(given)
        points = len(panel.initial().surface)
        panel._body.step_s = factor * limit_s
        tap = Load(1e-6 * np.random.default_rng(11).normal(size=(points, 3)))
        if fails:
            with pytest.raises(SolverFailed, match=r"panel 1: strip unstable before 0\."):
                run(panel, tap)
        else:
            assert np.abs(run(panel, tap).surface.velocity_m_per_s).max() < 1e-3


def test_a_one_sided_load_reaches_the_clamps_with_its_moment() -> None:
    """A vertical force on the edge y = width a quarter along: three quarters of its moment
    about the middle line go to the first clamp."""
    panel = strip.build(taut(8, gravity_m_per_s2=0.0, branches=((1.0, 2e-3), (1.0, 5e-4))))
    points = len(panel.initial().surface)
    force = np.zeros((points, 3))
    force[2 * 3 + 1] = [0.0, 0.0, -1.0]  # row 3: after the clamp's two rows, a quarter along
    state = panel.advance(Interval(0, 1e-4), held(panel), Load(force))
    arm = panel.mount.position_m[:, 1] - (-0.2 + 0.025)
    moment = arm * state.reaction.force_N[:, 2]
    first = np.array([frame == "driving" for frame in panel.mount.frame])
    assert moment[first].sum() == pytest.approx(-0.75 * 0.025)
    assert moment[~first].sum() == pytest.approx(-0.25 * 0.025)


def test_clamps_in_an_interval_are_on_the_closed_form_of_their_path() -> None:
    """Clamps that start with one velocity and end with another, each on a cubic of its own, which Hermite's
    path is exactly: one interval of eight steps is eight intervals of one, to rounding."""
    length_s, steps = 4e-4, 8
    by_intervals = []
    for count in (1, steps):
        panel = strip.build(taut(6, step_s=1.001 * length_s / steps, branches=((0.2, 1e-3),)))
        mount_m, unloaded = panel.mount.position_m, Load.zero(len(panel.initial().surface))
        second, third = np.random.default_rng(12).normal(size=(2, len(mount_m) // 2, 3)).repeat(2, axis=1)
        impulse_N_s = np.zeros_like(mount_m)
        for index in range(count):
            t = (index + 1) / count
            moved_m = 1e-4 * (second * t**2 + third * t**3)
            rate_m_per_s = 1e-4 / length_s * (2 * second * t + 3 * third * t**2)
            interval = Interval(index, length_s / count)
            state = panel.advance(interval, Motion(mount_m + moved_m, rate_m_per_s), unloaded)
            impulse_N_s += interval.length_s * state.reaction.force_N
        motion = np.concatenate([state.surface.position_m, 1e-3 * state.surface.velocity_m_per_s])
        account = panel.account()
        by_intervals.append((motion, impulse_N_s, account.received_J["clamps"]))
    (whole, whole_N_s, whole_J), (parts, parts_N_s, parts_J) = by_intervals
    assert whole == pytest.approx(parts, abs=1e-13)
    assert whole_N_s == pytest.approx(parts_N_s, abs=1e-12)
    assert whole_J == pytest.approx(parts_J, rel=1e-10)
