"""rigid: Newton's second law on lumped masses, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adapters.panel.rigid import build
from orchestrator.ports import Load, Motion
from orchestrator.ports.clock import Interval
from tests.panel.contract import INTERVAL_S, held, shifted
from tests.panel.elastic_plans import plan

PLAN = plan(clamp_m=0.02)
MASS_KG = (0.33 + 2 * 0.02) * 0.05 * 0.004 * 1200.0


def test_mass_and_centre_of_mass_are_those_of_the_sheet() -> None:
    panel = build(PLAN)
    weight_N = panel.initial().reaction.force_N
    assert weight_N.sum(axis=0) == pytest.approx([0.0, 0.0, -9.81 * MASS_KG])
    moment = np.cross(panel.mount.position_m, weight_N).sum(axis=0)
    centre_m = PLAN.rectangle.mounted(np.array([[0.33 / 2, 0.05 / 2]]))[0]
    assert moment == pytest.approx(np.cross(centre_m, weight_N.sum(axis=0)))


def test_reaction_is_load_and_weight_less_inertia() -> None:
    panel = build(PLAN)
    velocity = np.array([0.2, 0.0, 0.1])
    load = Load(np.random.default_rng(8).normal(size=(8, 3)))
    end = shifted(panel, velocity * INTERVAL_S / 2, velocity)
    state = panel.advance(Interval(0, INTERVAL_S), end, load)
    expected = load.force_N.sum(axis=0) + MASS_KG * (np.array([0.0, 0.0, -9.81]) - velocity / INTERVAL_S)
    assert state.reaction.force_N.sum(axis=0) == pytest.approx(expected)
    assert state.surface.position_m == pytest.approx(end.position_m)


def test_work_of_lifting_is_the_gain_in_height() -> None:
    panel = build(PLAN)
    load = Load.zero(8)
    for index, end in enumerate(
        [
            shifted(panel, np.array([0.0, 0.0, 0.01]), np.array([0.0, 0.0, 1.0])),
            shifted(panel, np.array([0.0, 0.0, 0.02]), np.zeros(3)),
        ]
    ):
        panel.advance(Interval(index, 0.01), end, load)
    assert panel.account().received_J["clamps"] == pytest.approx(MASS_KG * 9.81 * 0.02)


def test_a_panel_without_clamp_depth_has_four_points() -> None:
    panel = build(replace(PLAN, rectangle=replace(PLAN.rectangle, clamp_m=0.0)))
    assert panel.mount.frame == ("driving", "driving", "driven", "driven")
    still = panel.advance(Interval(0, INTERVAL_S), held(panel), Load.zero(4))
    assert still.reaction.force_N.sum(axis=0) == pytest.approx(
        [0.0, 0.0, -9.81 * 0.33 * 0.05 * 0.004 * 1200.0]
    )


def test_surface_between_the_clamps_is_bilinear() -> None:
    panel = build(PLAN)
    lifted = panel.mount.position_m.copy()
    lifted[-1] += [0.0, 0.0, 0.04]
    lifted[-3] += [0.0, 0.0, 0.04]  # the second clamp's edge y = width, both rows
    state = panel.advance(Interval(0, INTERVAL_S), Motion(lifted, np.zeros((8, 3))), Load.zero(8))
    middle = panel.interpolation(np.array([[0.33 / 2, 0.05 / 2]])).values @ state.surface.position_m
    assert middle[0, 2] - 0.3 == pytest.approx(0.01)
