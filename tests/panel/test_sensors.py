"""Sensors: masses that are fixed to a panel at a point."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from adapters.panel import sheet, solid, strip
from adapters.panel.common.grid import ElementGrid
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.solver_plans import panel_plans
from orchestrator.output.report import pictures
from orchestrator.ports.plans import PanelPlan, PointMass
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, case_folder, kinds
from tests.panel.elastic_plans import plan

SENSOR_KG = 0.02
GRAVITY_M_PER_S2 = 9.81
PROBE = '[probes.sensor]\npanel = "deck"\nat = [0.25, 0.5]\nsensor_kg = 0.02\n'


def equipped(bare: PanelPlan, share: float) -> PanelPlan:
    """A sensor in the middle of the width, at a share of the free length."""
    at = bare.rectangle
    return replace(bare, point_masses=(PointMass(share * at.length_m, 0.5 * at.width_m, SENSOR_KG),))


def clamps_N(panel: object) -> np.ndarray:
    """Return the upward forces on a resting panel's clamps, of the first and the second."""
    up_N = -panel.initial().reaction.force_N[:, 2]  # type: ignore[attr-defined]
    first = np.array([frame == "driving" for frame in panel.mount.frame])  # type: ignore[attr-defined]
    panel.close()  # type: ignore[attr-defined]
    return np.array([up_N[first].sum(), up_N[~first].sum()])


@pytest.mark.parametrize("share", [0.25, 0.29])
@pytest.mark.parametrize("build", [strip.build, pytest.param(sheet.build, marks=pytest.mark.solver)])
def test_the_clamps_carry_the_sensors_weight_by_the_lever(build, share: float) -> None:
    """The panel is taut; its sag and its bending at the clamps shift 5 % of the smaller part."""
    bare = plan(cells=(8, 2), span_m=0.3382)
    added_N = clamps_N(build(equipped(bare, share))) - clamps_N(build(bare))
    weight_N = SENSOR_KG * GRAVITY_M_PER_S2
    assert added_N.sum() == pytest.approx(weight_N, rel=1e-5)
    assert added_N == pytest.approx([(1 - share) * weight_N, share * weight_N], rel=0.06)


def test_shares_of_a_grid_are_positive_and_keep_the_centre_of_mass() -> None:
    grid = ElementGrid.of(plan().rectangle, (5, 3))
    places_m = np.array([[0.07, 0.021], [0.33, 0.0], [0.2, 0.05]])
    shares = grid.shares(places_m).toarray()
    assert (shares >= 0).all()
    np.testing.assert_allclose(shares.sum(axis=1), 1.0)
    np.testing.assert_allclose(shares @ grid.nodes_m(), places_m, atol=1e-12)


def test_a_probe_with_a_sensor(tmp_path: Path) -> None:
    loaded = load_judged(case_folder(tmp_path / "case", CASE + PROBE))
    (panel,) = panel_plans(loaded.case)
    (mass,) = panel.point_masses
    assert (mass.along_m, mass.mass_kg) == (0.25 * panel.rectangle.length_m, SENSOR_KG)
    assert [*solid.objections(panel)]
    assert [*solid.objections(replace(panel, point_masses=()))] == []
    assert find_problems(loaded) == []


def test_sensors_that_have_no_place(tmp_path: Path) -> None:
    on_frame = 'probes.p={frame="driving", point_m=[0, 0, 0], sensor_kg=0.02}'
    assert kinds(tmp_path, on_frame) == ["probes.p.sensor_kg: conflict"]
    on_panel = 'probes.p={panel="deck", at=[0.5, 0.5], sensor_kg=0.02}'
    assert "probes.p.sensor_kg: conflict" in kinds(tmp_path, on_panel, "slice.width_m=0.05")


def test_a_panel_with_probes_is_drawn_at_four_instants(tmp_path: Path) -> None:
    """A quarter of a cycle apart, each with the places of the probes at that instant."""
    case = load_judged(case_folder(tmp_path / "case", CASE)).case
    (panel,) = single_panels(case)
    at, cycle_s = panel.rectangle, 0.08
    time_s = np.linspace(0.0, 0.4, 401)
    heights_m = 0.01 * np.sin(2 * np.pi * time_s / cycle_s)
    points_m = at.corner_m + at.along * 0.5 * at.length_m + np.outer(heights_m, at.normal)
    lines_m = np.stack([points_m - 0.1 * at.along, points_m, points_m + 0.1 * at.along], axis=1)
    data = {
        "panels/deck/time_s": time_s,
        "panels/deck/centre_line_m": lines_m,
        "probes/p/time_s": time_s,
        "probes/p/position_m": points_m,
    }
    run = SimpleNamespace(case=case, read=data.__getitem__, cycle_s=cycle_s, end_s=0.4)
    drawn = pictures.draw_panel_instants(run, {panel.name: ["p"]})  # type: ignore[arg-type]
    heights_mm = [float(ax.lines[1].get_ydata()[0]) for ax in drawn.axes[:4]]
    assert heights_mm == pytest.approx([10.0, 0.0, -10.0, 0.0], abs=1e-6)
