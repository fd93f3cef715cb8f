"""The sheet in motion: frequency, conservation, convergence, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Load, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import SolverFailed
from tests.panel.elastic_plans import (
    BRANCHES,
    defect_J,
    difference,
    height_m,
    plan,
    pull_N,
    second_clamp,
    shake,
    shaken,
)

pytestmark = pytest.mark.solver
INTEGRATORS = ("explicit", "implicit")


def opened(**given):
    from adapters.panel import sheet

    return sheet.build(plan(**given))


def held(panel) -> Motion:
    return Motion(panel.mount.position_m, np.zeros_like(panel.mount.position_m))


@pytest.mark.parametrize("thickness_m", [0.0002, 0.005])
def test_first_frequency_of_a_taut_strip(thickness_m):
    """Ring-down of a 0.3 m strip at 2.5 % stretch.  String: sqrt(T/m) / (2 l) = 33.68 Hz with
    T = 2511.5 N/m at 5 mm; a stiff string with clamped ends has  1 + 2 e + (4 + pi^2 / 2) e^2
    times that, e^2 = E I / (T l^2) (H. Fletcher, J. Acoust. Soc. Am. 36 (1964) 203-209).  1 %:
    frequency read from 5 zero crossings, and the clamps keep the width."""
    length, stretch = 0.3, 1.025
    panel = opened(
        length_m=length,
        span_m=length * stretch,
        width_m=0.006,
        thickness_m=thickness_m,
        gravity_m_per_s2=0.0,
        cells=(16, 1),
    )
    blow = Load.zero(len(panel.initial().surface))
    blow.force_N[:, 2] = (
        3.0
        * thickness_m
        * np.sin(np.pi * (panel.initial().surface.position_m[:, 0] - 0.1) / (length * stretch)).clip(0.0)
    )
    heights = []
    for k in range(900):
        load = blow if k < 20 else Load.zero(len(blow))
        heights.append(height_m(panel.advance(Interval(k, 1e-4), held(panel), load)) - 0.3)
    signs = np.array(heights[20:])
    before = np.flatnonzero(signs[1:] * signs[:-1] < 0.0)
    crossings_s = 1e-4 * (before + signs[before] / (signs[before] - signs[before + 1]))
    frequency_Hz = 0.5 * (len(crossings_s) - 1) / (crossings_s[-1] - crossings_s[0])
    tension_N_per_m = 2511.5 * thickness_m / 0.005
    e = (21e6 * thickness_m**3 / 12 / (tension_N_per_m * (length * stretch) ** 2)) ** 0.5
    exact = 33.68 * (1 + 2 * e + (4 + np.pi**2 / 2) * e**2)
    assert len(crossings_s) >= 5
    assert frequency_Hz == pytest.approx(exact, rel=0.01)
    panel.close()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_momentum_is_exact_in_every_interval(integrator):
    """Change of momentum = load + weight - reaction, for a bent, damped panel with shaken clamps
    and a load that jumps: 1e-12 of the impulse through the clamps."""
    panel = opened(span_m=0.328, cells=(10, 2), integrator=integrator, branches=BRANCHES)
    before = panel.account()
    rng = np.random.default_rng(5)
    length_s, worst = 2e-4, 0.0
    for k in range(40):
        load = Load(rng.normal(scale=0.05, size=(len(panel.initial().surface), 3)))
        state = panel.advance(Interval(k, length_s), shaken(panel, (k + 1) * length_s), load)
        after = panel.account()
        received = (
            after.outside_impulse_N_s
            - before.outside_impulse_N_s
            + (load.force_N.sum(axis=0) - state.reaction.force_N.sum(axis=0)) * length_s
        )
        error = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s - received
        through = np.abs(state.reaction.force_N).sum() * length_s
        worst = max(worst, float(np.abs(error).max() / through))
        before = after
    assert worst < 1e-12
    panel.close()


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_position_and_energy_converge_with_order_two(integrator):
    """Halving the step divides the change of the final shape, and the energy that the account
    does not explain, by four (3.4 ... 4.6: the steps are not yet infinitely small)."""
    steps_s = (4e-5, 2e-5, 1e-5)
    shapes, defects = [], []
    for step_s in steps_s:
        panel = opened(span_m=0.326, cells=(8, 1), integrator=integrator, step_s=step_s, branches=BRANCHES)
        stored_J = sum(panel.account().stored_J.values())
        states, _ = shake(panel, 4e-4, 50)
        shapes.append(states[-1].surface.position_m)
        defects.append(abs(defect_J(panel, stored_J)))
        through_J = abs(panel.account().received_J["clamps"])
        panel.close()
    first = np.linalg.norm(shapes[0] - shapes[1])
    second = np.linalg.norm(shapes[1] - shapes[2])
    assert 3.4 < first / second < 4.6
    assert 3.4 < defects[1] / defects[2] < 4.6
    assert defects[2] < 1e-4 * through_J


def test_explicit_and_implicit_agree():
    """The panel and the law are the same, implicit with 5e-5 s: 1e-3 in deflection, 1e-2 in clamp force."""
    heights, pulls = [], []
    for integrator, step_s in (("explicit", 0.0), ("implicit", 5e-5)):
        panel = opened(span_m=0.328, cells=(12, 2), integrator=integrator, step_s=step_s, branches=BRANCHES)
        states, initial = shake(panel, 1e-4, 300)
        heights.append(np.array([height_m(state) - height_m(initial) for state in states]))
        pulls.append(np.array([pull_N(panel, state) for state in states]))
        panel.close()
    assert difference(heights[1], heights[0]) < 1e-3
    assert difference(pulls[1], pulls[0]) < 1e-2


@pytest.mark.parametrize("integrator", INTEGRATORS)
def test_turning_both_clamps_turns_the_panel(integrator):
    """A weightless panel carried round by 90 degrees in 0.4 s and stopped smoothly: stretched by
    the centrifugal force on the way, then unstrained.  What is left rings in the first bending
    mode: below 1e-3 of the kinetic energy on the way."""
    panel = opened(gravity_m_per_s2=0.0, cells=(8, 1), integrator=integrator, branches=BRANCHES)
    fastest_J = 0.0
    center = panel.mount.position_m.mean(axis=0)
    unloaded = Load.zero(len(panel.initial().surface))
    intervals, length_s = 800, 5e-4
    for k in range(intervals + 100):
        clamps = turned(panel.mount.position_m, center, (k + 1) / intervals, intervals * length_s)
        state = panel.advance(Interval(k, length_s), clamps, unloaded)
        fastest_J = max(fastest_J, panel.account().stored_J["kinetic"])
    stored = panel.account().stored_J
    assert stored["membrane"] + stored["bending"] + stored["kinetic"] < 1e-3 * fastest_J
    upright = state.surface.position_m
    assert np.ptp(upright[:, 2]) == pytest.approx(0.33 + 0.04, rel=1e-4)
    assert np.ptp(upright[:, 0]) < 1e-3
    panel.close()


def turned(points_m, center_m, fraction, duration_s) -> Motion:
    """Rotation about y by  90 degrees (10 x^3 - 15 x^4 + 6 x^5)  of the time x."""
    x = min(fraction, 1.0)
    angle = 0.5 * np.pi * (10 * x**3 - 15 * x**4 + 6 * x**5)
    speed = 0.5 * np.pi * 30 * (x**2 - 2 * x**3 + x**4) / duration_s
    c, s = np.cos(angle), np.sin(angle)
    arm = (points_m - center_m) @ np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    velocity = speed * arm @ np.array([[0, 0, -1], [0, 0, 0], [1, 0, 0]])
    return Motion(center_m + arm, velocity)


def test_clamps_carry_their_rotation():
    """Turning the second clamp's points by a small angle about its inner edge bends the panel as
    a built-in beam does: mid deflection  angle L / 8  (S. Timoshenko, Strength of Materials)."""
    angle, length = 2e-3, 0.33
    panel = opened(gravity_m_per_s2=0.0, cells=(16, 1), integrator="implicit", branches=((2.0, 0.01),))
    at = panel.mount.position_m
    edge_m = at[:, 0].max() - 0.02
    unloaded = Load.zero(len(panel.initial().surface))
    for k in range(500):
        part = min((k + 1) / 250, 1.0)
        rate = angle / (250 * 1e-3) if part < 1.0 else 0.0
        moved, velocity = at.copy(), np.zeros_like(at)
        arm = second_clamp(panel) * (at[:, 0] - edge_m)
        moved[:, 2] += angle * part * arm
        velocity[:, 2] = rate * arm
        state = panel.advance(Interval(k, 1e-3), Motion(moved, velocity), unloaded)
    assert height_m(state) - 0.3 == pytest.approx(-angle * length / 8, rel=0.02)
    panel.close()


def test_refuses_a_step_above_the_limit():
    from adapters.panel import sheet

    given = plan(step_s=1e-3)
    limit = sheet.largest_step_s(given)
    with pytest.raises(ValueError, match=rf"step_s\b.*\b0\.001\b.*{limit:.3g}"):
        sheet.build(given)
    with pytest.raises(ValueError, match="magic"):
        opened(integrator="magic")


def test_the_limit_is_where_it_becomes_unstable():
    """A disturbance stays bounded just below the theoretical limit, and explodes just above it."""
    from adapters.panel import sheet
    from adapters.panel.finite_element.integrators import STABLE_SHARE

    critical_s = sheet.largest_step_s(plan(cells=(8, 1))) / STABLE_SHARE
    speeds = []
    for share in (0.99, 1.03):
        panel = opened(cells=(8, 1))
        panel._body.step_s = share * critical_s
        length_s = 1000 * share * critical_s
        load = Load(1e-6 * np.random.default_rng(6).normal(size=(len(panel.initial().surface), 3)))
        try:
            state = panel.advance(Interval(0, length_s), held(panel), load)
            speeds.append(np.abs(state.surface.velocity_m_per_s).max())
        except SolverFailed:
            speeds.append(np.inf)
        panel.close()
    assert speeds[0] < 1e-2
    assert speeds[1] > 1e2


@pytest.mark.parametrize(("integrator", "reason"), [("explicit", "unstable"), ("implicit", "Newton")])
def test_failure_names_panel_time_and_reason(integrator, reason):
    panel = opened(integrator=integrator, cells=(8, 1))
    load = Load(np.full((len(panel.initial().surface), 3), 1e6))
    with pytest.raises(SolverFailed, match=rf"\b1,.*{reason}"):
        panel.advance(Interval(0, 1e-3), held(panel), load)
