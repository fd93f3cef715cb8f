"""The scene's numbers against hand calculation and against what was measured on coupled runs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.deck.panels import axes, to_world
from orchestrator.case.tables.case import Probe
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.scene.shaking import Shaking, solve_shakings
from tests.cases import BLOCK, FEED, load_case, loaded
from tests.effects.verdicts import DRIVEN_CASE

CASES = Path(__file__).parents[2] / "cases"


def driven(folder: Path, *overrides: str) -> Scene:
    return scene(load_case(folder, DRIVEN_CASE, overrides).case)


def test_a_driven_panel_by_hand(tmp_path: Path) -> None:
    """2 mm taut, 3 mm to and fro: 1 mm slack at most, 5 mm taut; sag 2/pi sqrt(0.3e-3)."""
    driven_scene = driven(tmp_path)
    (panel,) = driven_scene.panels
    assert panel.stroke_m == pytest.approx(0.003, rel=1e-9)
    assert panel.sag_m == pytest.approx(2 / math.pi * math.sqrt(0.3e-3), rel=1e-9)
    assert panel.travel_m == panel.sag_m
    assert panel.strain == pytest.approx(0.005 / 0.3, rel=1e-9)


def test_a_panel_that_stays_slack_travels_less_than_it_sags(tmp_path: Path) -> None:
    (panel,) = driven(tmp_path, "screen.panels.deck.tension_m=-0.004").panels
    highest, lowest = (2 / math.pi * math.sqrt(0.3 * d) for d in (0.007, 0.001))
    assert panel.travel_m == pytest.approx(highest - lowest, rel=1e-9)
    assert panel.strain == 0.0


def test_throw_by_hand(tmp_path: Path) -> None:
    """Frames 80^2 * 0.002 / 9.81, panels 80^2 * sag / 9.81."""
    driven_scene = driven(tmp_path)
    assert driven_scene.frames_throw == pytest.approx(6400 * 0.002 / 9.81, rel=1e-9)
    sag_m = 2 / math.pi * math.sqrt(0.3e-3)
    assert driven_scene.panels_throw == pytest.approx(6400 * sag_m / 9.81, rel=1e-9)
    assert driven_scene.throw == driven_scene.panels_throw
    assert driven_scene.impact_m_per_s == pytest.approx(max(1.0, 80 * sag_m), rel=1e-9)


def test_the_throw_of_frames_is_normal_to_an_inclined_deck(tmp_path: Path) -> None:
    driven_scene = driven(tmp_path, "screen.inclination_deg=25")
    assert driven_scene.frames_throw == pytest.approx(6400 * 0.002 / 9.81, rel=1e-9)
    assert driven_scene.slope == pytest.approx(math.tan(math.radians(25)), rel=1e-9)


def test_mass_of_the_bed_by_hand(tmp_path: Path) -> None:
    """The deck is 0.302 x 0.2 m.  A block of 10 000 equal spheres of 6 mm has 1.617 kg."""
    many = BLOCK.replace("count=1", "count=10000").replace(
        "smallest_m=0.01, largest_m=0.02", "smallest_m=0.006, largest_m=0.006"
    )
    case = loaded(tmp_path, [many]).case
    ball_kg = 1430 * math.pi / 6 * 0.02**3
    grains_kg = 10_000 * 1430 * math.pi / 6 * 0.006**3
    assert scene(case).bed_kg_per_m2 == pytest.approx((ball_kg + grains_kg) / (0.302 * 0.2), rel=1e-9)


def test_a_feed_without_exits_brings_all_it_has(tmp_path: Path) -> None:
    """1 kg/s from 0 to 5 s."""
    case = loaded(tmp_path, [FEED, "duration_s=5.0"]).case
    ball_kg = 1430 * math.pi / 6 * 0.02**3
    assert scene(case).bed_kg_per_m2 == pytest.approx((ball_kg + 5.0) / (0.302 * 0.2), rel=1e-9)


def test_one_ball_weighs_on_the_place_where_it_lies(tmp_path: Path) -> None:
    """pi/6 * 1430 * 0.02 = 14.97 kg/m2, although its mass over the deck is a hundredth."""
    assert scene(loaded(tmp_path).case).bed_kg_per_m2 == pytest.approx(14.97, rel=1e-3)


def test_the_published_machine_is_estimated_within_a_fifth() -> None:
    """Xu et al. 2024: relative amplitude 5.9 mm; the panels of cases/ffs0827-empty sag by about
    25 mm under it.  The sine arch over 5.9 mm alone gives 26.8."""
    estimate = scene(load_judged(CASES / "ffs0827-empty", "study").case)
    for panel in estimate.panels:
        assert panel.stroke_m == pytest.approx(5.9e-3, rel=0.2)
        assert panel.sag_m == pytest.approx(25e-3, rel=0.2)


def test_the_empty_machine_is_estimated_within_a_tenth() -> None:
    """Run at both levels: strips 6.00, sheets 5.82 mm of relative amplitude."""
    for panel in scene(load_judged(CASES / "empty-machine", "draft").case).panels:
        assert panel.stroke_m == pytest.approx(5.91e-3, rel=0.1)


def test_the_published_machine_pitches_as_its_points_say() -> None:
    """Six freedoms with panels as springs against the coupled run at level draft (its README):
    amplitudes normal to the deck at both ends of both frames, within 4 %."""
    machine = scene(load_judged(CASES / "ffs0827-empty", "draft").case)
    (motion,) = solve_shakings(machine.plan, machine.springs, None, 6)
    run_mm = {"point-1": 3.89, "point-3": 4.33, "point-4": 4.70, "point-6": 5.36}
    for name, wanted_mm in run_mm.items():
        probe = machine.case.probes[name]
        assert 1e3 * _normal_m(machine, motion, probe) == pytest.approx(wanted_mm, rel=0.04)


def _normal_m(machine: Scene, motion: Shaking, probe: Probe) -> float:
    assert probe.frame is not None
    assert probe.point_m is not None
    body = next(each for each in machine.plan.bodies if each.name == probe.frame)
    arm_m = to_world(machine.case, probe.point_m) - body.center_of_mass_m
    moved = motion.amplitude_m[probe.frame] + np.cross(motion.angle_rad[probe.frame], arm_m)
    return float(abs(moved @ axes(machine.case)[:, 2]))


def test_a_slice_moves_as_the_whole_machine_but_for_the_panels_margins() -> None:
    """Everything extensive is shared out.  The slots of a slice leave no margins at its sides, so
    that its panels are 5 % softer per width; the stroke is then 5 % larger."""
    whole = scene(load_judged(CASES / "ffs0827-empty", "draft").case)
    part = scene(load_judged(CASES / "ffs0827-slice", "study").case)
    assert part.panels[0].stroke_m == pytest.approx(whole.panels[0].stroke_m, rel=0.06)
    assert part.frames_throw == pytest.approx(whole.frames_throw, rel=0.01)
