"""Each warning about a machine that can hardly be meant, by a good machine with just that mistake."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.checks.defaults import taken_defaults
from tests.cases import CASE, contact, grains, load_case, loaded, polyurethane
from tests.cases import FEED as POURED

MACHINE = (
    """
title = "A good machine: three panels between two frames, fed with gravel"
duration_s = 5.0
domain_m = [[-1.0, -0.6, -2.0], [3.0, 1.0, 1.5]]
"""
    + polyurethane((0.2, 1e-2), (0.2, 2e-3))
    + grains("gravel", 2650.0, 1e7)
    + grains("steel", 7850.0, 2.1e11)
    + contact("gravel", "gravel", 0.3, 0.5)
    + contact("gravel", "PU", 0.3, 0.5, 0.3)
    + contact("gravel", "steel", 0.3, 0.5)
    + """
[screen]
inclination_deg = 15.0

[screen.frames.driving]
mass_kg = 76.4
inertia_kg_m2 = [4.0, 12.0, 12.0]
center_of_mass_m = [0.507, 0.20, -0.05]

[screen.frames.driven]
mass_kg = 28.7
inertia_kg_m2 = [1.0, 3.2, 3.6]
center_of_mass_m = [0.507, 0.20, -0.05]

[screen.bushings.isolation]
between = ["ground", "driving"]
stiffness_N_per_m = [22.5e3, 22.5e3, 22.5e3]
damping_N_s_per_m = [86.0, 86.0, 86.0]
positions_m = [[0.0, -0.1, -0.05], [1.014, -0.1, -0.05], [0.0, 0.5, -0.05], [1.014, 0.5, -0.05]]

[screen.bushings.shear]
between = ["driving", "driven"]
stiffness_N_per_m = [28.9e3, 97.0e3, 97.0e3]
damping_N_s_per_m = [37.0, 124.0, 124.0]
positions_m = [
  [0.1, -0.05, -0.05], [0.507, -0.05, -0.05], [0.914, -0.05, -0.05],
  [0.1, 0.45, -0.05], [0.507, 0.45, -0.05], [0.914, 0.45, -0.05],
]

[screen.exciters.shaft]
frame = "driving"
position_m = [0.507, 0.20, -0.05]
mass_moment_kg_m = 0.35
speed_rad_per_s = 78.5
run_up_s = 0.3

[screen.decks.deck]
material = "PU"
frames = ["driving", "driven"]
corner_m = [0.0, 0.0, 0.0]
panels = 3
pitch_m = 0.338
length_m = 0.30
width_m = 0.40
thickness_m = 0.004
clamp_m = 0.018
tension_m = 0.0
apertures = { length_m = 0.02, width_m = 0.01, pitch_along_m = 0.03, pitch_across_m = 0.02 }
side_plates = { frame = "driving", material = "steel", height_m = 0.3, gap_m = 0.002 }
cross_beams = { material = "PU" }

[screen.surfaces.back]
corner_m = [0.0, 0.0, -0.03]
edges_m = [[0.0, 0.4, 0.0], [0.0, 0.0, 0.4]]
frame = "driving"
material = "steel"

[screen.exits.below]
product = "undersize"
box_m = [[-0.5, -0.5, -0.6], [1.05, 0.9, -0.2]]

[screen.exits.behind]
product = "oversize"
box_m = [[1.05, -0.5, -0.9], [2.5, 0.9, -0.05]]

[bed.feeds.gravel]
material = "gravel"
rate_kg_per_s = 1.0
axes = "deck"
box_m = [[0.05, 0.05, 0.15], [0.25, 0.35, 0.30]]
velocity_m_per_s = [0.0, 0.0, -1.0]
sizes = [{ smallest_m = 0.006, largest_m = 0.02, mass_fraction = 1.0 }]

[panel]
solver = "strip"

[particles]
largest_youngs_modulus_Pa = 1e7
"""
)
DECK, FEED = "screen.decks.deck", "bed.feeds.gravel"
PLATES = f"{DECK}.side_plates"
OPENINGS, SHAFT = f"{DECK}.apertures", "screen.exciters.shaft"
WALLS = 'slice={width_m=0.12, sides="walls"}'
ELSEWHERE = 'screen.exits.{}={{product="{}", box_m=[[2, 0, 1], [2.1, 0.1, 1.1]]}}'
UNDAMPED = tuple(f"screen.bushings.{name}.damping_N_s_per_m=[0, 0, 0]" for name in ("isolation", "shear"))


def warnings_of(folder: Path, *overrides: str, case: str = MACHINE) -> list[str]:
    """Return the warnings about the machine with some keys changed, but for its mats (tests/mats)."""
    judged = load_case(folder, case, overrides)
    assert find_problems(judged) == []
    return [line for line in warnings(judged) if not line.startswith("mat ")]


def test_a_good_machine_has_no_warning(tmp_path: Path) -> None:
    assert warnings_of(tmp_path) == []


@pytest.mark.parametrize(
    ("overrides", "wanted", "lines"),
    [
        ((f"{PLATES}.gap_m=0.008",), "a gap of 8 mm between panel deck-1 and 2 more and the wall along", 2),
        (
            ("screen.surfaces.back.corner_m=[-0.04, 0, -0.03]",),
            "a gap of 39.6 mm between the upper end of",
            1,
        ),
        (
            (f"{PLATES}.height_m=0.001", f"{PLATES}.depth_m=0.1"),
            "no wall along the left side of panel deck-1",
            2,
        ),
        (("screen.surfaces.back.edges_m=[[0, 0.4, 0], [0, 0, 0.029]]",), "no back wall at the upper end", 1),
        ((ELSEWHERE.format("behind", "oversize"),), "no exit behind the lower end, panel deck-3", 1),
        ((ELSEWHERE.format("below", "undersize"),), "no exit below the openings of panel deck-1 and", 1),
        (
            (f"{FEED}.box_m=[[-0.4, 0.05, 0.15], [-0.2, 0.35, 0.3]]",),
            "misses the deck: all trial flights from its",
            1,
        ),
        ((f"{FEED}.velocity_m_per_s=[3, 0, 0]",), "misses the deck: 3 of 27 trial flights from its box", 1),
        ((f"{OPENINGS}.width_m=0.005",), "smaller than all particles: 5 mm against at least 6 mm", 1),
        (
            (f"{OPENINGS}.width_m=0.018", f"{FEED}.sizes.0.largest_m=0.017"),
            "larger than all particles: 18 mm",
            1,
        ),
        (
            UNDAMPED,
            "no damping of motion along the deck of the driving frame with the driven frame, 4.57 Hz",
            1,
        ),
        (("materials.PU.hyperelastic.maxwell=[]",), "no damping in panels of PU", 1),
        (
            ("screen.bushings.shear.stiffness_N_per_m=[28.9e3, 97.0e3, 97]",),
            "soft bushings: motion normal to the deck of the driven frame, 0.708 Hz, which is a static",
            1,
        ),
        ((f"{SHAFT}.run_up_s=0",), 'exciter "shaft" has no run-up: its full force of 2.16e+03 N', 1),
        (
            (f"{SHAFT}.speed_rad_per_s=102",),
            "motion along the deck of the driven frame against the driving",
            1,
        ),
    ],
)
def test_one_mistake_gives_its_own_warning(
    tmp_path: Path, overrides: tuple[str, ...], wanted: str, lines: int
) -> None:
    texts = warnings_of(tmp_path, *overrides)
    assert wanted in texts[0]
    assert len(texts) == lines  # one for each side where both sides have the mistake


@pytest.mark.parametrize(
    ("override", "wanted"),
    [
        (f"{PLATES}.gap_m=0.008", "a gap of 8 mm between panel deck-1 and 2 more and the wall along"),
        ("screen.surfaces.back.edges_m=[[0, 0.4, 0], [0, 0, 0.029]]", "no back wall at the upper end"),
        (ELSEWHERE.format("behind", "oversize"), "no exit behind the lower end, panel deck-3"),
        (ELSEWHERE.format("below", "undersize"), "no exit below the openings of panel deck-1 and"),
        (f"{OPENINGS}.width_m=0.005", "smaller than all particles: 5 mm against at least 6 mm"),
    ],
)
def test_a_bed_that_is_taken_over_is_material_on_the_deck(tmp_path: Path, override: str, wanted: str) -> None:
    """Two grains lie on the first panel of a machine without a feed."""
    rows = ["x_m,y_m,z_m,sieve_size_m,material", "0.12,0.02,0.05,0.006,gravel", "0.12,0.38,0.05,0.02,gravel"]
    (tmp_path / "bed.csv").write_text("\n".join(rows))
    head, _, feed = MACHINE.partition("[bed.feeds.gravel]")
    carried = head + feed[feed.index("[panel]") :]
    assert warnings_of(tmp_path, "bed.table=bed.csv", case=carried) == []
    assert wanted in warnings_of(tmp_path, "bed.table=bed.csv", override, case=carried)[0]


SECOND = """
[screen.exciters.second]
frame = "driven"
position_m = [0.0, 0.0, 0.0]
mass_moment_kg_m = 0.01
speed_rad_per_s = {speed_rad_per_s}
run_up_s = 0.3
"""
MOTOR = """
[screen.exciters.second.motor]
synchronous_speed_rad_per_s = 83.0
rated_power_W = 1e3
rated_slip = 0.05
moment_of_inertia_kg_m2 = 0.01
"""


@pytest.mark.parametrize(
    ("speed_rad_per_s", "more", "beats"),
    [(78.6, "", True), (78.5, "", False), (157.0, "", False), (78.6, MOTOR, False)],
)
def test_two_speeds_that_beat_are_said(
    speed_rad_per_s: float, more: str, beats: bool, tmp_path: Path
) -> None:
    """Speeds of 78.5 and 78.6 rad/s are in step once in 2 pi / 0.1 = 62.8 s."""
    head, _, rest = MACHINE.partition("[screen.decks.deck]")
    second = SECOND.format(speed_rad_per_s=speed_rad_per_s) + more
    texts = warnings_of(tmp_path, case=f"{head}{second}\n[screen.decks.deck]{rest}")
    lines = [line for line in texts if "they beat, in step once every 62.8 s" in line]
    assert len(lines) == beats


def test_a_drive_that_holds_its_frame_does_not_beat(tmp_path: Path) -> None:
    drive = "[screen.frames.driven.drive]\nspeed_rad_per_s = 78.6\namplitude_m = [0.0, 0.0, 0.0]\n"
    head, _, rest = MACHINE.partition("[screen.decks.deck]")
    lines = warnings_of(tmp_path, case=f"{head}{drive}[screen.decks.deck]{rest}")
    assert not [line for line in lines if "they beat" in line]


def test_gaps_between_panels_are_said(tmp_path: Path) -> None:
    case = MACHINE.replace('cross_beams = { material = "PU" }\n', "").replace(
        "pitch_m = 0.338", "pitch_m = 0.36"
    )
    (warning,) = [line for line in warnings_of(tmp_path, case=case) if "between panels" in line]
    assert "a gap of 24 mm between panels deck-1 and deck-2 (and at 1 more joints): all particles" in warning
    # Cross beams of panels with a longer pitch cover their longer gaps.
    covered = MACHINE.replace("pitch_m = 0.338", "pitch_m = 0.36")
    assert [line for line in warnings_of(tmp_path, case=covered) if "between panels" in line] == []


@pytest.mark.parametrize(("corner_m", "lines"), [(-0.26, 0), (-0.34, 1)])
def test_a_panel_that_reaches_over_the_next_leaves_no_gap(
    corner_m: float, lines: int, tmp_path: Path
) -> None:
    """The panel is 0.3 m long and 50 mm higher, and ends 40 mm behind or before the edge of the deck."""
    over = (
        f'screen.panels.over={{material="PU", frames=["driving", "driving"], corner_m=[{corner_m}, 0, 0.05], '
        "length_m=0.3, span_m=0.3, width_m=0.4, thickness_m=0.004}"
    )
    assert (
        len([line for line in warnings_of(tmp_path, over) if "between panels over and deck-1" in line])
        == lines
    )


def test_periodic_sides_are_closed(tmp_path: Path) -> None:
    gap, periodic = f"{PLATES}.gap_m=0.008", "slice.width_m=0.12"
    assert warnings_of(tmp_path, gap, periodic) == []
    assert len(warnings_of(tmp_path, gap, WALLS)) == 2


def test_an_exit_that_a_panel_swings_into_is_said(tmp_path: Path) -> None:
    """Mounted without tension, the panels sag by 2/pi sqrt(L stroke), some 30 mm."""
    box = "screen.exits.below.box_m=[[-0.5, -0.5, -0.6], [1.05, 0.9, {}]]"
    assert warnings_of(tmp_path, box.format(-0.08)) == []
    (warning,) = warnings_of(tmp_path, box.format(-0.005))
    assert 'and 2 more swings into exit "below", by up to ' in warning


@pytest.mark.parametrize(("low_m", "reaches"), [(-0.5, True), (0.25, True), (0.26, False), (0.3, False)])
def test_an_exit_beside_periodic_sides_is_said(tmp_path: Path, low_m: float, reaches: bool) -> None:
    """No particle could leave there, and the flights, which know no sides, end in it."""
    exit_ = f"screen.exits.behind.box_m=[[1.1, {low_m}, -1.0], [2.5, 0.9, -0.3]]"
    lines = warnings_of(tmp_path, "slice.width_m=0.12", exit_)
    wanted = 'no particle gets to exit "behind": box_m does not reach into the slice from y = 0.14 to 0.26 m'
    assert lines == ([] if reaches else [wanted])
    assert not any("no particle gets" in line for line in warnings_of(tmp_path, WALLS, exit_))


@pytest.mark.parametrize(
    ("corner_m", "frames", "wanted"),
    [
        ([0.34, 0.0, 0.0], '["ground", "driving"]', None),
        ([0.34, 0.0, -0.01], '["ground", "driving"]', "the second begins 10 mm below the first's end"),
        ([0.34, 0.005, 0.0], '["ground", "driving"]', "the second is 5 mm aside of the first"),
        ([0.34, 0.0, 0.0], '["driving", "ground"]', "ground holds the first's end and driving the second's"),
    ],
)
def test_panels_out_of_line_are_said(
    tmp_path: Path, corner_m: list[float], frames: str, wanted: str | None
) -> None:
    second = (
        f'screen.panels.second={{material="PU", frames={frames}, corner_m={corner_m}, length_m=0.3, '
        "width_m=0.2, thickness_m=0.004, clamp_m=0.019, tension_m=0.002}"
    )
    lines = [line for line in warnings(loaded(tmp_path, [second])) if "panels deck and second" in line]
    assert len(lines) == (wanted is not None)
    assert all(wanted in line for line in lines if wanted)


def test_a_kink_in_the_deck_is_said(tmp_path: Path) -> None:
    def kinks(slopes_deg: str) -> list[str]:
        low = "screen.exits.{}.box_m=[[{}, -0.5, -0.9], [{}, 0.9, -0.6]]"
        exits = low.format("below", -0.5, 1.05), low.format("behind", 1.05, 2.5)
        bent = warnings_of(tmp_path, f"{DECK}.slopes_deg={slopes_deg}", *exits)
        return [line for line in bent if "out of line" in line]

    assert kinks("[25.0, 15.0, 5.0]") == []
    assert "they make an angle of 25 deg (and 1 more such joints)" in kinks("[40.0, 15.0, 40.0]")[0]


@pytest.mark.parametrize(
    ("stroke_m", "ends", "wanted"),
    [
        ("[0.003, 0, 0]", '["driving", "ground"]', None),
        ("[0, 0, 0.003]", '["driving", "ground"]', "is normal to panel deck: 3 mm against 0 mm along it"),
        ("[0, 0, 0.003]", '["driving", "driving"]', "the driving frame is normal to the level panel deck"),
        ("[0.003, 0, 0.003]", '["driving", "driving"]', None),
    ],
)
def test_strokes_normal_to_panels_are_said(
    tmp_path: Path, stroke_m: str, ends: str, wanted: str | None
) -> None:
    drive = f"screen.frames.driving.drive={{amplitude_m={stroke_m}, speed_rad_per_s=78.5, run_up_s=0.1}}"
    sets = ["frames.solver=prescribed", drive, f"screen.panels.deck.frames={ends}", POURED]
    lines = [line for line in warnings(loaded(tmp_path, sets)) if "is normal to" in line]
    assert len(lines) == (wanted is not None)
    assert all(wanted in line for line in lines if wanted)


def test_a_mode_near_the_excitation_is_named_by_its_shape(tmp_path: Path) -> None:
    """A frame of 76 kg and 6 kg m2 between two bushings 0.4 m from its middle, of 40 kN/m upwards."""
    pitch_Hz = math.sqrt((2 * 4e4 * 0.4**2) / 6.0) / (2 * math.pi)
    speed = f"{SHAFT}.speed_rad_per_s={2 * math.pi * pitch_Hz}"
    free = 'screen.panels.deck.frames=["ground", "ground"]'
    (warning,) = [line for line in warnings(loaded(tmp_path, [speed, free])) if "15%" in line]
    assert {"pitch", "driving", f"{pitch_Hz:.3g}"} <= {*warning.split()}


def test_defaults_that_decide_about_the_physics_are_named(tmp_path: Path) -> None:
    bare = load_case(tmp_path, MACHINE.replace("inclination_deg = 15.0", "").replace("tension_m = 0.0", ""))
    level, neither, sense = taken_defaults(bare.layers.merged)
    assert level == "screen.inclination_deg = 0: the deck is level"
    assert neither.startswith("tension_m = 0 of deck: ")
    assert "axis = [0, 1, 0]: on its upper side the unbalance moves down the deck" in sense
    given = load_case(tmp_path, MACHINE, [f"{SHAFT}.axis=[0, 1, 0]"])
    assert list(taken_defaults(given.layers.merged)) == []


def test_a_deck_along_y_is_warned_of(tmp_path: Path) -> None:
    """Its strokes along the deck would be 0, since they are those along x."""
    sets = ["screen.panels.deck.along=[0.0, 1.0, 0.0]", "screen.panels.deck.across=[-1.0, 0.0, 0.0]"]
    (warning,) = [what for what in warnings(load_case(tmp_path / "y", CASE, sets)) if "along x" in what]
    assert warning.startswith("not along x: panel deck;")
    back = ["screen.panels.deck.along=[-1.0, 0.0, 0.0]", "screen.panels.deck.across=[0.0, -1.0, 0.0]"]
    for number, others in enumerate(([], back)):
        assert not [
            what for what in warnings(load_case(tmp_path / f"x-{number}", CASE, others)) if "along x" in what
        ]
