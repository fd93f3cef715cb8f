"""Observations of a run on the numbers by which its effects were judged: a run made by hand."""

from __future__ import annotations

import math
from collections.abc import Iterator
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case
from orchestrator.output.results.compute import compute_results
from orchestrator.output.results.observed import (
    check_effects_by_run,
    loss_factor,
    observed_scene,
    products,
    spring_N_per_m,
)
from orchestrator.output.results.run_reader import RunReader
from orchestrator.preflight.judgement.account import Entry, account, lines_at_end
from orchestrator.preflight.judgement.catalogue import EFFECTS
from orchestrator.preflight.scene.effect import Verdict
from orchestrator.preflight.scene.observed import Bearing, Deepest, Observed, Products
from orchestrator.preflight.scene.scene import Scene, scene, stroke_m
from orchestrator.preflight.scene.shaking import solve_shakings
from tests.results.synthetic import CYCLE_S, FRAMES_M, LEAVES, SIZES_M, TURNED_RAD, folder_of
from tests.runs.outside import flipflow

DECK_RAD = math.radians(15)
DECK_M2 = 2 * 0.30 * 0.20


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return folder_of(tmp_path_factory.mktemp("seen") / "run", cycles=12)


@pytest.fixture
def data(folder: Path) -> Iterator[RunReader]:
    with RunReader(folder) as run:
        yield run


def with_case(data: RunReader, case: Case) -> RunReader:
    """The same time series, as if they were of another case."""
    other = copy(data)
    other.case = case
    return other


@pytest.fixture(scope="module")
def figures(folder: Path) -> dict[str, Any]:
    return compute_results(folder)


def seen(data: RunReader, figures: dict[str, Any], **solvers: str) -> Scene:
    """Return the scene of the run as if other solvers had made it."""
    tables = {
        port: getattr(data.case, port).model_copy(update={"solver": solver})
        for port, solver in solvers.items()
    }
    case = data.case.model_copy(update=tables)
    return observed_scene(scene(case), with_case(data, case), figures)


def test_motion_of_frames_by_hand(data: RunReader, figures: dict[str, Any]) -> None:
    """Both frames move in phase along the deck, by 8 and 2 mm; 5 mm normal to it at 78.5 rad/s."""
    seen_scene = seen(data, figures)
    assert [panel.stroke_m for panel in seen_scene.panels] == pytest.approx([0.006, 0.006], rel=1e-6)
    assert seen_scene.frames_throw == pytest.approx(78.5**2 * 0.005 / 9.81, rel=1e-6)


def test_a_shaft_that_lags_tells_the_speed(tmp_path: Path) -> None:
    """The same motion, of a machine that names 82 rad/s: whole cycles of the shaft do not fill the window."""
    place = folder_of(tmp_path / "run", particles=False, cycles=12)
    with h5py.File(place / "history.h5", "a") as history:
        time_s = history["frames/driving/time_s"][:]
        history["shafts/shaft/time_s"], history["shafts/shaft/angle_rad"] = time_s, 78.5 * time_s
    with RunReader(place) as data:
        case, results = data.case, compute_results(place)
        quick = {
            name: row.model_copy(update={"speed_rad_per_s": 82.0})
            for name, row in case.screen.exciters.items()
        }
        case = case.model_copy(update={"screen": case.screen.model_copy(update={"exciters": quick})})
        seen_scene = observed_scene(scene(case), with_case(data, case), results)
    assert [panel.stroke_m for panel in seen_scene.panels] == pytest.approx([0.006, 0.006], rel=1e-3)
    assert seen_scene.frames_throw == pytest.approx(78.5**2 * 0.005 / 9.81, rel=1e-3)
    assert results.motion.speed_rad_per_s == pytest.approx(78.5, rel=1e-9)


def test_shapes_of_panels_by_hand(data: RunReader, figures: dict[str, Any]) -> None:
    """Straight lines, stretched by 2 % at most."""
    for panel in seen(data, figures).panels:
        assert panel.strain == pytest.approx(0.02, rel=1e-6)
        assert (panel.sag_m, panel.travel_m) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_rigid_panels_have_the_sag_that_their_stroke_would_give(
    data: RunReader, figures: dict[str, Any]
) -> None:
    for panel in seen(data, figures, panel="rigid").panels:
        assert panel.sag_m == pytest.approx(2 / math.pi * math.sqrt(0.3 * 0.006), rel=1e-6)


def test_power_and_torque_of_the_exciters_by_hand(data: RunReader, figures: dict[str, Any]) -> None:
    """The exciters are given 2 W all the time, at 78.5 rad/s from the start."""
    screen = data.case.screen
    at_once = {
        name: exciter.model_copy(update={"run_up_s": 0.0, "start_s": 0.0})
        for name, exciter in screen.exciters.items()
    }
    screen = screen.model_copy(update={"exciters": at_once})
    data = with_case(data, data.case.model_copy(update={"screen": screen}))
    load = seen(data, figures).observed.exciter_load
    assert load is not None
    assert load.power_W == pytest.approx(2.0, rel=1e-6)
    assert load.largest_N_m == pytest.approx(2.0 / 78.5, rel=1e-6)


def test_bed_and_its_speed_by_hand(data: RunReader, figures: dict[str, Any]) -> None:
    """Eight bins of 0.2 kg, at 0.3 m/s."""
    observed = seen(data, figures).observed
    assert observed.bed_kg_per_m2 == pytest.approx(8 * 0.2 / DECK_M2, rel=1e-9)
    assert observed.transport_m_per_s == pytest.approx(0.3, rel=1e-9)


def test_panels_as_springs_by_hand(data: RunReader, figures: dict[str, Any]) -> None:
    """50 N in phase with a stretch of 6 mm, of either panel."""
    seen_scene = seen(data, figures, panel="strip")
    assert [spring.stiffness_N_per_m for spring in seen_scene.springs] == pytest.approx(
        [50 / 0.006] * 2, rel=1e-6
    )
    assert seen_scene.observed.panels_N_per_m == pytest.approx(2 * 50 / 0.006, rel=1e-6)
    then = solve_shakings(seen_scene.plan, seen_scene.springs)
    assert stroke_m(seen_scene.shaken, seen_scene.springs[0]) == stroke_m(then, seen_scene.springs[0])
    assert seen(data, figures, panel="rigid").observed.panels_N_per_m is None


def test_a_pull_out_of_phase_is_no_spring() -> None:
    assert spring_N_per_m(50 * np.exp(-0.5j * np.pi), 0.006) == pytest.approx(0.0, abs=1e-6)


def test_loss_factor_at_the_frequencies_of_the_pull(data: RunReader, figures: dict[str, Any]) -> None:
    """One branch of half the elastic modulus, relaxing at the cycle's speed: 0.25 / 1.25; of a pull
    with as much power at the double speed, the mean of that and 0.2 / 1.4."""
    own_panel = seen(data, figures, panel="strip").panels[0]
    panel = replace(own_panel, material=replace(own_panel.material, branches=((0.5, 1 / 78.5),)))
    time_s = np.arange(40 * 80) * CYCLE_S / 80
    wave, double = np.cos(78.5 * time_s), np.cos(2 * 78.5 * time_s)
    assert loss_factor(panel, time_s, 150 + 50 * wave) == pytest.approx(0.2, rel=1e-2)
    both = (0.25 / 1.25 + 0.2 / 1.4) / 2
    assert loss_factor(panel, time_s, 150 + 50 * (wave + double)) == pytest.approx(both, rel=1e-2)
    assert loss_factor(panel, time_s, 0.0 * time_s) is None


def test_bearing_on_the_deck_by_hand(data: RunReader, figures: dict[str, Any]) -> None:
    """3 N down on either panel, of 1.6 kg on a deck that falls along +x."""
    bearing = seen(data, figures).observed.bearing
    assert bearing is not None
    slope_rad = math.asin(-single_panels(data.case)[0].rectangle.along[2])
    assert bearing.carried == pytest.approx(6.0 / (1.6 * 9.81), rel=1e-9)
    assert bearing.mobilised == pytest.approx(math.tan(slope_rad), rel=1e-9)
    assert all(type(value) is float for value in vars(bearing).values()), "for summary.json"


def test_overlaps_by_hand(data: RunReader, figures: dict[str, Any]) -> None:
    observed = seen(data, figures).observed
    assert observed.deepest == Deepest(per_diameter=0.02, surface_m=4e-5)
    assert observed.products is None, "ten particles left through either exit"


def test_products_by_hand(tmp_path: Path) -> None:
    """Mean diameters by mass: sums of n d^4 over n d^3."""
    folder = folder_of(tmp_path / "run", cycles=30)
    with RunReader(folder) as run:
        split = products(run)
    mass, moment = LEAVES @ SIZES_M**3, LEAVES @ SIZES_M**4
    fine_m, _, coarse_m = moment / mass
    assert split is not None
    assert split.ratio == pytest.approx(coarse_m / fine_m, rel=1e-9)
    assert "through end" in split.words


def test_rotation_is_seen_only_where_frames_can_rotate(data: RunReader, figures: dict[str, Any]) -> None:
    """Clamps reach to 0.319 m from the driving frame's centre; half a clamp would be too fine."""
    assert seen(data, figures).observed.rotation is None
    rotation = seen(data, figures, frames="exudyn").observed.rotation
    assert rotation is not None
    assert rotation[1] == "at the outermost clamp of driving"
    moved_m = math.hypot(*FRAMES_M["driving"])
    assert rotation[0] == pytest.approx(TURNED_RAD * 0.319 / moved_m, rel=1e-3)


def test_the_verdicts_are_given_again(folder: Path, data: RunReader, figures: dict[str, Any]) -> None:
    before = account(data.case, {"large-deflection": "for once"})
    after = check_effects_by_run(before, data.case, folder, figures)
    sag, load = after["large-deflection"], after["particle-load"].after
    assert sag.before is not None
    assert sag.after is not None
    assert (sag.before.matters, sag.after.matters, sag.is_crossed) == (True, False, True)
    assert load is not None
    softness = after["contact-stiffness"].after
    assert softness is not None
    assert (softness.value, softness.matters) == (pytest.approx(0.04), False)
    friction = after["sliding-friction"].after
    assert friction is not None
    assert friction.number == "friction / weight, along the deck"
    assert friction.value == pytest.approx(6.0 / (1.6 * 9.81), rel=1e-9)
    one_ball_kg_per_m2 = math.pi / 6 * 1430 * 0.02  # which is more than the bed on the mean
    assert load.value == pytest.approx(one_ball_kg_per_m2 / 4.6, rel=1e-6)
    assert after["variation-across"].after is None, "no run tells"
    (number, warning) = lines_at_end(after)
    assert number.startswith("left out: large-deflection; by the run sag / thickness 0, threshold")
    assert warning.startswith("WARNING: large-deflection, which is left out, may be left out by")


@pytest.mark.parametrize(
    ("effect", "was_seen", "value", "matters"),
    [
        ("size-distribution", Observed(products=Products(1.5, "so")), 1.5, True),
        ("size-distribution", Observed(products=Products(1.05, "so")), 1.05, False),
        ("contact-stiffness", Observed(deepest=Deepest(0.2, 0.0)), 0.4, True),
        ("contact-stiffness", Observed(deepest=Deepest(0.01, 0.0)), 0.02, False),
        ("panel-damping", Observed(loss_factor=0.02), 0.04 * math.pi, True),
        ("sliding-friction", Observed(bearing=Bearing(0.5, 0.01)), 0.005 / math.tan(DECK_RAD), False),
        ("sliding-friction", Observed(bearing=Bearing(0.5, None)), 0.235 / math.tan(DECK_RAD), True),
        ("rolling-friction", Observed(bearing=Bearing(0.1, None)), 0.009 / math.tan(DECK_RAD), True),
    ],
)
def test_the_verdict_by_what_a_run_has_seen(
    data: RunReader, effect: str, was_seen: Observed, value: float, matters: bool
) -> None:
    """The coal of the quickstart has 0.47 and 0.09 on panels, at 15 degrees."""
    judged = EFFECTS[effect].judge(replace(scene(data.case), observed=was_seen))
    assert judged is not None
    assert judged.value == pytest.approx(value, rel=1e-6)
    assert judged.matters is matters


def test_what_turns_out_to_matter_is_a_warning() -> None:
    before = Verdict("Bond", 0.02, "0.1", False, "why")
    matters = replace(before, value=0.3, matters=True)
    lines = list(lines_at_end({"adhesion": Entry("auto", False, before, matters)}))
    assert lines[1] == (
        "WARNING: adhesion, which is left out, matters by the run; the estimate before it was 0.02"
    )
    assert list(lines_at_end({"adhesion": Entry("", True, before, matters)})) == []
    assert len(list(lines_at_end({"adhesion": Entry("auto", False, before, before)}))) == 1


def test_a_run_of_less_than_a_cycle_tells_no_motion(tmp_path: Path) -> None:
    short = folder_of(tmp_path / "run", particles=False, cycles=0)
    with RunReader(short) as data:
        observed = observed_scene(scene(data.case), data, compute_results(short)).observed
    assert (observed.frames_throw, observed.bed_kg_per_m2, observed.rotation) == (None, None, None)


@pytest.mark.process
def test_driven_frames_of_less_than_a_cycle_tell_no_motion_either(tmp_path: Path) -> None:
    """Their window begins with the run."""
    sets = ["--set", "frames.solver=prescribed", "--set", "duration_s=0.05"]
    done = flipflow("run", "cases/quickstart", "--level", "draft", *sets, "--out", str(tmp_path / "run"))
    assert done.returncode == 0, done.stderr
