"""carried: what goes in comes out."""

from __future__ import annotations

import numpy as np
import pytest

from adapters.panel.common.carried import build
from orchestrator.ports import BrokenRecord, Load, Motion
from orchestrator.ports.clock import Interval
from tests.panel.contract import INTERVAL_S, held
from tests.saved_states import differences

POINTS_M = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]])
LIFTED_M = POINTS_M + np.array([0.0, 0.0, 0.1])


def test_surface_is_the_clamps_and_reaction_the_load() -> None:
    wall = build(POINTS_M, ("driving",) * 3)
    start = wall.initial()
    assert wall.mount.frame == ("driving",) * 3
    assert np.array_equal(start.surface.position_m, POINTS_M)
    assert not start.reaction.force_N.any()
    moved = Motion(LIFTED_M, np.ones((3, 3)))
    load = Load(np.arange(9.0).reshape(3, 3))
    state = wall.advance(Interval(0, INTERVAL_S), moved, load)
    assert np.array_equal(state.surface.position_m, moved.position_m)
    assert np.array_equal(state.surface.velocity_m_per_s, moved.velocity_m_per_s)
    assert np.array_equal(state.reaction.force_N, load.force_N)


def test_books_are_those_of_a_massless_body() -> None:
    wall = build(POINTS_M, ("driving",) * 3)
    moved = Motion(LIFTED_M, np.ones((3, 3)))
    wall.advance(Interval(0, INTERVAL_S), moved, Load(np.full((3, 3), 2.0)))
    account = wall.account()
    assert account.received_J == pytest.approx({"load": 0.6, "clamps": -0.6})
    assert not account.momentum_kg_m_per_s.any()
    assert not account.outside_impulse_N_s.any()


def test_wrong_numbers_of_points_are_refused() -> None:
    wall = build(POINTS_M, ("driving",) * 3)
    with pytest.raises(BrokenRecord, match=r"\b3\b.*\b2\b"):
        wall.advance(Interval(0, INTERVAL_S), held(wall), Load.zero(2))
    with pytest.raises(BrokenRecord, match=r"\b3\b.*\b2\b"):
        wall.advance(Interval(0, INTERVAL_S), held(wall).part(slice(2)), Load.zero(3))
    wall.close()
    wall.close()


def test_a_restored_wall_goes_on_as_the_saved_one() -> None:
    wall, other = build(POINTS_M, ("driving",) * 3), build(POINTS_M, ("driving",) * 3)
    load = Load(np.arange(9.0).reshape(3, 3))
    wall.advance(Interval(0, INTERVAL_S), Motion(LIFTED_M, np.ones((3, 3))), load)
    other.restore(wall.save())
    for part in (wall, other):
        part.advance(Interval(1, INTERVAL_S), Motion(2 * LIFTED_M, np.ones((3, 3))), load)
    assert differences(wall.save(), other.save()) == []
    assert wall.account().received_J["load"] == pytest.approx(1.5 + 18.5)
