"""The effect motor-slip: the power a motor has to give, and what it does to the stroke."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.planning import frames_plan
from orchestrator.scene.catalogue import EFFECTS, present
from orchestrator.scene.scene import scene
from tests.case.cases import loaded, only_complaint
from tests.effects.verdicts import verdict

MOTOR = (
    "screen.exciters.shaft.motor={rated_power_W=400, synchronous_speed_rad_s=80, rated_slip=0.04, "
    "moment_of_inertia_kg_m2=0.2}"
)
DAMPED = "screen.bushings.isolation.damping_N_s_m=[300.0, 300.0, 300.0]"
PLANAR = "frames.solver=planar"


def test_the_power_is_what_the_dampers_take(tmp_path: Path) -> None:
    """c w^2 |X|^2 / 2 of each damper, along each of its axes; slip in proportion to it."""
    case = loaded(tmp_path, [MOTOR, DAMPED, PLANAR]).case
    found = EFFECTS["motor-slip"].judge(scene(case))
    assert found is not None
    (shaking,) = scene(case).shaken
    count = len(case.screen.bushings["isolation"].positions_m)
    speed = case.screen.exciters["shaft"].speed_rad_s
    moved_m = np.linalg.norm(shaking.amplitude_m["driving"])
    share = count * 300.0 * (speed * moved_m) ** 2 / 2 / 400.0
    assert f"takes {share:.2g} of the rated power" in found.why
    assert found.why.endswith(f"a slip of {0.04 * share:.2g}")


def test_more_than_the_rated_power_matters(tmp_path: Path) -> None:
    tiny = MOTOR.replace("=400", "=0.01")
    assert verdict(tmp_path, "motor-slip", tiny, DAMPED, PLANAR).verdict.matters


@pytest.mark.parametrize(
    ("solver", "knows"), [("planar", True), ("exudyn", True), ("two-mass", False)]
)
def test_who_has_it(tmp_path: Path, solver: str, knows: bool) -> None:
    found = loaded(tmp_path, [MOTOR, f"frames.solver={solver}"])
    assert present(found.case, "motor-slip") is knows
    assert ("motor-slip" in found.left_out) is not knows
    none = np.zeros((0, 3))
    planned = frames_plan(found.case, none, (), none)
    assert (planned.exciters[0].motor is not None) is knows


def test_without_a_motor_there_is_no_such_question(tmp_path: Path) -> None:
    case = loaded(tmp_path, [])
    assert not present(case.case, "motor-slip")
    assert "motor-slip" not in case.left_out


def test_motors_that_cannot_be(tmp_path: Path) -> None:
    slow = MOTOR.replace("synchronous_speed_rad_s=80", "synchronous_speed_rad_s=50")
    assert "a motor lags behind it" in only_complaint(tmp_path, slow)
    along = "screen.exciters.shaft.axis=[1.0, 0.0, 0.0]"
    assert "not across the deck" in only_complaint(tmp_path, MOTOR, PLANAR, along)


def test_slip_that_is_not_named_takes_the_motor_away(tmp_path: Path) -> None:
    before = loaded(tmp_path, [MOTOR, PLANAR]).case
    others = [name for name in EFFECTS if present(before, name) and name != "motor-slip"]
    case = loaded(tmp_path, [MOTOR, PLANAR, f"effects={others}"])
    assert case.case.screen.exciters["shaft"].motor is None
    assert set(case.left_out) == {"motor-slip", "sideways-motion"}
