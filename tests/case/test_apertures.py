"""Panels with openings: patterns, triangles, mistakes and what ``flipflow check`` says."""

from __future__ import annotations

import re
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.deck.openings import straight_passing
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.deck.triangle_grid import BadMesh, grid, perforated_grid, quality, surface_grids
from orchestrator.case.solver_plans import mesh_sizes
from orchestrator.cli.overview import overview
from orchestrator.ports.geometry import AperturePattern, Rectangle
from tests.cases import CASE, complaints, kinds, load_case, loaded, only_complaint

FFS0827 = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.0, 0.030, 0.020)
KEYS = (
    "length_m=0.02, width_m=0.003, pitch_along_m=0.025, pitch_across_m=0.006, "
    "margin_along_m=0.03, margin_across_m=0.01"
)
SLOTTED = f"screen.panels.deck.apertures={{{KEYS}}}"
ROOM = "domain_m=[[-1, -1, -1], [2, 1, 1]]"
KEY = "screen.panels.deck.apertures."


def panel(length_m: float = 0.3, width_m: float = 0.8, clamp_m: float = 0.019) -> Rectangle:
    x, y, _ = np.eye(3)
    return Rectangle(np.zeros(3), x, y, length_m, length_m, width_m, clamp_m)


def test_the_pattern_is_centred_and_whole_pitches_fit() -> None:
    assert FFS0827.counts(panel()) == (9, 126)
    assert FFS0827.region_m(panel()) == pytest.approx(np.array([[0.0375, 0.022], [0.2625, 0.778]]))
    centres = FFS0827.centres_m(panel())
    assert centres.mean(axis=0) == pytest.approx([0.15, 0.4])
    assert FFS0827.solid_share == pytest.approx(1 - 60 / 150)
    assert FFS0827.land_m == pytest.approx(0.003)


def test_a_slice_of_whole_pitches_is_perforated_to_its_edges() -> None:
    slice_pattern = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.0, 0.030, 0.0)
    assert slice_pattern.counts(panel(width_m=0.03)) == (9, 5)
    assert slice_pattern.region_m(panel(width_m=0.03))[:, 1] == pytest.approx([0.0, 0.03])


def test_staggered_rows_are_shifted_and_keep_what_fits() -> None:
    pattern = AperturePattern("slot", 0.010, 0.006, 0.015, 0.010, 0.5, 0.0, 0.0)
    centres = pattern.centres_m(panel(0.03, 0.05))
    assert centres[:, 0] == pytest.approx([0.0075] * 5 + [0.0225] * 4)
    assert centres[5:, 1] == pytest.approx([0.01, 0.02, 0.03, 0.04])


@pytest.mark.parametrize(
    ("pattern", "largest", "per_opening"),
    [
        (FFS0827, 0.0225, 7),
        (AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.5, 0.03, 0.02), 0.0225, 7),
        (AperturePattern("slot", 0.020, 0.003, 0.025, 0.006, 0.0, 0.03, 0.02), 0.0225, 13),
        (AperturePattern("rectangle", 0.006, 0.006, 0.010, 0.010, 0.0, 0.03, 0.02), 0.0225, 7),
        (AperturePattern("slot", 0.010, 0.010, 0.015, 0.017, 0.5, 0.02, 0.01), 0.0225, 24),
        (AperturePattern("slot", 0.005, 0.030, 0.010, 0.040, 0.3, 0.02, 0.01), 0.0225, 26),
    ],
    ids=["slots", "staggered", "round-ends", "squares", "round", "across"],
)
def test_triangles_cover_the_material_and_nothing_else(
    pattern: AperturePattern, largest: float, per_opening: int
) -> None:
    """Open area within 2 % of the exact one (straight sides: exact), edges no longer than a cell
    or an opening allows, no slivers, normals up, and not many triangles."""
    rectangle = panel()
    grid = perforated_grid(rectangle, pattern, (22, 8))
    count, mesh = len(pattern.centres_m(rectangle)), quality(grid)
    whole_m2 = (rectangle.length_m + 2 * rectangle.clamp_m) * rectangle.width_m
    open_m2 = whole_m2 - mesh.covered_m2
    tolerance = 1e-9 if pattern.shape == "rectangle" else 0.02
    assert open_m2 == pytest.approx(count * pattern.opening_m2, rel=tolerance)
    assert mesh.least_angle_deg > 3.0
    assert mesh.longest_m < 1.6 * largest
    assert len(grid.triangles) < per_opening * count + 500
    inside = grid.coordinates_m[grid.triangles].mean(axis=1)
    half = np.array([pattern.length_m, pattern.width_m]) / 2
    for centre in pattern.centres_m(rectangle)[::97]:
        apart = np.abs(inside - centre) / half
        assert (np.hypot(*apart.T) > 0.9).all()  # no triangle in an opening


def test_every_edge_but_rims_and_borders_has_two_triangles() -> None:
    """No gap, no crack, no overlap: Euler's formula with one hole per opening."""
    grid = perforated_grid(panel(), FFS0827, (22, 8))
    edges = np.sort(grid.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, count = np.unique(edges, axis=0, return_counts=True)
    assert set(count) == {1, 2}
    points = len(np.unique(grid.triangles))
    assert points - len(unique) + len(grid.triangles) == 1 - len(FFS0827.centres_m(panel()))


def test_the_centre_line_is_that_of_a_panel_without_openings() -> None:
    """The line goes from clamp to clamp, so that the deck's length does not depend on the openings."""
    with_openings, without = perforated_grid(panel(), FFS0827, (22, 8)), grid(panel(), (22, 8))
    lines_m = (mesh.coordinates_m[mesh.centre_line] for mesh in (with_openings, without))
    np.testing.assert_allclose(*lines_m, rtol=0, atol=1e-12)


def test_the_same_twice_to_the_last_bit() -> None:
    first, second = (perforated_grid(panel(), FFS0827, (22, 8)) for _ in range(2))
    assert (first.coordinates_m == second.coordinates_m).all()
    assert (first.triangles == second.triangles).all()


def test_panels_that_are_meshed_at_the_same_time_get_their_own_triangles() -> None:
    """The cases of a study are checked side by side."""
    widths_m = [0.03, 0.06] * 4

    def mesh(width_m: float) -> int:
        return len(perforated_grid(panel(width_m=width_m), FFS0827, (22, 2)).triangles)

    with ThreadPoolExecutor(len(widths_m)) as pool:
        assert list(pool.map(mesh, widths_m)) == [mesh(width_m) for width_m in widths_m]


def test_few_triangles_for_the_ffs0827_panel_and_its_slice() -> None:
    """The numbers of triangles are those of docs/measured/perforated_panel.md."""
    assert len(perforated_grid(panel(), FFS0827, (22, 8)).triangles) < 8000
    thin = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.0, 0.030, 0.0)
    assert len(perforated_grid(panel(width_m=0.03), thin, (22, 2)).triangles) < 350


def test_slivers_are_refused() -> None:
    """Lands of 0.2 mm along openings that long facets divide."""
    thin = AperturePattern("rectangle", 0.020, 0.0058, 0.025, 0.006, 0.0, 0.03, 0.02)
    with pytest.raises(BadMesh, match=r"\b0\.\d+\b"):
        perforated_grid(panel(), thin, (8, 8))


@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        ("pitch_across_m=0.003", "screen.panels.deck.apertures.pitch_across_m: out-of-range"),
        ("pitch_along_m=0.015", "screen.panels.deck.apertures.pitch_along_m: out-of-range"),
        ("pitch_across_m=0.00301", "screen.panels.deck.apertures.pitch_across_m: out-of-range"),
        ("margin_along_m=0.15", "screen.panels.deck.apertures.margin_along_m: out-of-range"),
        ("margin_across_m=0.099", "screen.panels.deck.apertures.margin_across_m: out-of-range"),
        ("pitch_across_m=0.25", "screen.panels.deck.apertures.pitch_across_m: out-of-range"),
        ("length_m=-0.02", "screen.panels.deck.apertures.length_m: out-of-range"),
        ("margin_along_m=-0.1", "screen.panels.deck.apertures.margin_along_m: out-of-range"),
        ("stagger=1", "screen.panels.deck.apertures.stagger: out-of-range"),
        ("shape=hexagon", "screen.panels.deck.apertures.shape: unknown-name"),
    ],
)
def test_patterns_that_cannot_be(tmp_path: Path, change: str, wanted: str) -> None:
    assert kinds(tmp_path, SLOTTED, KEY + change) == [wanted]


def test_an_opening_in_millimetres(tmp_path: Path) -> None:
    """The range of an opening's width is not that of a panel's."""
    assert f"{KEY}width_m: out-of-range" in kinds(tmp_path, SLOTTED, f"{KEY}width_m=3")


def test_no_plate(tmp_path: Path) -> None:
    fine = f"{KEY}pitch_along_m=0.002"
    sizes = [f"{KEY}length_m=0.001", f"{KEY}width_m=0.001", f"{KEY}pitch_across_m=0.002"]
    thick = only_complaint(tmp_path, SLOTTED, fine, *sizes, "screen.panels.deck.thickness_m=0.02")
    assert "0.02 m thick, its openings are only 0.002 m apart: no plate" in thick
    assert complaints(tmp_path, SLOTTED) == []


@pytest.mark.solver
def test_round_ends_on_the_solid(tmp_path: Path) -> None:
    solid = "panel.solver=solid"
    complaint = only_complaint(tmp_path, SLOTTED, f"{KEY}shape=slot", solid)
    assert "apertures.shape: slot: the solid's cells are boxes" in complaint
    assert complaints(tmp_path, SLOTTED, f"{KEY}shape=rectangle", solid) == []


def test_a_slice_takes_whole_pitches_from_side_to_side(tmp_path: Path) -> None:
    sliced = ["particles.solver=liggghts", SLOTTED]
    case = loaded(tmp_path, [*sliced, "slice.width_m=0.09"]).case
    pattern, rectangle = single_panels(case)[0].apertures, single_panels(case)[0].rectangle
    assert pattern is not None
    assert pattern.counts(rectangle) == (9, 15)
    assert pattern.region_m(rectangle)[:, 1] == pytest.approx([0.0, 0.09])
    complaint = only_complaint(tmp_path, *sliced, "slice.width_m=0.1")
    assert "0.1 m is 16.6667 pitches of the openings of panel deck" in complaint
    assert "take a whole number of at most 30: 0.102 m is 17" in complaint
    assert "0.18 m is 30" in only_complaint(tmp_path, *sliced, "slice.width_m=0.198")


def test_equal_panels_share_their_triangles_and_their_mistakes(tmp_path: Path) -> None:
    row = ["screen.panels.deck.count=2", "screen.panels.deck.pitch_m=0.35", ROOM]
    row += ["probes.middle.panel=deck-1"]
    grids = surface_grids(loaded(tmp_path, [SLOTTED, *row]).case)
    assert grids["deck-1"] is grids["deck-2"]
    assert kinds(tmp_path, SLOTTED, *row, f"{KEY}pitch_across_m=0.003") == [
        "screen.panels.deck.apertures.pitch_across_m: out-of-range"
    ]


def test_openings_are_resolved_for_particles_only(tmp_path: Path) -> None:
    """The plan has the openings whatever the surface is made of: stiffness and mass are the panel's."""
    start, _, rest = CASE.partition("[bed.particles.ball]")
    empty = start + rest[rest.index("[probes.middle]") :]
    case = load_case(tmp_path, empty, [SLOTTED, "panel.surface_cells=[6, 4]"]).case
    assert len(surface_grids(case)["deck"].triangles) == 2 * (6 + 2) * 4
    assert single_panels(case)[0].apertures is not None


def test_check_tells_what_openings_cost_and_let_through(tmp_path: Path) -> None:
    lines = list(overview(loaded(tmp_path, [SLOTTED])))
    openings = [line for line in lines if "mm" in line and "frame" not in line]
    assert re.findall(r"[\d.]+", openings[0])[:7] == ["270", "20", "3", "9", "5", "3", "40.0"]
    assert re.findall(r"[\d.]+", openings[1])[:2] == ["20", "20"]
    triangles = len(surface_grids(loaded(tmp_path, [SLOTTED]).case)["deck"].triangles)
    assert any(str(triangles) in line.split() for line in lines)
    small = [SLOTTED, "bed.particles.ball.sieve_size_m=0.001"]
    assert any(re.search(r"\b0\.25\b", line) for line in overview(loaded(tmp_path, small)))


def test_the_solid_says_how_large_it_is_and_refuses_what_no_machine_carries(tmp_path: Path) -> None:
    """Cells of 0.3 mm would."""
    solid = [SLOTTED, "panel.solver=solid", "panel.integrator=implicit"]
    size = mesh_sizes(loaded(tmp_path, solid).case)["deck"]
    lines = list(overview(loaded(tmp_path, solid)))
    expected = f"{size.cells} cells, {3 * size.nodes} unknowns and some {size.memory_GiB:.2g} GiB"
    assert any(expected in line for line in lines)
    fine = only_complaint(tmp_path, *solid, "panel.cells=[1000, 600]")
    assert "panel.solver: 443599 cells" in fine
    assert "at most 64 GiB are allowed" in fine
    assert "mm wide would fit: take a slice" in fine


def test_straight_passing() -> None:
    """Gaudin's (a - d)(b - d) over the cell; for round holes the smaller circle's area."""
    assert straight_passing(FFS0827, 0.001) == pytest.approx(19 * 2 / 150)
    assert straight_passing(FFS0827, 0.003) == 0.0
    hole = AperturePattern("slot", 0.01, 0.01, 0.02, 0.02)
    assert straight_passing(hole, 0.004) == pytest.approx(np.pi * 3e-3**2 / 4e-4)
