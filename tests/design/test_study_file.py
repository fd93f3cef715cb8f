"""Mistakes of a study are told at once: file, key, value and the nearest right key."""

from __future__ import annotations

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


WRONG: dict[str, tuple[dict[str, Any], list[str]]] = {
    "another unit than that of a result": (
        {"responses/speed": {"result": "stroke", "unit": "mm"}},
        ['responses.speed.unit: "mm" is not the unit of stroke, which is in m; nothing is converted'],
    ),
    "another unit than that of a path": (
        {"responses/speed": {"result": "results.motion.ground.amplitude_N.z", "unit": "kN"}},
        ['"kN" is not the unit of results.motion.ground.amplitude_N.z, which is in N'],
    ),
    "a power in percents": (
        {"responses/speed": {"result": "power", "unit": "W", "scale": "percent"}},
        ["responses.speed.scale: power is in W, and the scale is of percents"],
    ),
    "a range that is turned round": (
        {"factors/slope/range": [30.0, 10.0]},
        ["factors.slope.range: 30 is not below 10"],
    ),
    "a range of no width": (
        {"factors/slope/range": [20.0, 20.0]},
        ["factors.slope.range: 20 is not below 20"],
    ),
    "a range of rounding": (
        {"factors/slope/range": [1.0, 1.0000000000000002]},
        ["factors.slope.range: 1.0 to 1.0000000000000002 is no more than rounding"],
    ),
    "a seed that surrogates do not take": ({"seed": 2**32}, ["seed: 4294967296"]),
    "an end that is not a number": (
        {"factors/slope/range": [10.0, float("nan")]},
        ["factors.slope.range.1", "nan"],
    ),
    "an endless range": ({"factors/slope/range": [10.0, float("inf")]}, ["factors.slope.range.1", "inf"]),
    "a range with one end": ({"factors/slope/range": [10.0]}, ["factors.slope.range", "10.0"]),
    "no factors": ({"factors": {}}, ["factors: {}"]),
    "a misspelt key": ({"plan/run": 7}, ['plan.run: unknown key (its value: 7); did you mean "runs"?']),
    "a misspelt table": (
        {"respones": {}},
        ['respones: unknown key (its value: {}); did you mean "responses"'],
    ),
    "a key of the study in a table": (
        {"responses/speed/goals": ["maximise speed"]},
        ["responses.speed.goals: unknown key", "a key of the whole study belongs before the first [table]"],
    ),
    "a key of the study among formulas": (
        {"set/hours": 0.3},
        ["set.hours: is no key of a case; a key of the whole study belongs before the first [table]"],
    ),
    "a key of the study that is nearly one of the table": (
        {"plan/level": "draft"},
        ["plan.level: unknown key", 'belongs before the first [table]; or did you mean "levels"?'],
    ),
    "an unknown kind of plan": (
        {"plan/kind": "box-benken"},
        ["plan.kind: 'box-benken'", 'did you mean "box-behnken"?'],
    ),
    "an unknown surrogate": (
        {"search/surrogate": "quadratics"},
        ['search.surrogate: no surrogate "quadratics"; did you mean "quadratic"?'],
    ),
    "an unknown optimiser": ({"search/optimiser": "wale"}, ['"wale"; did you mean "whale"?']),
    "a factor that no formula uses": (
        {
            "factors/speed": {"range": [1.0, 2.0]},
            "responses/speed": None,
            "responses/rate": {"result": "x.y"},
            "goals": ["maximise rate"],
        },
        ["factors.speed: no formula of [set] uses it"],
    ),
    "a formula with a misspelt factor": (
        {"set/screen.inclination_deg": "slop"},
        ['set.screen.inclination_deg: no factor "slop"; did you mean "slope"?'],
    ),
    "a formula that is none": ({"set/screen.inclination_deg": "slope +"}, ['"slope +" is no arithmetic']),
    "two formulas for one value": (
        {"set/screen.stroke_m.0": "stroke"},
        ["set.screen.stroke_m.0: screen.stroke_m is set by a formula of its own, too"],
    ),
    "an override of what a formula sets": (
        {"overrides": ["screen.inclination_deg=20", "screen.x=1"]},
        ["overrides.0: screen.inclination_deg is set by a formula, too"],
    ),
    "an override at the cheap level of what a formula sets": (
        {
            "cheap": {"level": "draft", "runs": 4, "overrides": ["x=1", "frames.plate={}"]},
            "set/frames.plate.mass_kg": "slope",
        },
        ["cheap.overrides.1: frames.plate.mass_kg is set by a formula, too"],
    ),
    "a derived number from one below": (
        {"derived": {"half": "twice / 2", "twice": "2 * slope"}, "set/screen.x": "half"},
        ['derived.half: no factor or number above is called "twice"'],
    ),
    "an unknown result": (
        {"responses/share": {"result": "eficiency"}},
        ["responses.share.result", '"eficiency"', 'did you mean "efficiency"?'],
    ),
    "a goal of nothing": (
        {"goals": ["maximise sped"]},
        ['goals.0: no response "sped"; did you mean "speed"?'],
    ),
    "a goal in other words": (
        {"goals": ["as fast as possible"]},
        ['goals.0: "as fast as possible" is no goal', '"maximise RESPONSE"'],
    ),
    "three goals": (
        {"goals": ["maximise speed", "maximise share", "minimise speed"], "limits": []},
        ["goals: more than two goals; make some of them limits"],
    ),
    "goals that contradict each other": (
        {"goals": ["maximise speed", "minimise speed"], "limits": []},
        ["goals: two goals for one response; leave one of them out"],
    ),
    "a goal twice": (
        {"goals": ["maximise speed", "maximize speed"], "limits": []},
        ["goals: two goals for one response"],
    ),
    "a factorial that nobody runs": (
        {"plan/kind": "factorial", "plan/levels": 1000},
        ["plan.levels: 1000 values of each of 2 factors make 1000000 runs; a factorial has 10000 at most"],
    ),
    "a goal that has a limit": ({"limits": ["speed >= 1"]}, ["goals: a response is a goal and has a limit"]),
    "a limit of nothing": (
        {"limits": ["shar >= 60"]},
        ['limits.0: no response "shar"; did you mean "share"?'],
    ),
    "a limit without a number": ({"limits": ["share >= much"]}, ['limits.0: "share >= much" is no limit']),
    "an endless limit": ({"limits": ["share >= inf"]}, ['limits.0: "share >= inf" is no limit']),
    "a limit beyond the whole": (
        {"limits": ["share >= 120"], "responses/share/scale": "percent"},
        ["limits.0: 120 is impossible: the scale of share is percent, between 0 and 100"],
    ),
    "a limit that no logarithm has": (
        {"limits": ["share >= -1"], "responses/share/scale": "logarithm"},
        ["limits.0: -1 is impossible: the scale of share is logarithm, above 0"],
    ),
    "two limits of several values": (
        {"limits": ["share >= 50, 60", "share <= 80, 90"]},
        ["limits: more than one limit has several values"],
    ),
    "nothing to search for": ({"goals": [], "limits": []}, ["goals: nothing to search for"]),
    "orders that contradict each other": (
        {"ordered": [["slope", "stroke"], ["stroke", "slope"]], "factors/stroke/range": [10.0, 30.0]},
        ["ordered.1: a factor stands in it twice, or in another chain"],
    ),
    "ordered factors of two ranges": (
        {"ordered": [["slope", "stroke"]]},
        ["ordered.0: ordered factors must have one range"],
    ),
    "an order of an unknown factor": (
        {"ordered": [["slope", "strok"]]},
        ['ordered.0: no factor "strok"; did you mean "stroke"?'],
    ),
    "a derived number with the name of a constant": (
        {"derived": {"pi": "3"}},
        ["derived.pi: pi is a constant of formulas"],
    ),
    "a simpler design with an unknown factor": (
        {"simpler": {"stroke": "slop"}},
        ['simpler.stroke: "slop" is no factor of the simpler design', "slope"],
    ),
    "a Box-Behnken plan of two factors": (
        {"plan/kind": "box-behnken"},
        ["plan.kind: a Box-Behnken design has 3 to 7 factors, not 2; sobol has any"],
    ),
    "neither a case nor a table": ({"case": None}, ["case: one of case and table is wanted"]),
    "a case and a table": ({"table": "x.csv"}, ["case: one of case and table is wanted"]),
    "a case that nothing changes": ({"set": {}}, ["set: no key of the case depends on a factor"]),
    "a probability above one": ({"confidence": 90.0}, ["confidence: 90.0", "1"]),
    "a certainty that nothing has": ({"confidence": 1.0}, ["confidence: 1.0", "less than 1"]),
    "limits that are rather to be broken": ({"confidence": 0.4}, ["confidence: 0.4", "0.5"]),
    "no time": ({"hours": 0.0}, ["hours: 0.0"]),
    "text for a number": ({"hours": "ten"}, ["hours: 'ten'"]),
    "a response and a factor of one name": (
        {"factors/share": {"range": [1.0, 2.0]}, "set/screen.x": "share"},
        ["responses.share: a factor has this name, too"],
    ),
    "a factor with the name of a column": (
        {"factors/seed": {"range": [1.0, 2.0]}, "set/screen.x": "seed"},
        ["factors.seed: points.csv has another column of this name"],
    ),
    "a factor with the name of a constant": (
        {"factors/pi": {"range": [1.0, 2.0]}, "set/screen.x": "pi"},
        ["factors.pi: pi is a constant of formulas"],
    ),
    "a printed result of an unknown response": (
        {"published": [{"source": "a", "response": "sped", "table": "a.csv"}]},
        ['published.0.response: no response "sped"; did you mean "speed"?'],
    ),
}


@pytest.mark.parametrize(("changes", "words"), WRONG.values(), ids=list(WRONG))
def test_one_message_names_file_key_and_value_of(
    changes: dict[str, Any], words: list[str], tmp_path: Path
) -> None:
    file = write_study(tmp_path, **changes)
    message = complaint(file)
    for each in [str(file), *words]:
        assert each in message
    assert message.count("\n") == 1, message


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
    assert at[3] == f"screen.line={[0.0, 2 * np.radians(10.0) / np.pi, -6.0]}"


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
