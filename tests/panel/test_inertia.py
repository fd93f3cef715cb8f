"""The masses that panels tell of, against what an impulse does to them."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from orchestrator.coupling.mapping import mapped
from orchestrator.coupling.panel_set import PanelSet
from orchestrator.ports import Array, Load, Motion, Panel
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import surface_inertia
from tests.panel.contract import CASES, Case

SHORT_S = 1e-7  # far less than the period of any mode: a load is an impulse
COARSE = np.array([[0.02, 0.01], [0.031, 0.02], [0.06, 0.013], [0.09, 0.03]])
ELASTIC = ["strip", "sheet-explicit", "sheet-implicit", "solid"]


def velocity_m_per_s(case: Case, through: bool, load_N: Array | None) -> tuple[Array, Panel]:
    """(points, 3) after an impulse of ``load_N`` over ``SHORT_S``, and the panel."""
    own = case.open(SHORT_S)
    panel: Panel = mapped(own, own.interpolation(COARSE)) if through else own
    with closing(panel):
        points = len(panel.initial().surface)
        clamps = Motion(panel.mount.position_m, 0.0 * panel.mount.position_m)
        load = Load.zero(points) if load_N is None else Load(load_N)
        return panel.advance(Interval(0, SHORT_S), clamps, load).surface.velocity_m_per_s, panel


@pytest.mark.solver
@pytest.mark.parametrize("through", [False, True])
@pytest.mark.parametrize("name", ELASTIC)
def test_an_impulse_gives_the_velocity_of_the_masses(name: str, through: bool) -> None:
    """v = shapes (shapes' impulse / mass); within 1e-3: the solid's mass is not lumped as its
    stiffness is."""
    case = CASES[name]
    idle_m_per_s, panel = velocity_m_per_s(case, through, None)
    load_N = np.random.default_rng(5).normal(0.0, 1.0, idle_m_per_s.shape)
    pushed_m_per_s, _ = velocity_m_per_s(case, through, load_N)
    inertia = surface_inertia(panel)
    masses_N = inertia.yielding(inertia.shapes.T @ load_N)
    expected = inertia.shapes @ (masses_N / inertia.mass_kg[:, None])
    acceleration_m_per_s2 = (pushed_m_per_s - idle_m_per_s) / SHORT_S
    assert np.abs(expected).max() > 0
    np.testing.assert_allclose(acceleration_m_per_s2, expected, rtol=0, atol=1e-3 * np.abs(expected).max())


def test_of_some_panels_nothing_is_known() -> None:
    """One after the other: a strip, a rigid panel, a strip."""

    def opened(number: int) -> Panel:
        return CASES["rigid" if number == 1 else "strip"].open()

    with closing(PanelSet(3, opened)) as together:
        inertia, (first, rigid, last) = together.inertia(), together.surface
    known = np.diff(inertia.shapes.indptr) > 0
    assert known[first].any()
    assert not known[rigid].any()
    assert np.array_equal(known[first], known[last])
    assert inertia.shapes.shape == (len(known), len(inertia.mass_kg))
