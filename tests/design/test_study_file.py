"""Mistakes of a study are told at once: file, key, value and the nearest right key."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.studies.design.study_file import read_study
from tests.cases import keys_and_kinds
from tests.design.campaigns import belt, write_study
from tests.docs.pages import code_on


def complaint(file: Path) -> str:
    """Return the message about a study."""
    with pytest.raises(CaseError) as refused:
        read_study(file)
    return str(refused.value)


WRONG: dict[str, tuple[dict[str, Any], str]] = {
    "another unit than that of a result": (
        {"responses/speed": {"result": "stroke", "unit": "mm"}},
        "responses.speed.unit: conflict",
    ),
    "another unit than that of a path": (
        {"responses/speed": {"result": "results.motion.ground.amplitude_N.z", "unit": "kN"}},
        "responses.speed.unit: conflict",
    ),
    "a power in percents": (
        {"responses/speed": {"result": "power", "unit": "W", "scale": "percent"}},
        "responses.speed.scale: conflict",
    ),
    "a range that is turned round": (
        {"factors/slope/range": [30.0, 10.0]},
        "factors.slope.range: out-of-range",
    ),
    "a range of no width": ({"factors/slope/range": [20.0, 20.0]}, "factors.slope.range: out-of-range"),
    "a range of rounding": (
        {"factors/slope/range": [1.0, 1.0000000000000002]},
        "factors.slope.range: out-of-range",
    ),
    "a seed that surrogates do not take": ({"seed": 2**32}, "seed: out-of-range"),
    "an end that is not a number": (
        {"factors/slope/range": [10.0, float("nan")]},
        "factors.slope.range.1: out-of-range",
    ),
    "an endless range": (
        {"factors/slope/range": [10.0, float("inf")]},
        "factors.slope.range.1: out-of-range",
    ),
    "a range with one end": ({"factors/slope/range": [10.0]}, "factors.slope.range: wrong-type"),
    "no factors": ({"factors": {}}, "factors: wrong-type"),
    "a misspelt key": ({"plan/run": 7}, "plan.run: unknown-key"),
    "a misspelt table": ({"respones": {}}, "respones: unknown-key"),
    "a key of the study in a table": (
        {"responses/speed/goals": ["maximise speed"]},
        "responses.speed.goals: unknown-key",
    ),
    "a key of the study among formulas": ({"set/hours": 0.3}, "set.hours: unknown-key"),
    "a key of the study that is nearly one of the table": (
        {"plan/level": "draft"},
        "plan.level: unknown-key",
    ),
    "an unknown kind of plan": ({"plan/kind": "box-benken"}, "plan.kind: unknown-name"),
    "an unknown surrogate": ({"search/surrogate": "quadratics"}, "search.surrogate: unknown-name"),
    "an unknown optimiser": ({"search/optimiser": "wale"}, "search.optimiser: unknown-name"),
    "a factor that no formula uses": (
        {
            "factors/speed": {"range": [1.0, 2.0]},
            "responses/speed": None,
            "responses/rate": {"result": "x.y"},
            "goals": ["maximise rate"],
        },
        "factors.speed: conflict",
    ),
    "a formula with a misspelt factor": (
        {"set/screen.inclination_deg": "slop"},
        "set.screen.inclination_deg: unknown-name",
    ),
    "a formula that is none": (
        {"set/screen.inclination_deg": "slope +"},
        "set.screen.inclination_deg: wrong-type",
    ),
    "two formulas for one value": ({"set/screen.stroke_m.0": "stroke"}, "set.screen.stroke_m.0: conflict"),
    "an override of what a formula sets": (
        {"overrides": ["screen.inclination_deg=20", "screen.x=1"]},
        "overrides.0: conflict",
    ),
    "an override at the cheap level of what a formula sets": (
        {
            "cheap": {"level": "draft", "runs": 4, "overrides": ["x=1", "frames.plate={}"]},
            "set/frames.plate.mass_kg": "slope",
        },
        "cheap.overrides.1: conflict",
    ),
    "a derived number from one below": (
        {"derived": {"half": "twice / 2", "twice": "2 * slope"}, "set/screen.x": "half"},
        "derived.half: unknown-name",
    ),
    "an unknown result": (
        {"responses/share": {"result": "eficiency"}},
        "responses.share.result: unknown-name",
    ),
    "a goal of nothing": ({"goals": ["maximise sped"]}, "goals.0: unknown-name"),
    "a goal in other words": ({"goals": ["as fast as possible"]}, "goals.0: wrong-type"),
    "three goals": (
        {"goals": ["maximise speed", "maximise share", "minimise speed"], "limits": []},
        "goals: conflict",
    ),
    "goals that contradict each other": (
        {"goals": ["maximise speed", "minimise speed"], "limits": []},
        "goals: conflict",
    ),
    "a goal twice": ({"goals": ["maximise speed", "maximize speed"], "limits": []}, "goals: conflict"),
    "a factorial that nobody runs": (
        {"plan/kind": "factorial", "plan/levels": 1000},
        "plan.levels: out-of-range",
    ),
    "a goal that has a limit": ({"limits": ["speed >= 1"]}, "goals: conflict"),
    "a limit of nothing": ({"limits": ["shar >= 60"]}, "limits.0: unknown-name"),
    "a limit without a number": ({"limits": ["share >= much"]}, "limits.0: wrong-type"),
    "an endless limit": ({"limits": ["share >= inf"]}, "limits.0: wrong-type"),
    "a limit beyond the whole": (
        {"limits": ["share >= 120"], "responses/share/scale": "percent"},
        "limits.0: out-of-range",
    ),
    "a limit that no logarithm has": (
        {"limits": ["share >= -1"], "responses/share/scale": "logarithm"},
        "limits.0: out-of-range",
    ),
    "two limits of several values": ({"limits": ["share >= 50, 60", "share <= 80, 90"]}, "limits: conflict"),
    "nothing to search for": ({"goals": [], "limits": []}, "goals: conflict"),
    "orders that contradict each other": (
        {"ordered": [["slope", "stroke"], ["stroke", "slope"]], "factors/stroke/range": [10.0, 30.0]},
        "ordered.1: conflict",
    ),
    "ordered factors of two ranges": ({"ordered": [["slope", "stroke"]]}, "ordered.0: conflict"),
    "an order of an unknown factor": ({"ordered": [["slope", "strok"]]}, "ordered.0: unknown-name"),
    "a derived number with the name of a constant": ({"derived": {"pi": "3"}}, "derived.pi: conflict"),
    "a simpler design with an unknown factor": (
        {"simpler": {"stroke": "slop"}},
        "simpler.stroke: unknown-name",
    ),
    "a Box-Behnken plan of two factors": ({"plan/kind": "box-behnken"}, "plan.kind: conflict"),
    "neither a case nor a table": ({"case": None}, "case: conflict"),
    "a case and a table": ({"table": "x.csv"}, "case: conflict"),
    "a case that nothing changes": ({"set": {}}, "set: conflict"),
    "a probability above one": ({"confidence": 90.0}, "confidence: out-of-range"),
    "a certainty that nothing has": ({"confidence": 1.0}, "confidence: out-of-range"),
    "limits that are rather to be broken": ({"confidence": 0.4}, "confidence: out-of-range"),
    "no time": ({"hours": 0.0}, "hours: out-of-range"),
    "text for a number": ({"hours": "ten"}, "hours: wrong-type"),
    "a response and a factor of one name": (
        {"factors/share": {"range": [1.0, 2.0]}, "set/screen.x": "share"},
        "responses.share: conflict",
    ),
    "a factor with the name of a column": (
        {"factors/seed": {"range": [1.0, 2.0]}, "set/screen.x": "seed"},
        "factors.seed: conflict",
    ),
    "a factor with the name of a constant": (
        {"factors/pi": {"range": [1.0, 2.0]}, "set/screen.x": "pi"},
        "factors.pi: conflict",
    ),
    "a printed result of an unknown response": (
        {"published": [{"source": "a", "response": "sped", "table": "a.csv"}]},
        "published.0.response: unknown-name",
    ),
}


@pytest.mark.parametrize(("changes", "kind"), WRONG.values(), ids=list(WRONG))
def test_one_message_names_file_key_and_value_of(changes: dict[str, Any], kind: str, tmp_path: Path) -> None:
    """The words stand in tests/words."""
    file = write_study(tmp_path, **changes)
    with pytest.raises(CaseError) as refused:
        read_study(file)
    assert keys_and_kinds(refused.value.problems) == [kind]
    assert refused.value.problems[0].file == str(file)


def test_eight_factors_are_too_many_for_a_box_behnken_plan(tmp_path: Path) -> None:
    names = [f"f{number}" for number in range(8)]
    changes = {
        "factors": {name: {"range": [0.0, 1.0]} for name in names},
        "set": {f"screen.{name}": name for name in names},
        "plan/kind": "box-behnken",
    }
    with pytest.raises(CaseError) as refused:
        read_study(write_study(tmp_path, **changes))
    assert keys_and_kinds(refused.value.problems) == ["plan.kind: conflict"]


def test_all_mistakes_stand_in_one_message(tmp_path: Path) -> None:
    """Two of pydantic's at once; three of our own at once."""
    message = complaint(write_study(tmp_path, **{"hours": -1.0, "plan/rums": 4}))
    assert message.startswith("2 problems")
    changes = {"factors/slope/range": [3.0, 1.0], "goals": ["maximise sped"], "limits": ["shar >= 1"]}
    message = complaint(write_study(tmp_path, **changes))
    assert message.startswith("3 problems in the study:")
    assert all(word in message for word in ("factors.slope.range", "goals.0", "limits.0"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("title = 'x'\ntitle = 'y'\n", "line 2"),
        ('[set]\n"a.b" = "x"\n"a.b" = "y"\n', "line 3"),
        ("factors = [", "study.toml"),
        ("", "factors: missing"),
    ],
    ids=["a key twice", "two formulas for one key", "half a file", "nothing"],
)
def test_a_file_that_is_no_toml_is_told(text: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text(text)
    message = complaint(file)
    assert str(file) in message
    assert words in message


def test_a_missing_file_is_told(tmp_path: Path) -> None:
    assert "study.toml" in complaint(tmp_path)
    assert "night.toml" in complaint(tmp_path / "night.toml")


@pytest.mark.parametrize(
    ("result", "unit"),
    [
        ("rms_g", "g"),
        ("results.x.rms_g", "g"),
        ("efficiency", "percent"),
        ("results.bed.load_kg_per_m2", "kg / m²"),
        ("results.x.angle_deg", "deg"),
        ("results.x.angle_deg", "°"),
        ("results.x.torque_N_m", "N·m"),
        ("results.x.wear_m3_per_N_m", "m^3/(N m)"),
        ("results.x.particles", "particles"),
    ],
)
def test_the_unit_of_a_result_may_be_written_otherwise(result: str, unit: str, tmp_path: Path) -> None:
    assert belt(tmp_path, **{"responses/speed": {"result": result, "unit": unit}})


def test_the_file_of_the_page_is_the_study_that_it_names(tmp_path: Path) -> None:
    file = tmp_path / "study.toml"
    file.write_text("".join(code_on("how-to/run-a-design-study.md", "toml")[:-1]))  # the last has a table
    shipped = Path(__file__).parents[2] / "cases/ffs0827-effects/studies/slope-and-stroke.toml"
    assert read_study(file).file == read_study(shipped).file


def test_one_factor_is_enough(tmp_path: Path) -> None:
    study = belt(tmp_path, **{"factors/stroke": None, "set/screen.stroke_m": None})
    assert study.space.factors == 1
    assert [corner.tolist() for corner in study.corners()] == [[-1.0], [1.0]]


def test_formulas_become_values_of_the_cases_keys(tmp_path: Path) -> None:
    changes = {
        "derived": {"steep": "radians(slope)", "double": "2 * steep"},
        "set/screen.line": ["0", "double / pi", "-stroke"],
        "overrides": ["output.pictures=false"],
    }
    study = belt(tmp_path, **changes)
    at = study.overlays({"slope": 10.0, "stroke": 6.0})
    assert at[:3] == ["output.pictures=false", "screen.inclination_deg=10.0", "screen.stroke_m=0.006"]
    assert at[3] == f"screen.line={[0.0, 2 * math.radians(10.0) / math.pi, -6.0]}"


def test_a_limit_of_several_values_makes_an_aim_of_each(tmp_path: Path) -> None:
    study = belt(tmp_path, limits=["share >= 50, 60, 70"])
    assert list(study.aims) == ["share >= 50", "share >= 60", "share >= 70"]
    assert [aim.limits[0].value for aim in study.aims.values()] == [50.0, 60.0, 70.0]


def test_a_limit_is_kept_on_the_scale_of_its_response(tmp_path: Path) -> None:
    study = belt(tmp_path, **{"limits": ["share<=80"], "responses/share/scale": "percent"})
    (limit,) = study.aim.limits
    assert limit.sign == -1.0
    assert limit.value == pytest.approx(np.log(80 / 20))


def test_corners_of_ordered_factors_are_ordered(tmp_path: Path) -> None:
    changes = {"factors/stroke/range": [10.0, 30.0], "ordered": [["slope", "stroke"]]}
    corners = [tuple(corner) for corner in belt(tmp_path, **changes).corners()]
    assert sorted(corners) == [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0)]


def test_of_many_corners_a_spread_choice_is_checked(tmp_path: Path) -> None:
    names = [f"f{number}" for number in range(9)]
    changes = {
        "factors": {name: {"range": [0.0, 1.0]} for name in names},
        "set": {f"screen.{name}": name for name in names},
    }
    corners = np.array(list(belt(tmp_path, **changes).corners()))
    assert corners.shape == (64, 9)
    assert (np.abs(corners) == 1.0).all()
    assert {tuple(corners[0]), tuple(corners[-1])} == {(-1.0,) * 9, (1.0,) * 9}
