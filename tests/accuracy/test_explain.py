"""The lines of ``flipflow explain`` that come from a study of accuracy."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from orchestrator.case.file.errors import CaseError
from orchestrator.cli.explain import measured_verdict
from orchestrator.cli.main import app
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.catalogue import judge_effects
from orchestrator.studies.accuracy.stored import FORMAT, StoredStudy, find_study
from orchestrator.workbench import Case
from tests.runs.outside import ROOT

CASE = ROOT / "cases/panel-cycle"
CALL = CliRunner()


def study(case: str = "panel-cycle", error: float = 0.03) -> dict[str, Any]:
    strip = {"axis": "panel", "variant": "strip", "label": "strip, 22 cells", "sets": ["panel.solver=strip"]}
    strip |= {"reference": "sheet", "processor_s": 2.0, "reference_processor_s": 5.0}
    strip |= {"error": {"deflection_m": error, "shape": 0.5, "middle_rms_g": error / 2}}
    sheet = strip | {"variant": "sheet", "label": "sheet", "processor_s": 5.0, "error": {}}
    read = load_judged(CASE, "draft").origin.read()
    about = {"format_version": FORMAT, "case": case, "level": "draft", "read": read, "sets": []}
    return about | {"models": [strip, sheet]}


@pytest.mark.parametrize(("error", "matters"), [(0.03, False), (0.3, True)])
def test_a_measured_model_decides_about_its_effect(error: float, matters: bool) -> None:
    """The verdict counts only what repeats itself: the shape's 50 % do not count."""
    verdicts = {
        name: judged.verdict for name, judged in judge_effects(load_judged(CASE, "draft").case).items()
    }
    there = StoredStudy(Path(), study(error=error))
    verdict = measured_verdict("variation-across", verdicts["variation-across"], there)
    assert (verdict.value, verdict.matters) == (error, matters)
    assert "5 s instead of 2 s" in verdict.cost
    there.table["models"][0]["half_width"] = {"deflection_m": 0.25, "middle_rms_g": 0.25}
    assert (
        measured_verdict("variation-across", verdicts["variation-across"], there)
        is verdicts["variation-across"]
    )
    there.table["models"][0]["half_width"] = {"deflection_m": None, "middle_rms_g": None}  # of one seed
    alone = measured_verdict("variation-across", verdicts["variation-across"], there)
    assert (alone.matters, alone.why) == (matters, f"{verdict.why}; how much of it is chance is not known")
    other = verdicts["panel-deformation"]
    assert measured_verdict("panel-deformation", other, there) is other


def test_a_study_is_of_one_case_and_level(tmp_path: Path) -> None:
    loaded, file = Case(load_judged(CASE, "draft")), tmp_path / "accuracy.json"
    file.write_text(json.dumps(study()))
    there = find_study(loaded, file)
    assert there is not None
    assert there.table == study()
    deep = "[" * 100_000
    for text, why in (
        (json.dumps(study("other")), "other"),
        ("[]", "is not a study"),
        (deep, "is not a study"),
    ):
        file.write_text(text)
        with pytest.raises(CaseError, match=why):
            find_study(loaded, file)


def test_explain_shows_it(tmp_path: Path) -> None:
    file = tmp_path / "accuracy.json"
    file.write_text(json.dumps(study()))
    done = CALL.invoke(app, ["explain", str(CASE), "--level", "draft", "--study", str(file)])
    assert done.exit_code == 0, done.output
    assert "measured:" in done.output
    assert "largest error" in done.output
    other = ["--set", "materials.PU.density_kg_per_m3=900", "--set", "duration_s=0.1"]
    done = CALL.invoke(app, ["explain", str(CASE), "--level", "draft", "--study", str(file), *other])
    text = "before changes in materials.PU.density_kg_per_m3=900"
    assert (done.exit_code, text in done.output, "largest error" in done.output) == (0, True, False)
    gone = CALL.invoke(app, ["explain", str(CASE), "--study", str(tmp_path / "none.json")])
    assert (gone.exit_code, "no such file" in gone.output) == (2, True)


def test_a_study_tells_what_has_changed_in_its_case(tmp_path: Path) -> None:
    folder = shutil.copytree(CASE, tmp_path / CASE.name)
    there = StoredStudy(Path(), study())
    assert there.changes(Case(load_judged(folder, "draft", ["duration_s=3"]))) == []
    file = folder / "levels/draft.toml"
    file.write_text(file.read_text() + "\n[monitor]\nlargest_overlap = 0.3\n")
    assert there.changes(Case(load_judged(folder, "draft"))) == ["monitor"]
