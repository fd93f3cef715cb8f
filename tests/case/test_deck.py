"""Decks: where their panels and surfaces come to lie, and what is refused."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.deck.panels import SinglePanel, axes, single_panels, walls
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import JudgedCase
from tests.cases import CASE, keys_and_kinds, load_case

BEFORE, AFTER = CASE.split("[screen.panels.deck]")
DECK = """
[screen.frames.driven]
mass_kg = 28.0
inertia_kg_m2 = [1.0, 2.0, 2.0]
center_of_mass_m = [0.0, 0.1, 0.0]
[screen.bushings.shear]
between = ["driving", "driven"]
positions_m = [[-0.4, 0.1, 0.0], [0.4, 0.1, 0.0]]
stiffness_N_per_m = [2e4, 3e4, 4e4]
[screen.decks.deck]
material = "PU"
frames = ["driving", "driven"]
corner_m = [0.0, 0.0, 0.5]
panels = 10
pitch_m = 0.27
length_m = 0.24
width_m = 0.2
thickness_m = 0.004
clamp_m = 0.014
slopes_deg = [40.0, 38.6, 23.7, 13.7, 12.0]
[screen.decks.deck.side_plates]
frame = "driving"
material = "PU"
height_m = 0.2
depth_m = 0.05
[screen.decks.deck.cross_beams]
material = "PU"
[screen.decks.deck.feed_chute]
material = "PU"
length_m = 0.3
slope_deg = 45.0
drop_m = 0.1
[bed.particles.ball]
position_m = [0.5, 0.1, 0.6]
sieve_size_m = 0.02
material = "coal"
[probes.middle]
panel = "deck-3"
at = [0.5, 0.5]
"""
ROOM = "domain_m=[[-1, -1, -3], [3, 1, 2]]"
INCLINED = "screen.inclination_deg=17.0"


def deck(folder: Path, *overrides: str) -> JudgedCase:
    return load_case(folder, BEFORE + DECK, [ROOM, INCLINED, *overrides])


def ends_m(panel: SinglePanel) -> tuple[np.ndarray, np.ndarray]:
    """The outer edges of both clamps at y = 0, in the world."""
    r = panel.rectangle
    corners = np.array([[-r.clamp_m, 0.0], [r.length_m + r.clamp_m, 0.0]])
    first, second = r.mounted(corners)
    return first, second


def test_slopes_are_those_of_the_segments(tmp_path: Path) -> None:
    """The slopes are measured against the horizontal, whatever the inclination of the axes."""
    panels = single_panels(deck(tmp_path).case)
    slopes = [np.degrees(np.arcsin(-panel.rectangle.along[2])) for panel in panels]
    assert slopes == pytest.approx(np.repeat([40.0, 38.6, 23.7, 13.7, 12.0], 2), abs=1e-9)
    assert [panel.name for panel in panels] == [f"deck-{number}" for number in range(1, 11)]


def test_panels_lie_end_to_end_on_beams_that_alternate(tmp_path: Path) -> None:
    """Clamps and gap of 2 mm fill the pitch of 270 mm; beams belong to both frames in turn."""
    panels = single_panels(deck(tmp_path).case)
    for above, below in pairwise(panels):
        gap_m = np.linalg.norm(ends_m(below)[0] - ends_m(above)[1])
        bend = np.arccos(np.clip(above.rectangle.along @ below.rectangle.along, -1, 1))
        assert gap_m == pytest.approx(0.002 * np.cos(bend / 2), abs=1e-9)
        assert above.frames[1] == below.frames[0]
    assert {panel.frames for panel in panels} == {("driving", "driven"), ("driven", "driving")}


def test_segments_of_unequal_length(tmp_path: Path) -> None:
    """Five slopes on eight panels: two panels for each of the first three slopes, one for the others."""
    loaded = deck(
        tmp_path, "screen.decks.deck.panels=8", "screen.decks.deck.panels_per_slope=[2, 2, 2, 1, 1]"
    )
    slopes = [
        float(np.degrees(np.arctan2(-panel.rectangle.along[2], panel.rectangle.along[0])))
        for panel in single_panels(loaded.case)
    ]
    assert slopes == pytest.approx([40.0, 40.0, 38.6, 38.6, 23.7, 23.7, 13.7, 12.0])
    plates = {wall.name: wall.position_m for wall in walls(loaded.case, loaded.folder) if "left" in wall.name}
    assert len(plates) == 5
    for number in range(1, 5):
        above, below = plates[f"deck-left-{number}"], plates[f"deck-left-{number + 1}"]
        assert above[[1, 2]] == pytest.approx(below[[0, 3]], abs=1e-12)


def test_one_angle_follows_the_deck_axes(tmp_path: Path) -> None:
    case = deck(tmp_path, "screen.decks.deck.slopes_deg=[]").case
    start_m = ends_m(single_panels(case)[0])[0]
    end_m = ends_m(single_panels(case)[-1])[1]
    assert (end_m - start_m) @ axes(case) == pytest.approx([2.7 - 0.002, 0.0, 0.0], abs=1e-12)


def test_each_panel_has_its_tension_about_its_middle(tmp_path: Path) -> None:
    tension = [0.002, -0.004, 0, 0.001, 0, 0, 0, 0, 0, 0]
    plain = single_panels(deck(tmp_path).case)
    case = deck(tmp_path, f"screen.decks.deck.tension_m={tension}", "screen.decks.deck.clamp_m=0.01")
    for panel, slack, tension_m in zip(single_panels(case.case), plain, tension, strict=True):
        r = panel.rectangle
        assert r.span_m - r.length_m == pytest.approx(tension_m, abs=1e-12)
        assert np.mean(ends_m(panel), axis=0) == pytest.approx(np.mean(ends_m(slack), axis=0))


def test_a_pitch_that_is_not_given_follows_the_panels_pre_stretch(tmp_path: Path) -> None:
    """240 mm, the largest pre-stretch, two clamps of 14 mm turned by 30 degrees, and 2 mm."""
    tension = [0.002, -0.004, 0, 0.001, 0, 0, 0, 0, 0, 0]
    without = BEFORE + DECK.replace("pitch_m = 0.27\n", "")
    for given, largest_m in (("-0.003", -0.003), (tension, 0.002)):
        sets = [f"screen.decks.deck.tension_m={given}", "screen.decks.deck.clamp_angle_deg=30"]
        case = load_case(tmp_path / f"at {largest_m}", without, [ROOM, INCLINED, *sets]).case
        middles_m = [np.mean(ends_m(panel), axis=0) for panel in single_panels(case)]
        pitch_m = 0.24 + largest_m + 2 * 0.014 * np.cos(np.radians(30.0)) + 0.002
        assert np.linalg.norm(middles_m[1] - middles_m[0]) == pytest.approx(pitch_m, abs=1e-12)


@pytest.mark.parametrize("angle_deg", [0.0, 20.0])
def test_surfaces_close_the_deck(tmp_path: Path, angle_deg: float) -> None:
    """Side plates touch each other along shared edges; beams' tops begin and end at clamps, also where these
    are turned and their outer edges higher; the chute ends above the first beam, sloping by 45 degrees."""
    loaded = deck(tmp_path, f"screen.decks.deck.clamp_angle_deg={angle_deg}")
    plates_by_name = {wall.name: wall for wall in walls(loaded.case, loaded.folder)}
    panels = single_panels(loaded.case)
    for side, y_m in (("left", 0.0), ("right", 0.2)):
        plates = [plates_by_name[f"deck-{side}-{number}"].position_m for number in range(1, 6)]
        for above, below in pairwise(plates):
            assert above[[1, 2]] == pytest.approx(below[[0, 3]], abs=1e-12)
        assert np.concatenate(plates)[:, 1] == pytest.approx(y_m)
    for number, (above, below) in enumerate(pairwise(panels), start=2):
        top = plates_by_name[f"deck-beam-{number}"]
        assert top.position_m[0] == pytest.approx(ends_m(above)[1], abs=1e-12)
        assert top.position_m[1] == pytest.approx(ends_m(below)[0], abs=1e-12)
        assert top.frame == below.frames[0]
    chute = plates_by_name["deck-chute"].position_m
    down = chute[1] - chute[0]
    assert np.degrees(np.arctan2(-down[2], down[0])) == pytest.approx(45.0)
    lifted = chute[1] - (0.0, 0.0, 0.5) @ axes(loaded.case).T
    lift_m = 0.014 * np.sin(np.radians(angle_deg))
    assert lifted @ axes(loaded.case) == pytest.approx([0.0, 0.0, 0.1 + lift_m], abs=1e-12)


def test_plates_face_the_bed(tmp_path: Path) -> None:
    loaded = deck(tmp_path)
    for wall in walls(loaded.case, loaded.folder):
        a, b, c = wall.position_m[wall.triangles[0]]
        normal = np.cross(b - a, c - a)
        if "beam" in wall.name or "chute" in wall.name:
            assert normal[2] > 0


def test_the_resolved_case_has_the_deck_laid_out(tmp_path: Path) -> None:
    loaded = deck(tmp_path)
    assert not loaded.case.screen.decks
    assert find_problems(loaded) == []


@pytest.mark.parametrize(
    ("override", "expected"),
    [
        ("panels=8", ["panels: conflict"]),
        ("panels_per_slope=[2, 2, 2, 2, 1]", ["panels_per_slope: wrong-type"]),
        ("slopes_deg=[40, 30, 20, 12, 70]", ["slopes_deg.4: out-of-range"]),
        ("tension_m=[0.001, 0.002]", ["tension_m: wrong-type"]),
        ("clamp_angle_deg=50.0", ["clamp_angle_deg: out-of-range"]),
        ("tension_m=0.03", ["tension_m: out-of-range", "pitch_m: misplaced"]),
        ("tension_m=-0.03", ["tension_m: out-of-range"]),
        ("pitch_m=0.26", ["pitch_m: misplaced"]),
        ("material='PO'", ["material: unknown-name"]),
        ("frames=['driving', 'drive']", ["frames: unknown-name"]),
        ("corner_m=[0, 0, 2.5]", ["corner_m: misplaced"]),
    ],
)
def test_mistakes_in_a_deck_are_said_of_the_deck(tmp_path: Path, override: str, expected: list[str]) -> None:
    refused = keys_and_kinds(deck_problems(tmp_path, f"screen.decks.deck.{override}"))
    assert {f"screen.decks.deck.{each}" for each in expected} <= {*refused}
    assert all(row.startswith("screen.decks.deck") for row in refused)


def deck_problems(folder: Path, override: str) -> list[CaseProblem]:
    """Return the problems of the deck with a key changed."""
    try:
        return find_problems(deck(folder, override))
    except CaseError as error:
        return [*error.problems]


@pytest.mark.parametrize(
    ("surface", "kind"),
    [
        ("{frame='ground', material='PU'}", "plate: missing"),
        ("{frame='ground', material='PU', corner_m=[0, 0, 0]}", "plate: missing"),
        ("{frame='ground', material='PU', stl='a.stl', corner_m=[0, 0, 0]}", "plate: conflict"),
        (
            "{frame='ground', material='PU', corner_m=[0, 0, 0], edges_m=[[1, 0, 0], [2, 0, 0]]}",
            "plate.edges_m: out-of-range",
        ),
        (
            "{frame='ground', material='PU', corner_m=[0, 0, 0], edges_m=[[9, 0, 0], [0, 1, 0]]}",
            "plate.corner_m: misplaced",
        ),
    ],
)
def test_a_surface_is_a_file_or_a_plate(tmp_path: Path, surface: str, kind: str) -> None:
    refused = keys_and_kinds(deck_problems(tmp_path, f"screen.surfaces.plate={surface}"))
    assert refused == [f"screen.surfaces.{kind}"]
