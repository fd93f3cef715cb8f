"""Points beside a panel: how well their normal is that of a circle, and that it has no jumps."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from adapters.panel import rigid
from adapters.panel.common import bilinear
from adapters.panel.common.grid import ElementGrid
from adapters.panel.common.solid_grid import solid_grid
from adapters.panel.strip.chain import build_chain
from orchestrator.coupling.mapping import mapped
from orchestrator.ports import Array, Interpolation, Motion
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import PanelPlan
from tests.panel.contract import StillPanel
from tests.panel.elastic_plans import plan

LENGTH_M, WIDTH_M, CLAMP_M = 0.3, 0.04, 0.02
RADIUS_M = 0.3  # bent by 57 degrees from clamp to clamp
At = Callable[[Array], Interpolation]


def given(cells: tuple[int, int], apertures: AperturePattern | None = None) -> PanelPlan:
    return plan(length_m=LENGTH_M, width_m=WIDTH_M, clamp_m=CLAMP_M, cells=cells, apertures=apertures)


def strip(cells: int) -> tuple[Array, At]:
    """The material coordinates of the surface points, and the interpolation."""
    chain = build_chain(given((cells, 1)))
    slopes_1_m = bilinear.row_slopes_1_m(chain.rows_m, chain.clamp_of_row >= 0)

    def at(coordinates_m: Array) -> Interpolation:
        return bilinear.interpolation(chain.rows_m, WIDTH_M, coordinates_m, slopes_1_m)

    return bilinear.points_m(chain.rows_m, WIDTH_M), at


def sheet(cells: int) -> tuple[Array, At]:
    grid = ElementGrid.of(given((cells, 2)).rectangle, (cells, 2))
    return grid.nodes_m(), grid.interpolation


def solid(cells: int) -> tuple[Array, At]:
    grid = solid_grid(given((cells, 2), AperturePattern("rectangle", 0.03, 0.01, 0.05, 0.02)))
    return grid.nodes_m(), grid.interpolation


MODELS = {"strip": strip, "sheet": sheet, "solid": solid}
every_model = pytest.mark.parametrize("model", MODELS.values(), ids=MODELS)


def on_circle(coordinates_m: Array) -> Array:
    """Places (n, 3) of a panel bent to a circle, straight under its clamps."""
    s, y = coordinates_m[:, :2].T
    angle, beyond = np.clip(s, 0.0, LENGTH_M) / RADIUS_M, s - np.clip(s, 0.0, LENGTH_M)
    along = np.stack([np.cos(angle), np.sin(angle)])
    x, z = RADIUS_M * np.sin(angle), RADIUS_M * (1.0 - np.cos(angle))
    offset_m = coordinates_m[:, 2] if coordinates_m.shape[1] == 3 else 0.0
    x, z = x + beyond * along[0] - offset_m * along[1], z + beyond * along[1] + offset_m * along[0]
    return np.stack([x, y, z], axis=1)


def places_m(model: tuple[Array, At], coordinates_m: Array) -> Array:
    own_m = on_circle(model[0])
    seen = mapped(StillPanel(Motion(own_m, np.zeros_like(own_m))), model[1](coordinates_m))
    return seen.initial().surface.position_m


def turned_by(model: tuple[Array, At], coordinates_m: Array) -> Array:
    """Angles (n,) between the normals of the model and those of the circle."""
    foot_m = coordinates_m * [1.0, 1.0, 0.0]
    model_m = places_m(model, coordinates_m) - places_m(model, foot_m)
    circle_m = on_circle(coordinates_m) - on_circle(foot_m)
    return np.linalg.norm(model_m - circle_m, axis=1) / np.abs(coordinates_m[:, 2])


@every_model
def test_the_normal_of_a_circle_is_met_to_second_order(model: Callable[[int], tuple[Array, At]]) -> None:
    """The error falls by 3.5 or more as the cells are halved (4 is second order) unless it is below 1e-5, as
    in the small cells about a solid's openings; at 24 cells it is below half a degree anywhere."""
    s, y = np.meshgrid(np.linspace(0.0, LENGTH_M, 97), np.linspace(0.0, WIDTH_M, 5))
    coordinates_m = np.column_stack([s.ravel(), y.ravel(), np.full(s.size, 0.003)])
    coarse, fine = (np.sqrt(np.mean(turned_by(model(cells), coordinates_m) ** 2)) for cells in (12, 24))
    assert fine < max(coarse / 3.5, 1e-5)
    assert turned_by(model(24), coordinates_m).max() < np.radians(0.5)


@every_model
def test_the_normal_has_no_jump_between_the_clamps(model: Callable[[int], tuple[Array, At]]) -> None:
    """A picometre to either side of cell borders and middles, 6 mm from the surface."""
    opened = model(12)
    s = np.linspace(0.0, LENGTH_M, 25)[1:-1]
    sides = [np.column_stack([s + h, np.full(23, 0.011), np.full(23, 0.006)]) for h in (-1e-12, 1e-12)]
    before_m, after_m = (places_m(opened, each) for each in sides)
    assert np.abs(after_m - before_m).max() < 1e-10


@every_model
def test_a_clamp_holds_the_normal_as_it_holds_the_panel(model: Callable[[int], tuple[Array, At]]) -> None:
    """The normal on and under clamps is that of the clamp, to rounding, and free points have no part in
    it."""
    own_m, at = opened = model(12)
    ends_m = [-CLAMP_M, -0.007, 0.0, LENGTH_M, LENGTH_M + 0.007, LENGTH_M + CLAMP_M]
    coordinates_m = np.column_stack([ends_m, np.full(6, 0.013), np.full(6, -0.004)])
    assert turned_by(opened, coordinates_m).max() < 1e-12
    free = (own_m[:, 0] > 1e-9) & (own_m[:, 0] < LENGTH_M - 1e-9)
    points = at(coordinates_m)
    for matrix in (points.values, points.along, points.across):
        assert abs(matrix[:, free]).sum() < 1e-12


def test_a_wall_on_a_rigid_panel_goes_with_its_flat_middle() -> None:
    """The panel is flat between clamps of which the second has dropped by a third of the span and turned:
    all points between them stand on one plane's normal."""
    panel = rigid.build(given((1, 1)))
    own_m = panel.initial().surface.position_m.copy()
    own_m[6:, 2] -= 0.1
    own_m[4:6, 2] -= 0.12
    ends_m = own_m[4] - own_m[2]
    normal = np.cross(ends_m, [0.0, 1.0, 0.0]) / np.linalg.norm(ends_m)
    coordinates_m = np.column_stack([np.linspace(0.01, 0.29, 9), np.full(9, 0.02), np.full(9, 0.003)])
    seen = mapped(StillPanel(Motion(own_m, np.zeros_like(own_m))), panel.interpolation(coordinates_m))
    feet = panel.interpolation(coordinates_m[:, :2]).values @ own_m
    direction = (seen.initial().surface.position_m - feet) / 0.003
    assert direction == pytest.approx(np.tile(normal, (9, 1)), abs=1e-12)
