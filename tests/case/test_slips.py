"""The first slips of a user, each by a machine that moves as screens do and one changed key."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.case.file.base import level_names
from orchestrator.case.file.errors import dotted_key
from orchestrator.cli.main import app
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.checks import motion, slips
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scene.frame_motion import frame_motions, motion_lines
from orchestrator.preflight.scene.scene import scene
from tests.case.test_warnings import MACHINE
from tests.cases import load_case, loaded

CASES = Path(__file__).parents[2] / "cases"
SHAFT = "screen.exciters.shaft"
DRIVE = "screen.frames.driving.drive"
BODY = (
    """
title = "a body on a soft bushing"
duration_s = 1.0
domain_m = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]
materials = {}
[screen.frames.driving]
mass_kg = 100.0
"""
    + "[screen.exciters.shaft]\n"
    + 'frame = "driving"\nposition_m = [0.0, 0.0, 0.0]\nmass_moment_kg_m = 0.5\nspeed_rad_per_s = 80.0\n'
    + "run_up_s = 0.2\n"
    + "[screen.bushings.isolation]\n"
    + 'between = ["ground", "driving"]\npositions_m = [[0.0, 0.0, 0.0]]\n'
    + "stiffness_N_per_m = [1e4, 1e4, 1e4]\ndamping_N_s_per_m = [80.0, 80.0, 80.0]\n"
    + '[frames]\nsolver = "two-mass"\n'
)
SECOND = (
    'screen.exciters.second={frame="driving", position_m=[0.1, 0, 0], mass_moment_kg_m=0.5, '
    "speed_rad_per_s=80.0, run_up_s=0.2, "
)


def problems_and_warnings(folder: Path, *sets: str, case: str = BODY) -> tuple[list[str], list[str]]:
    """The problems of a case and, without any, its warnings but for those of its mats (tests/mats)."""
    judged = load_case(folder, case, sets)
    problems = [str(problem) for problem in find_problems(judged)]
    return problems, [] if problems else [line for line in warnings(judged) if not line.startswith("mat ")]


def test_the_motion_is_that_of_a_mass_on_a_damped_spring(tmp_path: Path) -> None:
    """x = u w^2 / |k - m w^2 + i w c|, round and so the same in every direction of its plane."""
    (motion,) = frame_motions(scene(load_case(tmp_path, BODY).case))
    speed = 80.0
    stroke_m = 0.5 * speed**2 / abs(1e4 - 100.0 * speed**2 + 1j * speed * 80.0)
    assert motion.stroke_m == pytest.approx(stroke_m, rel=1e-9)
    assert motion.acceleration_g == pytest.approx(speed**2 * stroke_m / 9.80665, rel=1e-9)
    assert motion.throw_g == pytest.approx(motion.acceleration_g, rel=1e-9)
    assert motion.in_words == (
        "driving: stroke 5.08 mm (amplitude), nearly a circle, 3.31 g, throw 3.31 g, "
        "at 80 rad/s = 763.9 rpm = 12.7 Hz"
    )
    assert problems_and_warnings(tmp_path) == ([], [])


def test_a_drive_that_turns_its_frame_moves_the_centre_of_mass(tmp_path: Path) -> None:
    """The centre moves by the angle times the arm."""
    turned = f"{DRIVE}={{speed_rad_per_s=80, rotation_rad=[0, 0.01, 0], center_m=[0, 0, 0], run_up_s=0.1}}"
    sets = (turned, "frames.solver=prescribed", "screen.frames.driving.center_of_mass_m=[0.4, 0, 0]")
    (motion,) = frame_motions(scene(load_case(tmp_path, BODY, sets).case))
    assert motion.stroke_m == pytest.approx(0.004, rel=1e-9)


def test_frames_that_the_solver_does_not_move_stand_still(tmp_path: Path) -> None:
    still = load_case(tmp_path, BODY, ["frames.solver=prescribed", f"{SHAFT}.speed_rad_per_s=750"])
    assert list(motion_lines(scene(still.case))) == ["frame driving: nothing shakes it"]
    assert find_problems(still) == []


@pytest.mark.parametrize(
    ("key", "value", "numbers"),
    [
        (f"{SHAFT}.speed_rad_per_s", 750, {"7162", "119", "160", "78.5"}),  # rpm, Hz, the limit, 750 rpm
        (f"{SHAFT}.mass_moment_kg_m", 500, {"0.5"}),  # 500 kg mm
        ("screen.frames.driving.mass_kg", 0.5, set()),
    ],
)
def test_a_motion_beyond_all_screens_is_refused(
    tmp_path: Path, key: str, value: float, numbers: set[str]
) -> None:
    (problem,) = find_problems(load_case(tmp_path, BODY, [f"{key}={value}"]))
    assert (dotted_key(problem.key), problem.kind) == (key, "out-of-range")
    assert numbers <= {*problem.what_helps.split()}
    assert "screen.largest_acceleration_m_per_s2" in problem.what


def test_a_drive_beyond_all_screens_is_refused(tmp_path: Path) -> None:
    drive = f"{DRIVE}={{speed_rad_per_s=80, amplitude_m=[0, 0, 0.1], run_up_s=0.1}}"
    (problem,) = find_problems(load_case(tmp_path, BODY, [drive, "frames.solver=prescribed"]))
    assert (dotted_key(problem.key), problem.kind) == (DRIVE, "out-of-range")
    assert {"65.3", "100"} <= {*problem.what.split()}  # g, mm


@pytest.mark.parametrize(("limit_m_per_s2", "problems"), [(3000.0, 0), (2000.0, 1)])
def test_a_key_says_that_it_is_meant(tmp_path: Path, limit_m_per_s2: float, problems: int) -> None:
    """The unusual value is still told."""
    sets = (f"{SHAFT}.speed_rad_per_s=750", f"screen.largest_acceleration_m_per_s2={limit_m_per_s2}")
    refused, warned = problems_and_warnings(tmp_path, *sets)
    assert len(refused) == problems
    assert len(warned) == 1 - problems


def test_a_resonance_alone_is_not_refused(tmp_path: Path) -> None:
    """The linear estimate without damping has no bound at a mode; the mode is warned of."""
    near = f"screen.bushings.isolation.stiffness_N_per_m={[100.0 * 80.0**2] * 3}"
    problems, warned = problems_and_warnings(
        tmp_path, near, "screen.bushings.isolation.damping_N_s_per_m=[0, 0, 0]"
    )
    assert problems == []
    assert [line for line in warned if "within 15%" in line]
    (line,) = motion_lines(scene(load_case(tmp_path, BODY, [near]).case))
    assert line.endswith("; uncertain, near a mode")


@pytest.mark.parametrize(
    ("override", "wanted"),
    [
        (f"{SHAFT}.speed_rad_per_s=12.5", "12.5 Hz would be 78.5 rad/s"),
        (f"{SHAFT}.speed_rad_per_s=200", "is 200 rad/s = 1910 rpm = 31.8 Hz, and screens have 30 to 160"),
        (f"{SHAFT}.mass_moment_kg_m=3.5", "screen.frames.driving: the driving frame moves with 23.2 g"),
        (f"{SHAFT}.start_s=1.0", f"{SHAFT}.start_s: is after the end of the run, duration_s = 1: it never"),
        (f"{SECOND}phase_rad=3.14159265}}", "shaft and second cancel each other"),
        (f"{SECOND}start=[0, 0, -1]}}", "shaft and second cancel each other"),
        (
            f"{SHAFT}.phase_rad=90.0",
            f"{SHAFT}.phase_rad: is 90 rad, more than a turn; 90 degrees would be 1.57",
        ),
        (
            "screen.inclination_deg=0.26",
            "screen.inclination_deg: is 0.26 degrees; 0.26 rad would be 14.9 deg",
        ),
        (
            "screen.bushings.isolation.rotation_deg=[0, 0.5, 0]",
            "rotation_deg.1: is 0.5 degrees; 0.5 rad would be 28.6 degrees",
        ),
        (
            "screen.bushings.isolation.stiffness_N_per_m=[10, 10, 10]",
            "screen.bushings.isolation.stiffness_N_per_m has 10, and 10 N/mm would be 10000 N/m",
        ),
    ],
)
def test_one_slip_is_one_line_that_names_its_key(tmp_path: Path, override: str, wanted: str) -> None:
    problems, warned = problems_and_warnings(tmp_path, override)
    assert problems == []
    named = [line for line in warned if wanted in line]
    assert len(named) == 1, warned
    assert len([line for line in warned if "no damping" not in line]) == 1


@pytest.mark.parametrize(
    "override",
    [
        f"{SECOND}axis=[0, -1, 0]}}",  # together they shake straight up and down
        f"{SHAFT}.phase_rad=3.0",
        "screen.inclination_deg=2.5",
        f'{SHAFT}.speed_rad_per_s="750 rpm"',
    ],
)
def test_what_screens_do_is_not_warned_of(tmp_path: Path, override: str) -> None:
    assert problems_and_warnings(tmp_path, override) == ([], [])


def test_a_given_unit_is_not_doubted(tmp_path: Path) -> None:
    """The number stays told with its unit."""
    problems, (line,) = problems_and_warnings(tmp_path, f'{SHAFT}.speed_rad_per_s="12.5 rad/s"')
    assert problems == []
    assert "is 12.5 rad/s" in line
    assert "would be" not in line


@pytest.mark.parametrize(("cut_m", "wanted"), [(0.4, "above all sizes, 6 to 20 mm: all that comes is fine"),
                                               (0.001, "below all sizes"), (0.01, "")])  # fmt: skip
def test_a_cut_beside_all_sizes_is_said(tmp_path: Path, cut_m: float, wanted: str) -> None:
    problems, warned = problems_and_warnings(tmp_path, f"output.cut_size_m={cut_m}", case=MACHINE)
    assert problems == []
    assert len(warned) == bool(wanted)
    assert all(f"output.cut_size_m: is {wanted}" in line for line in warned)


def test_a_stroke_across_the_panels_is_said(tmp_path: Path) -> None:
    shaken = "screen.frames.moving.drive.amplitude_m=[0.0, 0.01, 0.0]"
    judged = load_judged(CASES / "panel-cycle", "draft", [shaken])
    assert [line for line in warnings(judged) if "is across panel" in line]


def test_shipped_cases_have_no_slip() -> None:
    """Cases are right at all their levels."""
    problems_by_case = {}
    for file in sorted([*CASES.glob("*/case.toml"), *CASES.glob("hard/*/case.toml")]):
        for level in (None, *level_names(file.parent)):
            loaded = load_judged(file.parent, level)
            shaken = scene(loaded.case)
            problems = [
                *slips.unusual_motion(shaken),
                *slips.late_exciters(loaded.case),
                *slips.cancelled_shafts(shaken),
                *slips.angles_in_other_units(loaded.layers.merged),
                *slips.cut_beside_all_sizes(loaded.case),
            ]
            problems_by_case[file.parent.name, level] = [str(problem) for problem in problems]
    assert not {where: lines for where, lines in problems_by_case.items() if lines}


MOTOR = "{rated_power_W=5e3, synchronous_speed_rad_per_s=82.0, rated_slip=0.02, moment_of_inertia_kg_m2=1.0}"


@pytest.mark.parametrize(("motors", "count"), [(False, 1), (True, 0)])
def test_shafts_with_motors_find_phases_of_their_own(tmp_path: Path, motors: bool, count: int) -> None:
    sets = [f"{SECOND}phase_rad=3.14159265}}", "frames.solver=exudyn"]
    sets += [
        "screen.frames.driving.inertia_kg_m2=[5, 5, 5]",
        "screen.frames.driving.center_of_mass_m=[0, 0, 0]",
    ]
    sets += [f"screen.exciters.{name}.motor={MOTOR}" for name in ("shaft", "second") if motors]
    shaken = scene(load_case(tmp_path, BODY, sets).case)
    assert len([*slips.cancelled_shafts(shaken)]) == count


@pytest.mark.parametrize(("mass_kg", "count"), [(0.20, 0), (0.13, 1)])
def test_a_frame_carries_half_of_each_panel(tmp_path: Path, mass_kg: float, count: int) -> None:
    """One panel of 0.3 m, 0.2 m and 4 mm and 1150 kg/m3: 0.276 kg, of which the ground has the other half."""
    shaken = scene(loaded(tmp_path, [f"screen.frames.driving.mass_kg={mass_kg}"]).case)
    warned = [line for line in motion.slips_of_magnitude(shaken) if "lighter than" in line]
    assert len(warned) == count


def test_check_prints_one_line_for_each_frame() -> None:
    done = CliRunner().invoke(app, ["check", str(CASES / "empty-machine"), "--level", "draft"])
    lines = [line.strip() for line in done.output.splitlines() if " mm (amplitude)" in line]
    assert [line.split(":")[0] for line in lines] == ["frame driving", "frame driven"]
    assert all({"78.5", "749.6", "12.5"} <= {*line.split()} for line in lines)


def test_a_frame_that_tips_over_on_its_one_bushing_is_refused() -> None:
    """The bushing under the centre of mass holds the weight, and nothing keeps the frames from turning."""
    bushing = "screen.bushings.isolation.positions_m=[[0.319, 0.10, 0.0]]"
    case = CASES / "empty-machine"
    problems = [str(problem) for problem in find_problems(load_judged(case, "default", [bushing]))]
    assert len(problems) == 2
    assert all("no bushing holds its weight, or keeps it from tipping over" in line for line in problems)
    assert find_problems(load_judged(case, "draft", [bushing])) == [], "frames that cannot turn"
    loose = [bushing, "screen.drawn_at_rest=false"]
    assert find_problems(load_judged(case, "default", loose)) == []
