"""The cheap panel against the dear one where both apply: strip and sheet, same material.

In the sheet the clamps hinder the contraction across, over about half a width from each clamp, where it is up
to 4/3 as stiff (plane strain).  The strip has this as a share of its whole length."""

from __future__ import annotations

from dataclasses import replace
from types import ModuleType

import numpy as np
import pytest

from adapters.panel import sheet, strip
from orchestrator.case.file.slice import hindered_share_of
from orchestrator.ports import Array
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import PanelPlan
from tests.panel.elastic_plans import BRANCHES, difference, plan, pull_N, shake

pytestmark = pytest.mark.solver


def shaken_both(given: PanelPlan) -> list[tuple[Array, Array]]:
    """Height of the middle over the clamps and pull on the second frame, for strip and sheet,
    over 0.04 s of 6 mm sin^2: half a cycle."""
    return [shaken(solver, given) for solver in (strip, sheet)]


def shaken(solver: ModuleType, given: PanelPlan) -> tuple[Array, Array]:
    """The same of one solver."""
    middle = np.array([[given.rectangle.length_m / 2, given.rectangle.width_m / 2]])
    panel = solver.build(given)
    states, start = shake(panel, 1e-4, 400)
    H = panel.interpolation(middle).values
    height = [(H @ state.surface.position_m)[0, 2] - 0.3 for state in (start, *states)]
    pull = [pull_N(panel, state) for state in (start, *states)]
    panel.close()
    return np.array(height), np.array(pull)


def resting_pull_N(solver: ModuleType, given: PanelPlan) -> float:
    """Pull on the second frame at rest."""
    panel = solver.build(given)
    pull = pull_N(panel, panel.initial())
    panel.close()
    return float(pull)


def test_narrow_taut_panel() -> None:
    """Width / length = 0.15: clamps stiffen at most w / L / 3 = 5 % of the length's compliance;
    pull within 3 %, sag (which goes with 1 / pull) within 5 %."""
    given = plan(span_m=0.33 * 1.02, cells=(24, 1), branches=BRANCHES)
    (height, pull), (sheet_height, sheet_pull) = shaken_both(given)
    assert 0.97 < pull[0] / sheet_pull[0] < 1.0
    assert height[0] == pytest.approx(sheet_height[0], rel=0.05)
    assert difference(pull, sheet_pull) < 0.03


@pytest.mark.parametrize(
    ("width_over_length", "joined_sides"), [(0.67, False), (2.0, False), (2.67, False), (0.2, True)]
)
def test_a_strip_pulls_as_a_sheet_whose_contraction_is_hindered(
    width_over_length: float, joined_sides: bool
) -> None:
    """Stretched by 2 %, with the share for its width (the pull of sheets, measured at 1 and 5 %): 1 %, of
    which half is the mesh; without the share the strip pulls 4 to 25 % less."""
    share = 1.0 if joined_sides else hindered_share_of(width_over_length)
    taut = plan(
        span_m=0.33 * 1.02, width_m=0.33 * width_over_length, cells=(16, 8), joined_sides=joined_sides
    )
    sheets_N, strips_N, free_N = (
        resting_pull_N(solver, replace(taut, hindered_share=hindered))
        for solver, hindered in ((sheet, 0.0), (strip, share), (strip, 0.0))
    )
    assert strips_N == pytest.approx(sheets_N, rel=0.01)
    assert abs(free_N) < 0.97 * abs(sheets_N)


@pytest.mark.parametrize(("width_over_length", "joined_sides"), [(2.67, False), (0.3, True)])
def test_a_perforated_strip_pulls_as_a_sheet_whose_contraction_is_hindered(
    width_over_length: float, joined_sides: bool
) -> None:
    """Slots of 20 x 3 mm, stretched by 2 %: 2 %; without the share the strip pulls 4 and 8 % less."""
    share = 1.0 if joined_sides else hindered_share_of(width_over_length)
    taut = plan(
        span_m=0.33 * 1.02,
        width_m=0.33 * width_over_length,
        cells=(22, 1 if joined_sides else 8),
        joined_sides=joined_sides,
        apertures=AperturePattern("slot", 0.020, 0.003, 0.025, 0.006),
    )
    sheets_N, strips_N, free_N = (
        resting_pull_N(solver, replace(taut, hindered_share=hindered))
        for solver, hindered in ((sheet, 0.0), (strip, share), (strip, 0.0))
    )
    assert strips_N == pytest.approx(sheets_N, rel=0.02)
    assert abs(free_N) < 0.97 * abs(sheets_N)


def test_narrow_slack_panel() -> None:
    """The sag of a slack panel is geometry: 2 %."""
    given = plan(span_m=0.33 * 0.99, cells=(24, 1), branches=BRANCHES)
    (height, pull), (sheet_height, sheet_pull) = shaken_both(given)
    assert height[0] == pytest.approx(sheet_height[0], rel=0.02)
    assert difference(height, sheet_height) < 0.05
    assert np.abs(pull).max() == pytest.approx(np.abs(sheet_pull).max(), rel=0.05)


def test_a_slack_panel_between_turned_clamps_moves_alike() -> None:
    """Clamps at 20 degrees, a moulded sag of 10 mm and 3 % of slack, of which the clamp takes up two thirds:
    heights within 2 % at rest and 5 % in motion, as of flat clamps."""
    given = plan(
        span_m=0.33 * 0.97, cells=(24, 1), branches=BRANCHES, clamp_angle_deg=20.0, moulded_sag_m=0.01
    )
    (height, _), (sheet_height, _) = shaken_both(given)
    assert height[0] == pytest.approx(sheet_height[0], rel=0.02)
    assert difference(height, sheet_height) < 0.05


def test_wide_taut_panel_lies_between_uniaxial_and_plane_strain() -> None:
    given = plan(span_m=0.33 * 1.02, width_m=0.4, cells=(24, 4), branches=BRANCHES)
    strip_N, sheet_N = (
        pull_N(panel, panel.initial())
        for panel in (strip.build(given), sheet.build(replace(given, name="sheet")))
    )
    assert 1.0 < sheet_N / strip_N < 4 / 3


def test_coarse_and_fine_sheets_move_alike() -> None:
    """A slack narrow panel over 0.04 s: against 36 cells, 12 within 1 % in height and pull, 24
    within half of it, as the mesh error falls (measured 0.45, 0.25; 0.20, 0.14 %)."""
    given = plan(span_m=0.33 * 0.99, cells=(36, 1), branches=BRANCHES)
    fine = shaken(sheet, given)
    for cells, allowed in ((12, 0.01), (24, 0.005)):
        here = shaken(sheet, replace(given, cells=(cells, 1)))
        assert difference(here[0], fine[0]) < allowed
        assert difference(here[1], fine[1]) < allowed
