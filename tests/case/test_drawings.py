"""Openings from DXF files: what is read, where it is, what is refused, and the pattern that it is."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.case.deck.openings import straight_passing
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.deck.triangle_grid import perforated_grid, quality
from orchestrator.output.records.run_folder import create_run_folder
from orchestrator.ports import Array
from orchestrator.ports.drawn_openings import DrawnOpenings, area_m2, as_outline
from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, case_folder, complaints, kinds, loaded
from tests.drawn import draw_pattern, new_drawing, write_drawing

CLAMP_M, LENGTH_M, WIDTH_M = 0.019, 0.3, 0.2  # those of the panel of ``tests.cases.CASE``
SHEET_MM = (1e3 * (LENGTH_M + 2 * CLAMP_M), 1e3 * WIDTH_M)
KEY = "screen.panels.deck.apertures"
FILE = f"{KEY}.file=panel.dxf"
SLOTS = AperturePattern("rectangle", 0.020, 0.003, 0.025, 0.006, 0.0, 0.030, 0.020)
PATTERNS = [
    SLOTS,
    replace(SLOTS, stagger=0.5),
    replace(SLOTS, stagger=0.3),
    AperturePattern("slot", 0.010, 0.010, 0.015, 0.017, 0.5, 0.02, 0.01),
    AperturePattern("slot", 0.005, 0.030, 0.010, 0.040, 0.3, 0.02, 0.01),
]
patterns = pytest.mark.parametrize(
    "pattern", PATTERNS, ids=["slots", "staggered", "shifted", "round", "across"]
)


def panel() -> Rectangle:
    x, y, _ = np.eye(3)
    return Rectangle(np.zeros(3), x, y, LENGTH_M, LENGTH_M, WIDTH_M, CLAMP_M)


def rectangle(x: float, y: float, length: float = 20.0, width: float = 3.0) -> Array:
    """The corners of an opening, in mm, from its lowest one."""
    return np.array([[x, y], [x + length, y], [x + length, y + width], [x, y + width]])


def of_file(folder: Path, *overrides: str) -> AperturePattern:
    """The openings of the test case with the drawing in its folder."""
    apertures = single_panels(loaded(folder, (FILE, *overrides)).case)[0].apertures
    assert apertures is not None
    assert apertures.drawn is not None
    return apertures


def outlines(apertures: AperturePattern) -> DrawnOpenings:
    assert apertures.drawn is not None
    return apertures.drawn


@patterns
def test_a_drawn_pattern_is_the_one_that_keys_give(tmp_path: Path, pattern: AperturePattern) -> None:
    """Places, region, cell and shares to rounding; what passes to 1e-4, by the table of sizes.

    Outlines of slots are the polygons that stand for them, with up to 2 % less area."""
    draw_pattern(tmp_path / "panel.dxf", pattern, panel())
    drawn = of_file(tmp_path)
    kept = area_m2(pattern.outline_m()) / pattern.opening_m2
    np.testing.assert_allclose(drawn.centres_m(panel()), pattern.centres_m(panel()), rtol=0, atol=1e-12)
    np.testing.assert_allclose(drawn.region_m(panel()), pattern.region_m(panel()), rtol=0, atol=1e-9)
    assert drawn.opening_m2 == pytest.approx(kept * pattern.opening_m2, rel=1e-9)
    assert 1 - drawn.solid_share == pytest.approx(kept * (1 - pattern.solid_share), rel=1e-9)
    assert (drawn.length_m, drawn.width_m) == pytest.approx((pattern.length_m, pattern.width_m), rel=0.02)
    assert drawn.pitch_along_m == pytest.approx(pattern.pitch_along_m, rel=1e-9)
    assert drawn.pitch_across_m == pytest.approx(pattern.pitch_across_m, rel=1e-9)
    exact = pattern.shape == "rectangle"
    assert drawn.spheres_m == pytest.approx(pattern.spheres_m, rel=1e-6 if exact else 0.02)
    off = (1e-4 if exact else 0.02) * (1 - pattern.solid_share)
    for share in (0.0, 0.2, 0.5, 0.8, 1.0):
        size_m = share * pattern.spheres_m[0]
        assert straight_passing(drawn, size_m) == pytest.approx(straight_passing(pattern, size_m), abs=off)


def test_slots_have_the_triangles_of_the_pattern_to_the_last_bit() -> None:
    """Where no side of an opening is divided, so that both add up the same numbers."""
    at = replace(panel(), clamp_m=0.0)
    corners_m = tuple(as_outline(outline) for outline in SLOTS.outlines_m(at))
    drawn = replace(SLOTS, shape="polygon", drawn=DrawnOpenings(corners_m, (LENGTH_M, WIDTH_M)))
    by_keys, by_file = (perforated_grid(at, pattern, (10, 7)) for pattern in (SLOTS, drawn))
    assert (by_file.coordinates_m == by_keys.coordinates_m).all()
    assert (by_file.triangles == by_keys.triangles).all()


def test_walls_of_drawn_openings_are_those_of_the_pattern(tmp_path: Path) -> None:
    """Deep rims with a relief: the lower side within 1e-12 m."""
    deep = replace(SLOTS, depth_m=0.004, relief_deg=4.0)
    draw_pattern(tmp_path / "panel.dxf", SLOTS, panel())
    drawn = of_file(tmp_path, f"{KEY}.rims=deep", f"{KEY}.relief_deg=4.0")
    assert drawn.depth_m == 0.004
    by_keys, by_file = (perforated_grid(panel(), pattern, (15, 10)) for pattern in (deep, drawn))
    assert len(by_file.triangles) == len(by_keys.triangles)
    ordered = [
        grid.coordinates_m[np.lexsort(np.round(grid.coordinates_m, 9).T)] for grid in (by_keys, by_file)
    ]
    np.testing.assert_allclose(*ordered, rtol=0, atol=1e-12)


def test_sides_move_outwards_by_the_distance() -> None:
    """A hexagon of side 1 grown by 0.1 has the side 1 + 0.2 / sqrt(3)."""
    turn = np.arange(6) * np.pi / 3
    hexagon = DrawnOpenings((as_outline(np.column_stack([np.cos(turn), np.sin(turn)])),), (9.0, 9.0))
    (corners,) = hexagon.grown(0.1).corners_m
    assert np.linalg.norm(corners, axis=1) == pytest.approx(1 + 0.2 / 3**0.5)


def add_slot(space: Any) -> float:
    space.add_lwpolyline(
        [(50, 50, 0), (60, 50, 1), (60, 54, 0), (50, 54, 1)], format="xyb", close=True
    )  # a bulge of 1 is half a circle
    return 40 + np.pi * 4


def add_circle(space: Any) -> float:
    space.add_circle((60, 60), 5)
    return np.pi * 25


def add_ellipse(space: Any) -> float:
    space.add_ellipse((60, 60), (8, 0), 0.5)
    return np.pi * 32


def add_spline(space: Any) -> float:
    """A closed spline through eight points of a circle of radius 5 is near to it."""
    turn = np.linspace(0, 2 * np.pi, 9)
    space.add_spline([(60 + 5 * np.cos(t), 60 + 5 * np.sin(t), 0) for t in turn])
    return np.pi * 25


def add_old_polyline(space: Any) -> float:
    space.add_polyline2d([*map(tuple, rectangle(50, 50))], close=True)
    return 60


def add_chain(space: Any) -> float:
    """A slot of two lines and two arcs, out of order, one line the other way round."""
    space.add_line((60, 54), (50, 54))
    space.add_arc((50, 52), 2, 90, 270)
    space.add_line((60, 50), (50, 50))
    space.add_arc((60, 52), 2, 270, 90)
    return 40 + np.pi * 4


def add_block(space: Any) -> float:
    """Two rows of three copies of a block, twice as large and turned."""
    block = space.doc.blocks.new("OPENING")
    block.add_lwpolyline([*map(tuple, rectangle(-2, -1, 4, 2))], close=True)
    space.add_blockref(
        "OPENING",
        (60, 60),
        dxfattribs={"xscale": 2, "yscale": 2, "rotation": 90, "row_count": 2, "column_count": 3}
        | {"row_spacing": 20, "column_spacing": 20},
    )
    return 6 * 32


@pytest.mark.parametrize(
    "add", [add_slot, add_circle, add_ellipse, add_spline, add_old_polyline, add_chain, add_block]
)
def test_each_kind_of_curve_keeps_its_area(tmp_path: Path, add: Callable[[Any], float]) -> None:
    """At least 98 % of it, in polygons with corners on the curve; the spline is no circle, by 1 %."""
    drawing = new_drawing()
    wanted_mm2 = add(drawing.modelspace())
    drawing.saveas(tmp_path / "panel.dxf")
    area_mm2 = 1e6 * outlines(of_file(tmp_path)).areas_m2.sum()
    assert 0.97 * wanted_mm2 < area_mm2 <= (1.01 if add is add_spline else 1 + 1e-9) * wanted_mm2


@pytest.mark.parametrize(
    ("unit", "key", "metres"),
    [(4, "", 1e-3), (5, "", 1e-2), (6, "", 1.0), (1, "", 0.0254), (0, "mm", 1e-3), (6, "mm", 1e-3)],
)
def test_units_are_the_files_or_the_cases(tmp_path: Path, unit: int, key: str, metres: float) -> None:
    write_drawing(tmp_path / "panel.dxf", [0.05 / metres * rectangle(1, 1, 0.4, 0.1)], unit=unit)
    drawn = of_file(tmp_path, *([f"{KEY}.unit={key}"] if key else []))
    assert (drawn.length_m, drawn.width_m) == pytest.approx((0.02, 0.005))


def test_the_outline_of_the_panel_gives_sizes_and_places(tmp_path: Path) -> None:
    """Its lowest corner is that of the sheet, clamped strips included, wherever the drawing has it."""
    moved = np.array([1000.0, -500.0])
    drawing = new_drawing()
    space = drawing.modelspace()
    space.add_lwpolyline([*map(tuple, rectangle(0, 0, *SHEET_MM) + moved)], close=True)
    space.add_lwpolyline([*map(tuple, rectangle(100, 40) + moved)], close=True)
    drawing.saveas(tmp_path / "panel.dxf")
    assert outlines(of_file(tmp_path)).boxes_m[0, 0] == pytest.approx([0.1 - CLAMP_M, 0.04])
    bare = CASE.replace("length_m = 0.3\nwidth_m = 0.2\n", "")
    assert bare != CASE
    row = load_judged(case_folder(tmp_path, bare), None, [FILE]).case.screen.panels["deck"]
    assert (row.length_m, row.width_m) == pytest.approx((LENGTH_M, WIDTH_M))


def test_a_turned_drawing_is_turned_back(tmp_path: Path) -> None:
    write_drawing(tmp_path / "panel.dxf", [rectangle(40, 100, 3, 20)], SHEET_MM[::-1])
    drawn = of_file(tmp_path, f"{KEY}.rotation_deg=90")
    assert (drawn.length_m, drawn.width_m) == pytest.approx((0.020, 0.003))
    lowest_m = [1e-3 * SHEET_MM[0] - 0.120 - CLAMP_M, 0.040]
    assert outlines(drawn).boxes_m[0, 0] == pytest.approx(lowest_m)


def test_holes_under_the_clamps_are_no_openings(tmp_path: Path) -> None:
    """Bolts go through them."""
    holes = [rectangle(x, 90, 8, 8) for x in (5, SHEET_MM[0] - 13)]
    write_drawing(tmp_path / "panel.dxf", [*holes, rectangle(100, 40)], SHEET_MM)
    assert len(outlines(of_file(tmp_path))) == 1


def test_layers_are_named_where_there_are_several(tmp_path: Path) -> None:
    drawing = new_drawing()
    space = drawing.modelspace()
    space.add_lwpolyline([*map(tuple, rectangle(100, 40))], close=True, dxfattribs={"layer": "CUT"})
    space.add_line((0, 0), (10, 0), dxfattribs={"layer": "Frame"})
    space.add_text("a note", dxfattribs={"layer": "Notes"})
    drawing.saveas(tmp_path / "panel.dxf")
    assert kinds(tmp_path, FILE) == [f"{KEY}.file: file"]
    assert kinds(tmp_path, FILE, f'{KEY}.layers=["Cut"]') == []
    assert kinds(tmp_path, FILE, f'{KEY}.layers=["CUTS"]') == [f"{KEY}.file: file"]
    assert '"CUT"' in complaints(tmp_path, FILE, f'{KEY}.layers=["CUTS"]')[0]


def bow_tie(space: Any) -> None:
    space.add_lwpolyline([(50, 50), (70, 60), (70, 50), (50, 60)], close=True)


def open_chain(space: Any) -> None:
    space.add_lwpolyline([(50, 50), (70, 50), (70, 60)])


def branching(space: Any) -> None:
    for end in ((70, 50), (60, 60), (50, 70)):
        space.add_line((50, 50), end)


def overlapping(space: Any) -> None:
    for x in (50, 65):
        space.add_lwpolyline([*map(tuple, rectangle(x, 50))], close=True)


def nested(space: Any) -> None:
    for at in (rectangle(50, 50, 20, 20), rectangle(55, 55, 5, 5), rectangle(90, 90)):
        space.add_lwpolyline([*map(tuple, at)], close=True)


def round_panel(space: Any) -> None:
    space.add_circle((100, 100), 90)
    space.add_lwpolyline([*map(tuple, rectangle(95, 95))], close=True)


def high(space: Any) -> None:
    space.add_line((0, 0, 0), (10, 0, 5))


def a_body(space: Any) -> None:
    space.add_lwpolyline([*map(tuple, rectangle(50, 50))], close=True)
    space.add_3dface([(0, 0), (1, 0), (1, 1), (0, 1)])


def nothing(space: Any) -> None:
    space.add_text("a note")


def flat(space: Any) -> None:
    space.add_lwpolyline([(50, 50), (70, 50), (60, 50)], close=True)


REFUSED = [bow_tie, open_chain, branching, overlapping, nested, round_panel, high, a_body, nothing, flat]


@pytest.mark.parametrize("add", REFUSED)
def test_what_is_no_panel_is_refused_in_one_sentence(tmp_path: Path, add: Callable[[Any], None]) -> None:
    drawing = new_drawing()
    add(drawing.modelspace())
    drawing.saveas(tmp_path / "panel.dxf")
    assert kinds(tmp_path, FILE) == [f"{KEY}.file: file"]


def test_units_that_nobody_says_are_refused(tmp_path: Path) -> None:
    write_drawing(tmp_path / "panel.dxf", [rectangle(50, 50)], unit=0)
    assert kinds(tmp_path, FILE) == [f"{KEY}.file: file"]


@pytest.mark.parametrize("content", [b"", b"no drawing", b"0\nSECTION\n2\nENTITIES\n0\nLINE\n"])
def test_damaged_files_are_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "panel.dxf").write_bytes(content)
    assert kinds(tmp_path, FILE) == [f"{KEY}.file: file"]


def test_files_that_are_not_there_are_refused(tmp_path: Path) -> None:
    assert kinds(tmp_path, FILE) == [f"{KEY}.file: file"]
    assert kinds(tmp_path, f"{KEY}.file=../../etc/passwd") == [f"{KEY}.file: file"]


@pytest.mark.parametrize(
    ("at", "sheet"),
    [
        (rectangle(100, 190, 20, 20), None),  # beyond the side
        (rectangle(100, 0), SHEET_MM),  # on the edge
        (rectangle(10, 50), SHEET_MM),  # half in the clamp
        (rectangle(2, 50, 10), SHEET_MM),  # all of them under the clamps
        (rectangle(100, 50), (SHEET_MM[0] + 1, SHEET_MM[1])),  # another panel
        (rectangle(100, 50), SHEET_MM[::-1]),  # turned
    ],
    ids=["beyond", "edge", "half-clamped", "clamped", "longer", "turned"],
)
def test_openings_that_do_not_fit_the_panel_are_refused(
    tmp_path: Path, at: Array, sheet: tuple[float, float] | None
) -> None:
    write_drawing(tmp_path / "panel.dxf", [at], sheet)
    assert kinds(tmp_path, FILE) == [f"{KEY}.file: misplaced"]


def test_a_slice_does_not_cut_a_drawing(tmp_path: Path) -> None:
    write_drawing(tmp_path / "panel.dxf", [rectangle(100, 50)])
    assert kinds(tmp_path, FILE, "slice.width_m=0.1") == ["slice: conflict"]


def test_a_relief_closes_drawn_openings_or_leaves_them_a_land(tmp_path: Path) -> None:
    write_drawing(tmp_path / "panel.dxf", [rectangle(100, y) for y in (50, 56)])
    deep = (FILE, f"{KEY}.rims=deep", f"{KEY}.depth_m=0.02")
    assert kinds(tmp_path, *deep, f"{KEY}.relief_deg=-10.0") == [f"{KEY}.relief_deg: out-of-range"]
    assert kinds(tmp_path, *deep, f"{KEY}.relief_deg=10.0") == [f"{KEY}.relief_deg: out-of-range"]


def test_a_file_and_a_pattern_are_not_given_together(tmp_path: Path) -> None:
    write_drawing(tmp_path / "panel.dxf", [rectangle(100, 50)])
    both = f'{KEY}={{file="panel.dxf", length_m=0.02}}'
    assert kinds(tmp_path, both) == [f"{KEY}.length_m: unknown-key"]


def test_a_later_file_replaces_a_pattern(tmp_path: Path) -> None:
    write_drawing(tmp_path / "panel.dxf", [rectangle(100, 50)])
    pattern = f"{KEY}={{length_m=0.02, width_m=0.003, pitch_along_m=0.025, pitch_across_m=0.006}}"
    assert kinds(tmp_path, pattern, FILE) == []


def test_a_run_has_a_copy_of_the_drawing(tmp_path: Path) -> None:
    write_drawing(tmp_path / "panel.dxf", [rectangle(100, 50)], SHEET_MM)
    judged = loaded(tmp_path, (FILE,))
    folder = create_run_folder(judged, tmp_path / "run", None)
    (tmp_path / "panel.dxf").unlink()
    again = load_judged(folder / "case.toml")
    assert single_panels(again.case)[0].apertures == single_panels(judged.case)[0].apertures


def test_openings_that_do_not_repeat_are_one_mean_cell() -> None:
    """Rectangles at random heights: the region goes half a land beyond them, and is the cell."""
    random = np.random.default_rng(4)
    grid = [(0.02 + 0.03 * i, 0.02 + 0.02 * j) for i in range(8) for j in range(8)]
    places = [(s, y + 0.004 * random.random()) for s, y in grid]
    drawn = DrawnOpenings(tuple(as_outline(rectangle(s, y, 0.02, 0.01)) for s, y in places), (0.3, 0.2))
    assert drawn.repeats_m == (0.0, 0.0)
    low_m, high_m = drawn.region_m
    assert low_m[0] == pytest.approx(0.02 - drawn.land_m / 2)
    assert drawn.period_m == pytest.approx(tuple(high_m - low_m))
    assert 1 - drawn.solid_share == pytest.approx(64 * 2e-4 / np.prod(high_m - low_m))
    assert len(drawn.cell_m) == 64
    assert drawn.spheres_m == pytest.approx((0.01, 0.01), rel=1e-6)


@pytest.mark.slow
def test_a_thousand_polygons_are_read_and_checked_in_seconds(tmp_path: Path) -> None:
    """1000 hexagons of random turn and size: 60 s of one processor are far more than it takes."""
    random = np.random.default_rng(1)
    hexagons = []
    for number in range(1000):
        centre = np.array([25.0 + 7.0 * (number // 25), 10.0 + 7.2 * (number % 25)])
        turn = random.uniform(0, np.pi) + np.arange(6) * np.pi / 3
        hexagons.append(centre + random.uniform(1.5, 2.2) * np.column_stack([np.cos(turn), np.sin(turn)]))
    write_drawing(tmp_path / "panel.dxf", hexagons, SHEET_MM)
    began_s = time.process_time()
    judged = loaded(tmp_path, (FILE,))
    assert find_problems(judged) == []
    assert time.process_time() - began_s < 60.0
    (apertures,) = (row.apertures for row in single_panels(judged.case))
    assert apertures is not None
    grid = perforated_grid(panel(), apertures, (15, 10))
    whole_m2 = (LENGTH_M + 2 * CLAMP_M) * WIDTH_M
    assert whole_m2 - quality(grid).covered_m2 == pytest.approx(outlines(apertures).areas_m2.sum(), rel=1e-6)
