"""The effect motor-slip: the power a motor has to give, and what it does to the stroke."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.solver_plans import frames_plan
from orchestrator.ports.plans import ExciterPlan
from orchestrator.ports.unbalance import Unbalance
from orchestrator.preflight.judgement.catalogue import EFFECTS, has_effect
from orchestrator.preflight.scene.observed import ExciterLoad, Observed
from orchestrator.preflight.scene.scene import scene
from tests.cases import kinds, loaded
from tests.effects.verdicts import verdict

MOTOR = (
    "screen.exciters.shaft.motor={rated_power_W=400, synchronous_speed_rad_per_s=80, rated_slip=0.04, "
    "moment_of_inertia_kg_m2=0.2}"
)
DAMPED = "screen.bushings.isolation.damping_N_s_per_m=[300.0, 300.0, 300.0]"
TURNING = "frames.solver=exudyn"


def test_the_power_is_what_the_dampers_take(tmp_path: Path) -> None:
    """c w^2 |X|^2 / 2 of each damper, along each of its axes; slip in proportion to it."""
    case = loaded(tmp_path, [MOTOR, DAMPED, TURNING]).case
    weighed = EFFECTS["motor-slip"].judge(scene(case))
    assert weighed is not None
    (shaking,) = scene(case).shaken
    count = len(case.screen.bushings["isolation"].positions_m)
    speed = case.screen.exciters["shaft"].speed_rad_per_s
    moved_m = np.linalg.norm(shaking.amplitude_m["driving"])
    share = count * 300.0 * (speed * moved_m) ** 2 / 2 / 400.0
    assert f"takes {share:.2g} of the rated power" in weighed.why
    assert weighed.why.endswith(f"a slip of {0.04 * share:.2g}")


def test_more_than_the_rated_power_matters(tmp_path: Path) -> None:
    tiny = MOTOR.replace("=400", "=0.01")
    assert verdict(tmp_path, "motor-slip", tiny, DAMPED, TURNING).verdict.matters


@pytest.mark.parametrize(("solver", "knows"), [("exudyn", True), ("two-mass", False)])
def test_who_has_it(tmp_path: Path, solver: str, knows: bool) -> None:
    judged = loaded(tmp_path, [MOTOR, f"frames.solver={solver}"])
    assert has_effect(judged.case, "motor-slip") is knows
    assert ("motor-slip" in judged.left_out) is not knows
    none = np.zeros((0, 3))
    planned = frames_plan(judged.case, none, (), none)
    assert (planned.exciters[0].motor is not None) is knows


def test_without_a_motor_there_is_no_such_question(tmp_path: Path) -> None:
    case = loaded(tmp_path, [])
    assert not has_effect(case.case, "motor-slip")
    assert "motor-slip" not in case.left_out


def test_motors_that_cannot_be(tmp_path: Path) -> None:
    slow = MOTOR.replace("synchronous_speed_rad_per_s=80", "synchronous_speed_rad_per_s=50")
    assert kinds(tmp_path, slow) == ["screen.exciters.shaft.motor.synchronous_speed_rad_per_s: out-of-range"]
    in_rpm = MOTOR.replace("synchronous_speed_rad_per_s=80", "synchronous_speed_rad_per_s=800")
    assert kinds(tmp_path, in_rpm) == [
        "screen.exciters.shaft.motor.synchronous_speed_rad_per_s: out-of-range"
    ]


def test_slip_that_is_not_named_takes_the_motor_away(tmp_path: Path) -> None:
    before = loaded(tmp_path, [MOTOR, TURNING]).case
    others = [name for name in EFFECTS if has_effect(before, name) and name != "motor-slip"]
    case = loaded(tmp_path, [MOTOR, TURNING, f"effects={others}"])
    assert case.case.screen.exciters["shaft"].motor is None
    assert set(case.left_out) == {"motor-slip", "grain-shape"}


def test_a_shaft_that_runs_up_has_turned_half_as_far() -> None:
    """Half a cosine: the mean speed of the run-up is half of the full one."""
    along, _, across = np.eye(3)
    exciter = ExciterPlan("driving", np.zeros(3), across, along, 1.0, 80.0, run_up_s=0.2, start_s=0.1)
    turned, _, _ = Unbalance(exciter).turning(np.array([0.0, 0.1, 0.2, 0.3, 0.4]))
    half_way = 80.0 * (0.1 / 2 - 0.2 / (2 * np.pi))
    np.testing.assert_allclose(turned, [0.0, 0.0, half_way, 8.0, 16.0], atol=1e-12)


@pytest.mark.parametrize(("largest_N_m", "matters"), [(0.01, False), (5.0, None), (1e3, True)])
def test_a_run_without_the_motor_says_whether_it_would_have_passed(
    tmp_path: Path, largest_N_m: float, matters: bool | None
) -> None:
    """The verdict uses the torque that the machine took on its way up, in place of the steady motion's
    there."""
    estimated = scene(loaded(tmp_path, [MOTOR, DAMPED, TURNING]).case)
    seen = replace(
        estimated, observed=Observed(exciter_load=ExciterLoad(power_W=0.01, largest_N_m=largest_N_m))
    )
    weighed = EFFECTS["motor-slip"].judge(seen)
    assert weighed is not None
    assert weighed.matters is matters
