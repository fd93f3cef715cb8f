"""Modes that alternate and grow are found; those that only move, ring or rattle are not."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from orchestrator.coupling.schemes import create_scheme
from orchestrator.coupling.schemes.scheme import initial_state
from orchestrator.ports import Array
from orchestrator.ports.clock import Interval
from orchestrator.preflight.stability.limits import light_point_s
from orchestrator.run.monitor.items import Alternation
from tests.coupling.line import FreeFrame, HungPlate, Sphere, members
from tests.saved_states import differences
from tests.stability.growth import CONTACT, Line, limit_s

POINTS, LOUD = 50, 0.1
STROKE = np.linspace(0.0, 1.0, POINTS)[:, None] * np.array([1.0, 0.0, 0.5])  # m/s
TURN = 78.5 * 5e-5  # of the machine, in a sync interval


def worst(velocities_m_per_s: Iterable[Array]) -> float:
    steps = iter(velocities_m_per_s)
    watched, largest = Alternation(next(steps), LOUD), 0.0
    for velocity_m_per_s in steps:
        watched.add([velocity_m_per_s])
        largest = max(largest, watched.share())
    return largest


def shaken(intervals: int) -> list[Array]:
    return [np.sin(TURN * n) * STROKE for n in range(intervals)]


@pytest.mark.parametrize("root", [-1.02, -1.2, -3.0])
def test_one_point_that_grows_among_others_that_move(root: float) -> None:
    shape = np.zeros((POINTS, 3))
    shape[17] = [0.0, 0.0, 1e-6]
    until = round(np.log(1e9) / np.log(-root))  # to 1000 m/s
    assert worst(v + root**n * shape for n, v in enumerate(shaken(until))) > LOUD


@pytest.mark.parametrize("root", [-0.9, 0.9, 1.02, -1.0, 1j, -0.7 + 0.7j, 0.9j])
def test_what_rings_or_grows_slowly_is_none(root: complex) -> None:
    """Modes that an interval samples at any phase, and what alternates but does not grow."""
    shape = np.zeros((POINTS, 3))
    shape[17] = [0.0, 0.0, 1.0]
    assert worst(v + (root**n).real * shape for n, v in enumerate(shaken(300))) == 0.0


@pytest.mark.parametrize("ringing", [0.0, -0.5, 1.0])
def test_a_rattling_bed_is_none(ringing: float) -> None:
    """Blows at random, on points that forget them at once, ring at the interval's own frequency, or
    keep their speed: 100 points, 5000 intervals; as loud as all that moves."""
    chance = np.random.default_rng(1)
    blows = chance.normal(size=(5000, 100, 3)) * (chance.random((5000, 100, 1)) < 0.1)
    speed = np.zeros((100, 3))
    assert worst(speed := ringing * speed + blow for blow in blows) == 0.0


def test_rounding_that_grows_at_rest_is_too_slow_to_count() -> None:
    shape = 1e-12 * np.ones((POINTS, 3))
    assert worst((-1.2) ** n * shape for n in range(60)) < LOUD


def test_it_begins_anew_with_intervals_of_another_length() -> None:
    watched = Alternation(np.zeros((1, 3)), LOUD)
    for n in range(20):
        watched.add([np.full((1, 3), (-1.2) ** n)])
    assert watched.share() > LOUD
    watched.begin_anew()
    assert watched.share() == 0.0
    for n in range(6):  # not yet as often as needed
        watched.add([np.full((1, 3), (-1.2) ** n)])
    assert watched.share() == 0.0


def test_it_is_restored() -> None:
    watched, other = (Alternation(np.zeros((2, 3)), LOUD) for _ in range(2))
    for n in range(7):
        watched.add([np.array([[0.0, 0.0, (-1.2) ** n], [0.0, 0.0, 1.0]])])
    other.restore(watched.save())
    for n in range(7, 12):
        for each in (watched, other):
            each.add([np.array([[0.0, 0.0, (-1.2) ** n], [0.0, 0.0, 1.0]])])
        assert watched.share() == other.share()
    assert watched.share() > LOUD


@pytest.mark.parametrize("cut", [1, 4, 9, 23])
def test_how_many_sync_points_come_at_once_makes_no_difference(cut: int) -> None:
    """Second differences that alternate and grow, are too small to count, and then reverse once."""
    growing = 2 * (-1.2) ** np.arange(12)
    changes = np.concatenate([[0.0, 0.0], growing, [0.0, 1.0, -20.0, 0.0, 1.0]])
    velocities = [np.array([[0.0, 0.0, v], [5.0, 0.0, 0.0]]) for v in changes.cumsum().cumsum()]
    whole, one_by_one, shares = Alternation(velocities[0], LOUD), Alternation(velocities[0], LOUD), []
    for first in range(0, len(velocities), cut):
        whole.add(velocities[first : first + cut])
        for velocity in velocities[first : first + cut]:
            one_by_one.add([velocity])
            shares.append(one_by_one.share())
        assert differences(one_by_one.save(), whole.save()) == []
    assert shares[13] > LOUD
    assert shares[14:] == [0.0] * 5


def held_down(damping_N_s_per_m: float, v: float) -> tuple[Sphere, HungPlate, FreeFrame]:
    """A heavy sphere that stays on a free plate of 1 kg, which has the speed v."""
    sphere = Sphere(1e6, 1.0, 0.0, 0.0, 20, damping_N_s_per_m, stays=True)
    return sphere, HungPlate(1.0, 0.0, 20, v=v), FreeFrame(1e6)


@pytest.mark.parametrize("damping_N_s_per_m", [0.0, 0.3, 3.0])
@pytest.mark.parametrize(("of_the_limit", "is_found"), [(1.1, True), (0.9, False)])
def test_the_real_limit_of_a_light_point(
    damping_N_s_per_m: float, of_the_limit: float, is_found: bool
) -> None:
    """The limit is found by bisection of the real loop: beyond it the watch sees the mode, below it does
    not."""
    predicted_s = light_point_s(1.0, damping_N_s_per_m, 1.0, 0.0)
    line = Line(*held_down(damping_N_s_per_m, 0.0))
    limit = limit_s(lambda h: line.radius("particles-first", h, CONTACT), predicted_s)
    interval_s = of_the_limit * limit
    solvers = members(*held_down(damping_N_s_per_m, 1e-3))
    state, advance = initial_state(solvers), create_scheme("particles-first").advance
    watched, share = Alternation(state.panel.surface.velocity_m_per_s, LOUD), 0.0
    for index in range(60):
        interval = Interval(index, interval_s)
        state = advance(solvers, interval, state)
        watched.add([state.panel.surface.velocity_m_per_s])
        share = max(share, watched.share())
    assert (share > LOUD) is is_found
