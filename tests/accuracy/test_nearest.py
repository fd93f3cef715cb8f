"""What a stored study says about the error of a run that is not in it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from orchestrator.cli.accuracy import look_up, study_command
from orchestrator.figures.accuracy import Accuracy, KnownError
from orchestrator.preflight.judge import load_judged
from orchestrator.studies.accuracy.nearest import accuracy_of
from orchestrator.studies.accuracy.stored import FORMAT
from orchestrator.workbench import Case
from tests.runs.outside import ROOT

BALL = ROOT / "cases/ball-on-panel"
SHORT = "duration_s=0.1"
HALF, FINE = "coupling.sync_interval_s=4e-05", "panel.cells=[44,1]"
NAME = "middle_rms_g"


def option(label: str, error: float, *sets: str) -> dict[str, Any]:
    return {"label": label, "sets": list(sets), "error": {NAME: error}, "ratio": {}}


def point(name: str, sets: str, error: float | None, kind: str = "parameter") -> dict[str, Any]:
    width = None if error is None else 0.003
    about = {"point": name, "kind": kind, "sets": sets, "status": "done", "deflection_m": 1e-3}
    return about | {f"{NAME}_error": error, f"{NAME}_error_half_width": width}


def table(case: Path = BALL, level: str = "draft", *sets: str) -> dict[str, Any]:
    """A study of two axes, whose reference is half the interval on the finer mesh."""
    judged = load_judged(case, level, sets)
    options = {
        "coupling": [option("own", 0.02), option("half", 0.0, HALF)],
        "panel": [option("22 cells", 0.04), option("44 cells", 0.0, FINE)],
    }
    points = [
        point("base", "", 0.05),
        point("half", HALF, 0.045),
        point("together", f"{HALF} '{FINE}'", None, "reference"),
    ]
    return {
        "format_version": FORMAT,
        "case": case.name,
        "level": level,
        "read": judged.origin.read(),
        "sets": list(sets),
        "left_out": sorted(judged.choice.left_out),
        "duration_s": 0.1,
        "judged_by": [NAME],
        "reference": "together",
        "reference_error": 0.01,
        "chance": 0.003,
        "remaining": {NAME: 0.01},
        "options": options,
        "points": points,
    }


def by_study(folder: Path, study: Any, *sets: str, case: Path = BALL) -> Accuracy:
    folder.mkdir(exist_ok=True)
    (folder / "accuracy.json").write_text(json.dumps(study))
    return accuracy_of(Case(load_judged(case, "draft", sets)), [folder / "accuracy.json"])


@pytest.mark.parametrize(
    ("sets", "error"),
    [
        ((), 0.06),  # 5 %, and 1 % that the reference is off itself
        (("duration_s=0.3", "output.interval_s=0.02", "monitor.long_steps='shorten'"), 0.06),
        ((HALF,), 0.055),
        (("coupling.sync_interval_s='0.04 ms'", "panel.solver=strip"), 0.055),
        ((FINE, HALF), 0.01),
    ],
    ids=["as it is", "observed otherwise", "half", "with units", "reference"],
)
def test_a_point_of_the_study_has_its_measured_error(
    tmp_path: Path, sets: tuple[str, ...], error: float
) -> None:
    accuracy = by_study(tmp_path, table(), *sets)
    assert (accuracy.basis, accuracy.study_s, accuracy.reference_error, accuracy.chance) == (
        "measured",
        0.1,
        0.01,
        0.003,
    )
    assert accuracy.errors == {NAME: KnownError(pytest.approx(error), 0.003, 0.01)}
    assert Accuracy.from_json(json.loads(json.dumps(accuracy.as_json()))) == accuracy


def test_options_that_were_measured_alone_add_up(tmp_path: Path) -> None:
    """4 % is the finer mesh's gain: 2 % of the own interval stay, and 1 % that the finest are off."""
    accuracy = by_study(tmp_path, table(), FINE)
    assert (accuracy.basis, accuracy.errors) == ("predicted", {NAME: KnownError(0.03, 0.003, 0.01)})
    study = table()
    study["points"].pop()  # the reference is another one
    study |= {"reference": "half"}
    both = by_study(tmp_path, study, FINE, HALF)
    assert (both.basis, both.errors[NAME].value) == ("predicted", pytest.approx(0.01))
    assert both.errors[NAME].half_width == pytest.approx(2**0.5 * 0.003)


@pytest.mark.parametrize(
    ("sets", "key"),
    [
        (("contacts.0.restitution=0.5",), "contacts.0.restitution"),
        (("gravity_m_per_s2=[0, 0, -9]",), "gravity_m_per_s2"),
        (("contacts.0.restitution=0.5", HALF), "contacts.0.restitution"),
        (("panel.cells=[30,1]",), "panel.cells"),
        (("panel.solver=rigid",), "panel.solver"),
        ((HALF, "particles.step_s=2e-5"), "particles.step_s"),
        (("exchange.panel_reaction=false",), "exchange"),
        (("output.cut_size_m=0.01",), "output.cut_size_m"),
        (("effects=['panel-deformation']",), "effects"),
    ],
)
def test_what_the_study_is_not_of_is_not_told(tmp_path: Path, sets: tuple[str, ...], key: str) -> None:
    accuracy = by_study(tmp_path, table(), *sets)
    assert (accuracy.basis, accuracy.errors) == ("not known", {})
    assert key in accuracy.why


def test_what_a_study_set_is_its_physics(tmp_path: Path) -> None:
    """A study with another restitution tells of runs with that one alone."""
    study = table(BALL, "draft", "contacts.0.restitution=0.5", SHORT)
    assert by_study(tmp_path, study, "contacts.0.restitution=0.50").basis == "measured"
    assert "contacts.0.restitution" in by_study(tmp_path, study).why


def test_a_case_that_was_edited_is_another_one(tmp_path: Path) -> None:
    case = shutil.copytree(BALL, tmp_path / BALL.name)
    study, file = table(case), case / "case.toml"
    assert by_study(tmp_path / "a", study, case=case).basis == "measured"
    file.write_text(file.read_text().replace('title = "One ball', 'title = "A ball'))
    assert by_study(tmp_path / "a", study, case=case).basis == "measured"
    file.write_text(file.read_text().replace("density_kg_per_m3 = 1430.0", "density_kg_per_m3 = 1300.0"))
    assert "materials.coal.density_kg_per_m3" in by_study(tmp_path / "a", study, case=case).why


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"left_out": None}, "effects"),  # of a version that did not tell
        ({"points": [{"point": "base", "sets": "", "status": "done"}]}, "nothing happened"),
        ({"options": {"coupling": []}}, "did not measure"),
        ({"points": []}, "no errors of these settings"),
        ({"points": 3}, "damaged"),
        ({"level": "fine"}, "no study of this case and level"),
        ({"format_version": 2}, "no study of this case and level"),
    ],
)
def test_a_study_that_cannot_tell_says_why(tmp_path: Path, change: dict[str, Any], why: str) -> None:
    accuracy = by_study(tmp_path, table() | change)
    assert (accuracy.basis, accuracy.errors) == ("not known", {})
    assert why in accuracy.why


def test_a_reference_of_unknown_error_is_said_to_be_one(tmp_path: Path) -> None:
    accuracy = by_study(tmp_path, table() | {"reference_error": None})
    assert (accuracy.reference_error, accuracy.errors) == (None, {NAME: KnownError(0.05, 0.003, None)})


def test_other_random_numbers_are_of_the_same_study(tmp_path: Path) -> None:
    case = ROOT / "cases/quickstart"
    study = table(case) | {"options": {}}
    assert by_study(tmp_path, study, "bed.blocks.coal.seed=77", case=case).basis == "measured"
    assert by_study(tmp_path, study, "bed.blocks.coal.count=77", case=case).basis == "not known"


def test_the_nearest_study_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The usual folder has a study of other physics; another folder has one of this."""
    monkeypatch.chdir(tmp_path)
    loaded = load_judged(BALL, "draft", [SHORT, FINE, "output.pictures=false"])
    nothing = look_up(loaded)
    command = f"flipflow study accuracy {BALL} --level draft --set '{FINE}'"
    assert (nothing.basis, nothing.command) == ("not known", command)
    for name, sets in (("ball-on-panel-accuracy", ("contacts.0.restitution=0.5",)), ("other", ())):
        (tmp_path / "runs" / name).mkdir(parents=True)
        (tmp_path / "runs" / name / "accuracy.json").write_text(json.dumps(table(BALL, "draft", *sets)))
    (tmp_path / "runs/none").mkdir()
    (tmp_path / "runs/none/accuracy.json").write_text("{")
    assert study_command(loaded) == f"{command} --out runs/ball-on-panel-accuracy-2"
    assert look_up(loaded).study == "runs/other/accuracy.json"
    (tmp_path / "runs/other/accuracy.json").unlink()
    assert look_up(loaded).study == "runs/ball-on-panel-accuracy/accuracy.json"
