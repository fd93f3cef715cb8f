"""The views of a machine: labels apart, the right senses and sizes, pages that open without a network."""

from __future__ import annotations

import itertools
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np
import pytest
from matplotlib import pyplot
from matplotlib.collections import EllipseCollection
from matplotlib.text import Text
from PIL import Image
from typer.testing import CliRunner

from orchestrator.case.deck.openings import smaller_sides_m
from orchestrator.cli.main import app
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scene.frame_modes import frame_modes
from orchestrator.preflight.scene.scene import scene
from orchestrator.views.drawings import (
    FRONT,
    SIDE,
    TOP,
    View,
    clipped_middle,
    convex_hull,
    draw_view,
    stiffness_text,
)
from orchestrator.views.modes import modes_svg
from orchestrator.views.openings import draw_openings, sizes_m
from orchestrator.views.outline import MOST_DRAWN, MachineOutline, face_edges_m, outline, simplified
from orchestrator.views.page import Views
from tests.cases import CASE, case_folder

CASES = Path(__file__).parents[2] / "cases"
SVG = "{http://www.w3.org/2000/svg}"


def machine(name: str) -> MachineOutline:
    judged = load_judged(CASES / name)
    return outline(judged.case.whole_machine, judged.folder)


def drawn(name: str) -> list[str]:
    """The labels of a case's side view."""
    figure = draw_view(machine(name), SIDE)
    words = [text.get_text() for text in figure.axes[0].texts]
    pyplot.close(figure)
    return words


@pytest.mark.parametrize(
    ("sets", "text"),
    [
        ([], "12 kg/s of coal (this level feeds 1.5)"),
        (["bed.feeds.coal.rate_kg_per_s=2.0"], "2 kg/s of coal"),
    ],
)
def test_the_feed_of_the_whole_machine_is_drawn_and_not_that_of_its_level(sets: list[str], text: str) -> None:
    """The level draft feeds an eighth; a value of --set is the machine's."""
    (feed,) = Views(load_judged(CASES / "ffs0827-slice", "draft", sets)).machine.feeds
    assert feed.text == text


@pytest.mark.parametrize("view", [SIDE, TOP], ids=lambda view: view.name)
@pytest.mark.parametrize("name", ["quickstart", "ffs0827-slice", "banana"])
def test_no_label_covers_another(name: str, view: View) -> None:
    figure = draw_view(machine(name), view)
    (axes,) = figure.axes
    figure.canvas.draw()  # The extent of an annotation has its arrow, too; that of its text does not.
    boxes = {text.get_text(): Text.get_window_extent(text) for text in axes.texts if text.get_text()}
    assert {"shaft", "centre of mass"} <= {
        word for word in ("shaft", "centre of mass") if word in " ".join(boxes)
    }
    assert len(boxes) > 8
    covered = [(a, b) for a, b in itertools.combinations(boxes, 2) if boxes[a].overlaps(boxes[b])]
    assert covered == []
    frame = figure.bbox
    assert all(frame.containsx(box.x0) and frame.containsx(box.x1) for box in boxes.values())
    pyplot.close(figure)


def test_a_bed_that_is_taken_over_is_drawn_to_scale(tmp_path: Path) -> None:
    """A circle of its own diameter stands at each particle's place, seen from the side."""
    rows = ["x_m,y_m,z_m,sieve_size_m,material", "0.1,0.1,0.02,0.02,coal", "0.2,0.1,0.01,0.01,coal"]
    folder = case_folder(tmp_path, CASE)
    (folder / "grains.csv").write_text("\n".join(rows))
    judged = load_judged(folder, None, ["bed.table=grains.csv"])
    figure = draw_view(outline(judged.case.whole_machine, folder), SIDE)
    (axes,) = figure.axes
    (bed,) = (part for part in axes.collections if isinstance(part, EllipseCollection))
    assert bed.get_offsets().ravel().tolist() == pytest.approx([0.1, 0.02, 0.2, 0.01])
    assert any("2 particles taken over" in text.get_text() for text in axes.texts)
    pyplot.close(figure)


def test_driven_frames_with_one_arrow_have_one_label(tmp_path: Path) -> None:
    """Cranks move both frames of this machine along the deck, against each other."""
    driven = (
        "[screen.frames.{}.drive]\namplitude_m = [{}, 0.0, 0.0]\nspeed_rad_per_s = 62.832\nrun_up_s = 0.05\n"
    )
    head, _, rest = CASE.partition("[screen.frames.driving]")
    rest = rest[rest.index("[screen.panels.deck]") : rest.index("[bed.particles.ball]")]
    rest = rest.replace('"ground"]', '"driven"]').replace("corner_m = [0.0,", "corner_m = [0.1,")

    def labels(one_m: float, other_m: float) -> list[str]:
        frames = (f"[screen.frames.{name}]\n" for name in ("driving", "driven"))
        drives = (driven.format(*row) for row in (("driving", one_m), ("driven", other_m)))
        text = head + "".join(f + d for f, d in zip(frames, drives, strict=True)) + rest
        points = '[screen.panels.other]\nmaterial = "PU"\nframes = ["driven", "driving"]\n'
        points += "corner_m = [0.1, 0.3, 0.0]\nlength_m = 0.3\nwidth_m = 0.2\nthickness_m = 0.004\n"
        judged = load_judged(case_folder(tmp_path, text + points + "clamp_m = 0.019\ntension_m = 0.002\n"))
        figure = draw_view(outline(judged.case.whole_machine, tmp_path), SIDE)
        words = [text.get_text() for text in figure.axes[0].texts if "driven" in text.get_text()]
        pyplot.close(figure)
        return words

    assert labels(0.003, 0.003) == ["driving and driven, both driven\n3 / 0 / 0 mm at 10 Hz"]
    (label,) = labels(0.003, 0.004)
    assert label.splitlines()[1:] == ["driving: 3 / 0 / 0 mm at 10 Hz", "driven: 4 / 0 / 0 mm at 10 Hz"]


def test_driven_frames_apart_have_a_label_each() -> None:
    words = [text for text in drawn("crank-link-panel") if ", driven" in text]
    assert [text.splitlines()[0] for text in words] == ["outer, driven", "inner, driven"]


def test_stiff_bushings_are_labelled_in_meganewtons() -> None:
    assert stiffness_text((14.3e6, 239e3, 0.0)) == "14.3 / 0.239 / 0 MN/m"
    assert stiffness_text((9.99e6, 239e3, 20.0)) == "9990 / 239 / 0.02 kN/m"
    assert stiffness_text((9.99999e6,)) == "10 MN/m"
    assert not [text for text in drawn("double-deck") if "e+" in text]


def test_a_shaft_along_y_turns_clockwise_from_the_side() -> None:
    """The view from the side has x to the right and z up, so that y points away from the reader."""
    assert SIDE.toward == pytest.approx([0, -1, 0])
    assert TOP.toward == pytest.approx([0, 0, 1])
    assert FRONT.toward == pytest.approx([1, 0, 0])
    quarter_turn_about_y = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])
    top = np.array([0.0, 0.0, 1.0])
    assert SIDE.of(quarter_turn_about_y @ top) == pytest.approx([1, 0])  # from the top to the right


def test_faces_of_a_cube_have_twelve_edges() -> None:
    import pyvista

    cube = pyvista.Cube().triangulate().clean()
    edges_m = face_edges_m(np.asarray(cube.points), cube.faces.reshape(-1, 4)[:, 1:])
    assert edges_m.shape == (12, 2, 3)
    assert np.linalg.norm(np.diff(edges_m, axis=1)[:, 0], axis=1) == pytest.approx(np.ones(12))


def test_polygons_are_clipped_and_points_on_a_line_have_two_ends() -> None:
    square = np.array([[0.0, 0], [4, 0], [4, 4], [0, 4]])
    middle = clipped_middle(square, np.array([2.0, 2.0]), np.array([10.0, 10.0]))
    assert middle == pytest.approx([3, 3])
    assert clipped_middle(square, np.array([5.0, 5.0]), np.array([6.0, 6.0])) is None
    assert convex_hull(np.array([[0.0, 0], [1, 1], [3, 3]])) == pytest.approx(
        np.array([[3, 3], [0, 0]])[::-1]
    )


def test_each_size_passes_or_stays_as_the_openings_say() -> None:
    case = load_judged(CASES / "ffs0827-slice").case
    ((_, figure),) = draw_openings(case)
    words = [text.get_text() for text in figure.axes[0].texts]
    limit_m = min(smaller_sides_m(case))
    for size_m in sizes_m(case):
        assert f"{1e3 * size_m:.3g} mm, {'passes' if size_m < limit_m else 'stays'}" in words
    pyplot.close(figure)


def test_modes_move_the_panels_between_the_frames() -> None:
    judged = load_judged(CASES / "quickstart")
    shaken = scene(judged.case)
    modes = frame_modes(shaken)
    drawn = ElementTree.fromstring(modes_svg(machine("quickstart"), modes, [12.5]))
    assert len(modes) == 12
    animated = drawn.findall(f".//{SVG}animate")
    assert len(animated) == 12 * (2 + 2)  # two frames and two panels
    for element in animated:
        places = [row.split() for row in element.get("values", "").split(";")]
        assert places[0] == places[-1]  # a period ends where it began
    assert any(len(set(element.get("values", "").split(";"))) > 12 for element in animated)
    near = modes_svg(machine("quickstart"), modes, [modes[6].frequency_Hz])
    assert near.count("#c1443c") > modes_svg(machine("quickstart"), modes, [1e3]).count("#c1443c") == 0


DRAWINGS = tuple(
    f"{name}.{kind}" for name in ("side", "top", "mats-deck-1", "mats-deck-2") for kind in ("png", "svg")
)
WRITTEN = (*DRAWINGS, "modes.svg", "model.html", "machine.html")
WITHOUT_SOLVERS = """
import sys
from orchestrator.cli.main import app
if __name__ == "__main__":
    try:
        app(sys.argv[1:])
    finally:
        print("loaded:", *{"exudyn", "dolfinx", "petsc4py", "mpi4py"}.intersection(sys.modules))
"""


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder of ``flipflow show`` for the quickstart, and what the command said."""
    place = tmp_path_factory.mktemp("show")
    program = place / "program.py"
    program.write_text(WITHOUT_SOLVERS)
    words = ["show", str(CASES / "quickstart"), "--out", str(place / "out")]
    done = subprocess.run([sys.executable, program, *words], capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return place / "out", done.stdout


@pytest.mark.process
def test_show_names_its_files_and_opens_no_solver_of_others(shown: tuple[Path, str]) -> None:
    folder, output = shown
    spheres, *others = output.splitlines()
    assert spheres.startswith("warning: lone spheres")
    assert others == [*(f"written: {folder / name}" for name in WRITTEN), "loaded:"]
    assert sorted(WRITTEN) == sorted(file.name for file in folder.iterdir())
    for file in folder.glob("*.svg"):
        ElementTree.parse(file)


@pytest.mark.process
def test_pages_open_without_a_network(shown: tuple[Path, str], tmp_path: Path) -> None:
    folder, _ = shown
    for name in ("model.html", "machine.html"):
        page = (folder / name).read_text()
        assert not re.search(r"<(script|link|img|iframe)[^>]+(src|href)=.?https?:", page)
    picture = tmp_path / "model.png"
    browser = [
        "chromium-headless-shell",
        "--no-sandbox",
        "--use-angle=swiftshader",
        "--enable-unsafe-swiftshader",
    ]
    asked = ["--virtual-time-budget=5000", f"--screenshot={picture}", "--window-size=500,350"]
    subprocess.run([*browser, *asked, (folder / "model.html").as_uri()], capture_output=True, timeout=120)
    colors = Image.open(picture).convert("RGB").getcolors(1 << 20)
    assert colors is not None
    panel = sum(count for count, (red, green, blue) in colors if red > green + 20 > blue + 60)
    assert panel > 1000  # pixels of the panels' yellow: WebGL has drawn the machine


def test_check_writes_a_page_with_its_warnings(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    done = CliRunner().invoke(app, ["check", str(case_folder(tmp_path, CASE)), "--html", str(page)])
    assert done.exit_code == 0, done.output
    text = page.read_text()
    assert "has no run-up" in text
    assert "cost" in text
    assert "<svg" in text
    assert "warning: " not in text


def test_a_case_with_problems_is_shown_and_the_problems_named(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, CASE)
    outside = "screen.panels.deck.corner_m=[0.8, 0, 0]"
    words = ["show", str(folder), "--out", str(tmp_path / "out"), "--set"]
    done = CliRunner().invoke(app, [*words, outside])
    assert done.exit_code == 0, done.output
    assert "problem: --set screen.panels.deck.corner_m: panel deck: reaches 0.121 m out" in done.output
    assert "The case cannot be run." in (tmp_path / "out" / "machine.html").read_text()
    done = CliRunner().invoke(
        app, ["show", str(folder), "--out", str(tmp_path / "not"), "--set", "duration_s=-1"]
    )
    assert done.exit_code == 2
    assert not (tmp_path / "not").exists()


def test_a_surface_of_very_many_triangles_is_drawn_with_few() -> None:
    """A plate with a fold, in 20 000 triangles: the same area, bounds and edges, to the rounding of single
    precision.  A surface of few triangles stays as it is."""
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 101), np.linspace(0.0, 1.0, 101), indexing="ij")
    at_m = np.stack([x, y, np.abs(x - 0.5)], axis=-1).reshape(-1, 3)
    a = np.arange(101 * 101).reshape(101, 101)
    corners = [(a[:-1, :-1], a[1:, :-1], a[1:, 1:]), (a[:-1, :-1], a[1:, 1:], a[:-1, 1:])]
    triangles = np.concatenate([np.stack(t, axis=-1).reshape(-1, 3) for t in corners])
    coarse_m, few = simplified(at_m, triangles)
    assert len(few) <= MOST_DRAWN
    sides_m = [
        points_m[t][:, 1:] - points_m[t][:, :1] for points_m, t in ((at_m, triangles), (coarse_m, few))
    ]
    area_m2, coarse_m2 = (np.linalg.norm(np.cross(s[:, 0], s[:, 1]), axis=1).sum() / 2 for s in sides_m)
    assert coarse_m2 == pytest.approx(area_m2, rel=1e-6)
    assert np.array([coarse_m.min(axis=0), coarse_m.max(axis=0)]) == pytest.approx(
        np.array([at_m.min(axis=0), at_m.max(axis=0)]), abs=1e-6
    )
    edges_m = face_edges_m(coarse_m, few)
    assert np.linalg.norm(edges_m[:, 1] - edges_m[:, 0], axis=1).sum() == pytest.approx(
        3 + 2 * 2**0.5, rel=1e-5
    )
    assert simplified(coarse_m, few)[1] is few
