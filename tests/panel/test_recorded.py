"""A recorded panel against the formulas it was recorded from, and its books while it moves."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adapters.panel import recorded, rigid
from orchestrator.ports import Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan
from tests.panel import test_contract as contract_tests
from tests.panel.contract import CASES, INTERVAL_S, Case, held, shifted, small
from tests.panel.recordings import PULL_N, SAMPLES, arch, moved, playback, rate

STEP_RAD = 2 * np.pi / SAMPLES
# cubic Hermite between samples: h^4 / 384 of the fourth derivative (16 for twice the speed)
ALLOWED_M = STEP_RAD**4 / 384 * (1e-2 + 16 * 1e-3)


def moving() -> PanelPlan:
    return replace(small("explicit"), playback=playback(small("explicit"), 1.0))


def test_the_shape_at_any_time_is_the_one_recorded() -> None:
    """Also between samples; the rate to h^3 / (72 sqrt 3) or so of the fourth derivative."""
    plan = moving()
    played = recorded.Player(playback(plan, 1.0))
    shape = arch(plan, playback(plan, 1.0).recording.grid.points_m)[:, None]
    for time_s in (0.1001, 0.1234, 0.2, 3.3333):
        angle = 78.5 * (time_s - 0.01)
        shape_m, rate_m_per_s = played.shape(time_s)
        wanted_m = shape * (moved(angle) - np.array([0.0, 0.0, 2e-3]))
        assert shape_m == pytest.approx(wanted_m, abs=1.01 * ALLOWED_M)
        assert rate_m_per_s == pytest.approx(78.5 * shape * rate(angle), abs=78.5 * 4 * ALLOWED_M / STEP_RAD)


def test_velocity_is_the_rate_of_the_place_while_it_grows_and_across_samples() -> None:
    """Central differences of 1e-6 s: to 1e-6 of the largest velocity."""
    played = recorded.Player(playback(small("explicit"), 1.0))
    samples_s = 0.01 + STEP_RAD / 78.5 * np.arange(1, 100)
    for time_s in (*np.linspace(0.019, 0.11, 50), *samples_s):
        before, after = (played.shape(time_s + step_s)[0] for step_s in (-1e-6, 1e-6))
        assert (after - before) / 2e-6 == pytest.approx(played.shape(time_s)[1], abs=1e-4)


def test_nothing_moves_before_the_machine_starts() -> None:
    panel = recorded.build(moving())
    start, unloaded = panel.initial(), Load.zero(len(panel.initial().surface))
    for index in range(200):  # until 0.02 s
        state = panel.advance(Interval(index, INTERVAL_S), held(panel), unloaded)
    assert state.surface.position_m == pytest.approx(start.surface.position_m, abs=1e-12)
    assert not state.surface.velocity_m_per_s.any()


def test_the_pull_at_rest_is_the_recorded_one() -> None:
    panel = recorded.build(moving())
    reaction_N = panel.initial().reaction.force_N
    first = np.array([frame == "driving" for frame in panel.mount.frame])
    difference_N = reaction_N[first].sum(axis=0) - reaction_N[~first].sum(axis=0)
    assert difference_N == pytest.approx(2 * PULL_N, abs=1e-12)


def test_the_surface_has_no_kinks_and_goes_through_the_grid() -> None:
    """Slopes of the arch on both sides of a row of grid points agree to rounding; between them
    the arch is met to 2e-3 of its height with 8 cells."""
    plan, grid = moving(), playback(moving(), 1.0).recording.grid
    s = np.linspace(0.0, plan.rectangle.length_m, 401)
    places = np.column_stack([s, np.full_like(s, 0.013)])
    heights = arch(plan, grid.points_m)
    met = recorded.build(plan).interpolation(places).values @ heights
    assert met == pytest.approx(arch(plan, places), abs=2e-2)
    row = grid.rows_m[len(grid.rows_m) // 2 - 2]
    h = 1e-7
    near = (
        recorded.build(plan)
        .interpolation(np.array([[row - h, 0.013], [row, 0.013], [row + h, 0.013]]))
        .values
    )
    below, at, above = near @ heights
    assert (above - at) / h == pytest.approx((at - below) / h, rel=1e-4)


def test_momentum_and_energy_close_while_it_moves() -> None:
    """The contract's tolerances, with a shape that moves by 10 mm and a pull that changes."""
    case = Case("recorded", moving(), CASES["rigid"].still_N)
    contract_tests.test_momentum_balances_in_every_interval(case)
    contract_tests.test_energy_defect_is_small_and_falls_with_the_interval(case)


def test_what_the_recording_supplies_is_the_work_of_a_known_force() -> None:
    """A lump at the middle of a panel on still clamps: over a whole cycle of steady motion the
    shape's forces do the negative of the load's work, F_z dz, to the time steps' 1e-3."""
    panel = recorded.build(moving())
    points = len(panel.initial().surface)
    cycle = 800
    interval_s = 2 * np.pi / 78.5 / cycle
    supplied, received = [], []
    for index in range(3 * cycle):
        load = Load(np.zeros((points, 3)))
        angle = 78.5 * ((index + 0.5) * interval_s - 0.01)
        load.force_N[points // 2, 2] = 3.0 * np.cos(angle)
        panel.advance(Interval(index, interval_s), held(panel), load)
        if index + 1 in (2 * cycle, 3 * cycle):
            supplied.append(panel.account().supplied_J["recording"])
            received.append(panel.account().received_J["load"])
    work_J = 3.0 * 1e-2 * np.pi  # of F cos on A sin: F A pi
    assert np.diff(received)[0] == pytest.approx(work_J, rel=1e-3)
    assert np.diff(supplied)[0] == pytest.approx(-work_J, rel=1e-3)


def test_a_plan_without_recording_is_refused() -> None:
    with pytest.raises(ValueError, match="nothing is recorded"):
        recorded.build(small("explicit"))


def test_a_recording_checks_itself() -> None:
    good = playback(small("explicit"), 1.0).recording
    with pytest.raises(ValueError, match="pull_N"):
        replace(good, pull_N=good.pull_N[1:])


def test_a_recording_of_a_flat_panel_is_a_rigid_one() -> None:
    """Carried to and fro with a load that is not in the middle: place to rounding, the force on
    each clamp to rounding, as both pass on by the lever rule."""
    flat = replace(small("explicit"), playback=playback(small("explicit"), 0.0, sag_m=0.0))
    panels = [recorded.build(flat), rigid.build(flat)]
    s = flat.rectangle.length_m * np.array([0.2, 0.35, 0.8])
    places = np.column_stack([s, np.array([0.01, 0.03, 0.04])])
    force_N = np.array([[1.0, 0.0, -5.0], [0.0, 2.0, -3.0], [0.5, 0.0, -1.0]])
    for index in range(20):
        time_s = (index + 1) * INTERVAL_S
        middles, firsts = [], []
        for panel in panels:
            H = panel.interpolation(places).values
            moved_m = np.array([4e-3, 0.0, 5e-3]) * np.sin(78.5 * time_s) ** 2
            rate_m_per_s = np.array([4e-3, 0.0, 5e-3]) * 78.5 * np.sin(2 * 78.5 * time_s)
            end = shifted(panel, moved_m, rate_m_per_s)
            state = panel.advance(Interval(index, INTERVAL_S), end, Load(H.T @ force_N))
            first = np.array([frame == "driving" for frame in panel.mount.frame])
            middles.append(H @ state.surface.position_m)
            firsts.append(state.reaction.force_N[first].sum(axis=0))
        assert middles[0] == pytest.approx(middles[1], abs=1e-12)
        assert firsts[0] - PULL_N == pytest.approx(firsts[1], abs=1e-9)
