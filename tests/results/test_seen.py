"""What a run tells of the numbers by which its effects were judged: a run made by hand."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import pytest

from orchestrator.results.compute import results
from orchestrator.results.run_data import RunData, run_data
from orchestrator.results.seen import checked, seen_scene
from orchestrator.scene.account import Entry, account, at_end
from orchestrator.scene.effect import Verdict
from orchestrator.scene.scene import Scene, scene
from tests.results.synthetic import FRAMES_M, TURNED_RAD, folder_of

DECK_M2 = 2 * 0.30 * 0.20


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return folder_of(tmp_path_factory.mktemp("seen") / "run", cycles=12)


@pytest.fixture
def data(folder: Path) -> Iterator[RunData]:
    with h5py.File(folder / "history.h5") as history:
        yield run_data(folder, history)


@pytest.fixture(scope="module")
def figures(folder: Path) -> dict[str, Any]:
    return results(folder)


def seen(data: RunData, figures: dict[str, Any], **solvers: str) -> Scene:
    """Of the run as if other solvers had made it."""
    tables = {
        port: getattr(data.case, port).model_copy(update={"solver": solver})
        for port, solver in solvers.items()
    }
    case = data.case.model_copy(update=tables)
    return seen_scene(scene(case), replace(data, case=case), figures)


def test_motion_of_frames_by_hand(data: RunData, figures: dict[str, Any]) -> None:
    """Both in phase along the deck, by 8 and 2 mm; 5 mm normal to it at 78.5 rad/s."""
    found = seen(data, figures)
    assert [panel.stroke_m for panel in found.panels] == pytest.approx([0.006, 0.006], rel=1e-6)
    assert found.frames_throw == pytest.approx(78.5**2 * 0.005 / 9.81, rel=1e-6)


def test_shapes_of_panels_by_hand(data: RunData, figures: dict[str, Any]) -> None:
    """Straight lines, stretched by 2 % at most."""
    for panel in seen(data, figures).panels:
        assert panel.strain == pytest.approx(0.02, rel=1e-6)
        assert (panel.sag_m, panel.travel_m) == pytest.approx((0.0, 0.0), abs=1e-12)


def test_rigid_panels_have_the_sag_that_their_stroke_would_give(
    data: RunData, figures: dict[str, Any]
) -> None:
    for panel in seen(data, figures, panel="rigid").panels:
        assert panel.sag_m == pytest.approx(2 / math.pi * math.sqrt(0.3 * 0.006), rel=1e-6)


def test_bed_and_its_speed_by_hand(data: RunData, figures: dict[str, Any]) -> None:
    """Eight bins of 0.2 kg, at 0.3 m/s."""
    found = seen(data, figures).seen
    assert found.bed_kg_m2 == pytest.approx(8 * 0.2 / DECK_M2, rel=1e-9)
    assert found.transport_m_s == pytest.approx(0.3, rel=1e-9)


def test_rotation_is_seen_only_where_frames_can_rotate(
    data: RunData, figures: dict[str, Any]
) -> None:
    """Clamps reach to 0.319 m from the driving frame's centre; half a clamp would be too fine."""
    assert seen(data, figures).seen.rotation is None
    rotation = seen(data, figures, frames="exudyn").seen.rotation
    assert rotation is not None
    assert rotation[1] == "at the outermost clamp of driving"
    moved_m = math.hypot(*FRAMES_M["driving"])
    assert rotation[0] == pytest.approx(TURNED_RAD * 0.319 / moved_m, rel=1e-3)
    sideways = seen(data, figures, frames="exudyn").seen.sideways
    assert sideways is not None
    assert sideways[0] == pytest.approx(0.0, abs=1e-12)
    assert seen(data, figures, frames="planar").seen.sideways is None


def test_the_verdicts_are_given_again(folder: Path, data: RunData, figures: dict[str, Any]) -> None:
    before = account(data.case, {"large-deflection": "for once"})
    after = checked(before, data.case, folder, figures)
    sag, load = after["large-deflection"], after["particle-load"].after
    assert sag.before is not None
    assert sag.after is not None
    assert (sag.before.matters, sag.after.matters, sag.crossed) == (True, False, True)
    assert load is not None
    one_ball_kg_m2 = math.pi / 6 * 1430 * 0.02  # which is more than the bed on the mean
    assert load.value == pytest.approx(one_ball_kg_m2 / 4.6, rel=1e-6)
    assert after["variation-across"].after is None, "no run tells"
    (number, warning) = at_end(after)
    assert number.startswith("left out: large-deflection; by the run sag / thickness 0, threshold")
    assert warning.startswith("WARNING: large-deflection, which is left out, may be left out by")


def test_what_turns_out_to_matter_is_a_warning() -> None:
    before = Verdict("Bond", 0.02, "0.1", False, "why")
    matters = replace(before, value=0.3, matters=True)
    lines = list(at_end({"adhesion": Entry("auto", False, before, matters)}))
    assert lines[1] == (
        "WARNING: adhesion, which is left out, matters by the run; the estimate before it was 0.02"
    )
    assert list(at_end({"adhesion": Entry("", True, before, matters)})) == []
    assert len(list(at_end({"adhesion": Entry("auto", False, before, before)}))) == 1


def test_a_run_of_less_than_a_cycle_tells_no_motion(tmp_path: Path) -> None:
    short = folder_of(tmp_path / "run", particles=False, cycles=0)
    with h5py.File(short / "history.h5") as history:
        data = run_data(short, history)
        found = seen_scene(scene(data.case), data, results(short)).seen
    assert (found.frames_throw, found.bed_kg_m2, found.rotation) == (None, None, None)
