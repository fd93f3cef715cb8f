"""The contract of the panel port, on every adapter with its real solver."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.coupling.mapping import mapped
from orchestrator.ports import Array, BrokenRecord, Interpolation, Known, Load, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import surface_ahead
from orchestrator.ports.state import as_arrays
from tests.panel.contract import (
    CASES,
    INTERVAL_S,
    NEEDS_SOLVER,
    Case,
    StillPanel,
    defect_J,
    driven,
    held,
    loads,
    shifted,
    swung,
)
from tests.saved_states import differences

marked = [
    pytest.param(case, id=name, marks=[pytest.mark.solver] if name in NEEDS_SOLVER else [])
    for name, case in CASES.items()
]
every_adapter = pytest.mark.parametrize("case", marked)
GRAVITY_M_PER_S2 = np.array([0.0, 0.0, -9.81])


def mass_kg(case: Case) -> float:
    """Return the mass by the plan: the whole panel with the parts under its clamps, less its openings."""
    plan = case.plan
    area_m2 = (plan.rectangle.length_m + 2 * plan.rectangle.clamp_m) * plan.rectangle.width_m
    if plan.apertures:
        area_m2 -= len(plan.apertures.centres_m(plan.rectangle)) * plan.apertures.opening_m2
    return area_m2 * plan.thickness_m * plan.material.density_kg_per_m3


@every_adapter
def test_clamps_start_on_the_mount_and_at_rest(case: Case) -> None:
    panel = case.open()
    state, rectangle = panel.initial(), case.plan.rectangle
    assert not state.surface.velocity_m_per_s.any()
    assert set(panel.mount.frame) == {"driving", "driven"}
    ends = np.array([[s, y] for s in (0.0, rectangle.length_m) for y in (0, rectangle.width_m)])
    corners_m = panel.interpolation(ends).values @ state.surface.position_m
    assert corners_m == pytest.approx(rectangle.mounted(ends), abs=1e-12)
    nearest = np.abs(panel.mount.position_m[:, None] - corners_m).max(axis=2).min(axis=0)
    assert nearest.max() < 1e-12 + 0.5 * case.plan.thickness_m


@pytest.mark.smoke
@every_adapter
def test_at_rest_nothing_moves_and_the_reaction_is_the_weight(case: Case) -> None:
    panel = case.open()
    start = panel.initial()
    unloaded = Load.zero(len(start.surface))
    for index in range(50):
        state = panel.advance(Interval(index, INTERVAL_S), held(panel), unloaded)
    weight_N = mass_kg(case) * GRAVITY_M_PER_S2
    for reaction in (start.reaction, state.reaction):
        assert reaction.force_N.sum(axis=0) == pytest.approx(weight_N, abs=20 * case.still_N)
    assert state.reaction.force_N == pytest.approx(start.reaction.force_N, abs=case.still_N)
    assert state.surface.position_m == pytest.approx(start.surface.position_m, abs=1e-9)


@pytest.mark.smoke
@every_adapter
def test_interpolation_sums_to_one_and_reproduces_linear_fields(case: Case) -> None:
    rectangle, panel = case.plan.rectangle, case.open()
    rng = np.random.default_rng(7)
    low, high = -rectangle.clamp_m, rectangle.length_m + rectangle.clamp_m
    somewhere = np.column_stack([rng.uniform(low, high, 50), rng.uniform(0, rectangle.width_m, 50)])
    H = panel.interpolation(somewhere).values
    points = len(panel.initial().surface)
    assert H.shape == (50, points)
    assert H.sum(axis=1) == pytest.approx(np.ones(50), abs=1e-14)
    force = rng.normal(size=(50, 3))
    assert (H.T @ force).sum(axis=0) == pytest.approx(force.sum(axis=0), abs=1e-12)
    straight = unbent(case)
    off_m = H @ straight.open().initial().surface.position_m - straight.plan.rectangle.mounted(somewhere)
    assert np.ptp(off_m, axis=0).max() < 1e-11
    # a solid's surface may lie half its thickness above the middle
    assert off_m[0] == pytest.approx(off_m[0] @ rectangle.normal * rectangle.normal, abs=1e-11)
    assert 0.0 <= off_m[0] @ rectangle.normal + 1e-11 <= case.plan.thickness_m / 2 + 2e-11


@every_adapter
def test_coordinates_off_the_panel_are_refused(case: Case) -> None:
    with pytest.raises(ValueError, match="coordinate"):
        case.open().interpolation(np.array([[0.5, 0.01]]))


def beside_m(case: Case) -> Array:
    """Coordinates (60, 3) of points on both sides of the free length, at most 6 mm from it."""
    rectangle = case.plan.rectangle
    high_m = np.array([rectangle.length_m, rectangle.width_m, 0.006])
    return np.random.default_rng(8).uniform([0.0, 0.0, -0.006], high_m, (60, 3))


def places_m(points: Interpolation, own_m: Array) -> Array:
    """Return the places of the points, where the surface's own points rest at ``own_m``."""
    return mapped(StillPanel(Motion(own_m, np.zeros_like(own_m))), points).initial().surface.position_m


def unbent(case: Case) -> Case:
    """Return the case neither stretched nor sagging, between clamps that are not turned."""
    rectangle = replace(case.plan.rectangle, span_m=case.plan.rectangle.length_m, clamp_angle_deg=0.0)
    plan = replace(case.plan, rectangle=rectangle, gravity_m_per_s2=np.zeros(3), moulded_sag_m=0.0)
    return replace(case, plan=plan)


TURNED = Rotation.from_rotvec([0.8, -0.7, 0.5]).as_matrix()
"""By 67 degrees."""


@every_adapter
def test_points_beside_the_panel_go_with_its_normal(case: Case) -> None:
    """The points agree on a flat panel by hand, on one that is turned and moved as a whole by turning the
    places; to rounding. A point without an offset is on the surface, as if nothing was said of offsets."""
    panel, coordinates_m = unbent(case).open(), beside_m(case)
    points, own_m = panel.interpolation(coordinates_m), panel.initial().surface.position_m
    feet = panel.interpolation(coordinates_m[:, :2])
    assert not feet.offset_m.any()
    assert feet.along.nnz == feet.across.nnz == 0
    assert abs(points.values - feet.values).max() == 0.0
    normal = case.plan.rectangle.normal
    flat_m = places_m(feet, own_m) + coordinates_m[:, 2:] * normal
    assert places_m(points, own_m) == pytest.approx(flat_m, abs=1e-12)
    moved_m = np.array([3.0, -2.0, 1.0])
    turned_m = flat_m @ TURNED.T + moved_m
    assert places_m(points, own_m @ TURNED.T + moved_m) == pytest.approx(turned_m, abs=1e-12)


@every_adapter
def test_a_load_beside_a_bent_panel_keeps_its_force_its_moment_and_its_power(case: Case) -> None:
    """The power is that of any motion, on a surface that is bent by some tens of degrees and twisted; to
    rounding."""
    panel, rng = case.open(), np.random.default_rng(9)
    own_m, rectangle = panel.initial().surface.position_m.copy(), case.plan.rectangle
    s, y = ((own_m - rectangle.corner_m) @ axis for axis in (rectangle.along, rectangle.across))
    bent_m = 0.02 * np.sin(np.pi * s / rectangle.length_m) + 2.0 * s * y
    own_m += np.outer(bent_m, rectangle.normal)
    points = panel.interpolation(beside_m(case))
    velocity_m_per_s, force_N = rng.normal(size=own_m.shape), rng.normal(size=(60, 3))
    still = StillPanel(Motion(own_m, np.zeros_like(own_m)))
    seen = mapped(still, points)
    seen.advance(Interval(0, INTERVAL_S), Motion(*np.zeros((2, 1, 3))), Load(force_N))
    own_N = still.load.force_N
    assert own_N.sum(axis=0) == pytest.approx(force_N.sum(axis=0), abs=1e-12)
    places = mapped(StillPanel(Motion(own_m, velocity_m_per_s)), points).initial().surface
    moment_N_m = np.cross(places.position_m, force_N).sum(axis=0)
    assert np.cross(own_m, own_N).sum(axis=0) == pytest.approx(moment_N_m, abs=1e-12)
    power_W = float(np.vdot(places.velocity_m_per_s, force_N))
    size_W = float(np.abs(velocity_m_per_s * own_N).sum())
    assert float(np.vdot(velocity_m_per_s, own_N)) == pytest.approx(power_W, abs=1e-13 * size_W)


@every_adapter
def test_coordinates_of_another_kind_are_refused(case: Case) -> None:
    with pytest.raises(ValueError, match=r"\(5,\s4\)"):
        case.open().interpolation(np.zeros((5, 4)))
    with pytest.raises(ValueError, match="nan"):
        case.open().interpolation(np.array([[0.01, 0.01, np.nan]]))


@pytest.mark.smoke
@every_adapter
def test_momentum_balances_in_every_interval(case: Case) -> None:
    """change = gravity's impulse + load - reaction, to 1e-12 of the largest impulse."""
    panel = case.open()
    run = driven(panel, 200)
    size = max(np.abs(s.reaction.force_N).sum() for s in run.states) * INTERVAL_S
    for (before, after), load, state in zip(pairwise(run.accounts), run.loads, run.states[1:], strict=True):
        change = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s
        outside = after.outside_impulse_N_s - before.outside_impulse_N_s
        ports = INTERVAL_S * (load.force_N.sum(axis=0) - state.reaction.force_N.sum(axis=0))
        assert change == pytest.approx(outside + ports, abs=1e-12 * size)
    weight_N_s = 200 * INTERVAL_S * mass_kg(case) * GRAVITY_M_PER_S2
    given = run.accounts[-1].outside_impulse_N_s - run.accounts[0].outside_impulse_N_s
    assert given == pytest.approx(weight_N_s, rel=1e-9, abs=1e-12)


@every_adapter
def test_momentum_in_the_books_is_that_of_the_surface(case: Case) -> None:
    """A panel carried along as one moves its whole mass."""
    panel = case.open()
    velocity, state = np.array([0.3, -0.2, 0.1]), panel.initial()
    unloaded = Load.zero(len(state.surface))
    for index in range(3000):
        time_s = (index + 1) * INTERVAL_S
        started_s = min(time_s, 0.1)  # velocity (1 - cos) / 2 until 0.1 s
        ramp = (1 - np.cos(np.pi * started_s / 0.1)) / 2
        share_s = (started_s - 0.1 / np.pi * np.sin(np.pi * started_s / 0.1)) / 2
        end = shifted(panel, velocity * (share_s + time_s - started_s), ramp * velocity)
        state = panel.advance(Interval(index, INTERVAL_S), end, unloaded)
    momentum = panel.account().momentum_kg_m_per_s
    # Galilean invariance too: carried at constant velocity after a smooth start, a panel only
    # has its weight left; what still rings after 0.2 s is below 1e-3 of the starting force
    assert momentum == pytest.approx(mass_kg(case) * velocity, rel=1e-3, abs=1e-5)
    reaction_N = state.reaction.force_N.sum(axis=0)
    started_N = mass_kg(case) * np.linalg.norm(velocity) / 0.1
    assert reaction_N == pytest.approx(mass_kg(case) * GRAVITY_M_PER_S2, abs=1e-3 * started_N)


@every_adapter
def test_energy_defect_is_small_and_falls_with_the_interval(case: Case) -> None:
    """1e-3 of the work done on the panel at 2e-4 s; a quarter (or rounding) at half of it."""
    defects, work = [], []
    for split in (1, 2):
        interval_s = 2 * INTERVAL_S / split
        run = driven(case.open(interval_s, split), 150 * split, interval_s)
        defects.append(abs(defect_J(run.accounts[0], run.accounts[-1])))
        work.append(sum(abs(value) for value in run.accounts[-1].received_J.values()))
    assert defects[0] < 1e-3 * work[0]
    assert defects[1] < max(defects[0] / 2, 1e-12 * work[1])


@every_adapter
def test_a_constant_load_comes_out_as_reaction(case: Case) -> None:
    """Mean over the last 0.1 of 0.3 s: the panel has settled to 1e-3 of the load."""
    panel = case.open()
    points = len(panel.initial().surface)
    load = Load(np.tile([0.5 / points, -0.2 / points, -3.0 / points], (points, 1)))
    reactions = []
    for index in range(3000):
        state = panel.advance(Interval(index, INTERVAL_S), held(panel), load)
        reactions.append(state.reaction.force_N.sum(axis=0))
    mean_N: Array = np.mean(reactions[2000:], axis=0)
    expected = load.force_N.sum(axis=0) + mass_kg(case) * GRAVITY_M_PER_S2
    assert mean_N == pytest.approx(expected, abs=1e-3 * 3.0)


@every_adapter
def test_a_restored_panel_goes_on_bit_for_bit(case: Case) -> None:
    """A whole run, and one that another panel, freshly opened, takes over."""
    whole, first, second = (case.open() for _ in range(3))
    for panel in (whole, first):
        driven(panel, 40)
    saved = first.save()
    second.restore(saved)
    assert differences(saved, second.save()) == []
    runs = [driven(panel, 40, first=40) for panel in (whole, second)]
    for expected, actual in zip(*([*run.states, *run.accounts] for run in runs), strict=True):
        assert differences(as_arrays(expected), as_arrays(actual)) == []
    assert differences(whole.save(), second.save()) == []


@every_adapter
def test_a_panel_steps_back_bit_for_bit(case: Case) -> None:
    """The panel steps back in each of 40 intervals, after another load has moved it."""
    straight, hesitant = case.open(), case.open()
    points = len(straight.initial().surface)
    for index in range(40):
        before = hesitant.save()
        interval, end = Interval(index, INTERVAL_S), swung(hesitant, (index + 1) * INTERVAL_S)
        hesitant.advance(interval, end, Load(np.full((points, 3), 20.0 / points)))
        hesitant.restore(before)
        states = [driven(panel, 1, first=index).states[-1] for panel in (straight, hesitant)]
        assert differences(*map(as_arrays, states)) == []
    assert differences(straight.save(), hesitant.save()) == []


@every_adapter
def test_wrong_numbers_of_points_are_refused(case: Case) -> None:
    panel = case.open()
    points, clamps = len(panel.initial().surface), len(panel.mount.frame)
    with pytest.raises(BrokenRecord, match=rf"\b{points}\b.*\b{points + 1}\b"):
        panel.advance(Interval(0, INTERVAL_S), held(panel), Load.zero(points + 1))
    short = held(panel).part(slice(1, None))
    with pytest.raises(BrokenRecord, match=rf"\b{clamps}\b.*\b{clamps - 1}\b"):
        panel.advance(Interval(0, INTERVAL_S), short, Load.zero(points))


@every_adapter
def test_closing_twice_is_harmless(case: Case) -> None:
    panel = case.open()
    panel.close()
    panel.close()


@every_adapter
def test_what_clamps_alone_move_is_known_ahead(case: Case) -> None:
    """The load does not matter: where the clamps are known, all of a rigid panel and the held points of any
    other are known; where one clamp is, what does not hang on the other. Asking changes nothing."""
    panel, unasked = case.open(), case.open()
    first = np.array([frame == "driving" for frame in panel.mount.frame])
    every = np.ones(len(first), dtype=np.bool_)
    asked = surface_ahead(panel)
    for index in range(40):
        interval, end = Interval(index, INTERVAL_S), swung(panel, (index + 1) * INTERVAL_S)
        known, half = asked(interval, Known(end, every)), asked(interval, Known(end, first))
        nothing = asked(interval, Known(end, ~every))
        load = loads(len(known.which), (index + 0.5) * INTERVAL_S)
        surface = panel.advance(interval, end, load).surface
        unasked.advance(interval, end, load)
        for forecast in (known, half):
            which = forecast.which
            off_m = forecast.motion.position_m[which] - surface.position_m[which]
            off_m_per_s = forecast.motion.velocity_m_per_s[which] - surface.velocity_m_per_s[which]
            assert np.abs(off_m).max() < 1e-14
            assert np.abs(off_m_per_s).max() < 1e-11
        assert not nothing.which.any()
        assert (half.which <= known.which).all()
        assert 0 < half.which.sum() < known.which.sum()
        assert known.which.all() == (case.solver == "rigid")
    assert differences(panel.save(), unasked.save()) == []


def test_points_between_clamps_are_known_ahead_where_both_are() -> None:
    """The points are those of a rigid panel, seen through other points."""
    own = CASES["rigid"].open()
    sides_m = (CASES["rigid"].plan.rectangle.length_m, CASES["rigid"].plan.rectangle.width_m)
    panel = mapped(own, own.interpolation(np.array([(0.0, 0.5), (0.3, 0.2), (1.0, 0.5)]) * sides_m))
    first = np.array([frame == "driving" for frame in own.mount.frame])
    for index in range(40):
        interval, end = Interval(index, INTERVAL_S), swung(own, (index + 1) * INTERVAL_S)
        known = panel.ahead(interval, Known(end, np.ones_like(first)))
        half = panel.ahead(interval, Known(end, first))
        surface = panel.advance(interval, end, Load.zero(3)).surface
        assert known.which.all()
        assert half.which.tolist() == [True, False, False]
        assert known.motion.position_m == pytest.approx(surface.position_m, abs=1e-15)
        assert known.motion.velocity_m_per_s == pytest.approx(surface.velocity_m_per_s, abs=1e-13)
