"""What ``flipflow explain`` takes from a ladder that was measured."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from orchestrator.case.file.errors import CaseError
from orchestrator.cli.main import app
from orchestrator.preflight.judgement.catalogue import judged
from orchestrator.preflight.levels import load
from orchestrator.studies.ladder.stored import measured, stored
from tests.runs.outside import ROOT

CASE = ROOT / "cases/panel-cycle"
CALL = CliRunner()


def ladder(case: str = "panel-cycle", error: float = 0.03) -> dict[str, Any]:
    strip = {"ladder": "panel", "rung": "strip", "reference": "sheet", "processor_s": 2.0}
    sheet = strip | {"rung": "sheet", "processor_s": 5.0, "error": {}}
    strip |= {"error": {"deflection_m": error, "shape": 0.5, "rms_g": error / 2}}
    return {"case": case, "level": "draft", "rungs": [strip, sheet]}


@pytest.mark.parametrize(("error", "matters"), [(0.03, False), (0.3, True)])
def test_a_measured_rung_decides_about_its_effect(error: float, matters: bool) -> None:
    """By what repeats itself: the shape's 50 % do not count."""
    verdicts = {one.effect: one.verdict for one in judged(load(CASE, "draft").case)["panels"]}
    found = measured("variation-across", verdicts["variation-across"], ladder(error=error))
    assert (found.value, found.matters) == (error, matters)
    assert "5 s instead of 2 s" in found.cost
    other = verdicts["panel-deformation"]
    assert measured("panel-deformation", other, ladder()) is other


def test_a_ladder_is_of_one_case_and_level(tmp_path: Path) -> None:
    loaded, file = load(CASE, "draft"), tmp_path / "ladder.json"
    assert stored(loaded, None) is None
    file.write_text(json.dumps(ladder()))
    assert stored(loaded, file) == ladder()
    for text, why in ((json.dumps(ladder("other")), "other"), ("[]", "is no ladder")):
        file.write_text(text)
        with pytest.raises(CaseError, match=why):
            stored(loaded, file)


def test_explain_shows_it(tmp_path: Path) -> None:
    file = tmp_path / "ladder.json"
    file.write_text(json.dumps(ladder()))
    done = CALL.invoke(app, ["explain", str(CASE), "--level", "draft", "--ladder", str(file)])
    assert done.exit_code == 0, done.output
    assert "measured:" in done.output
    assert "largest error" in done.output
    gone = CALL.invoke(app, ["explain", str(CASE), "--ladder", str(tmp_path / "none.json")])
    assert (gone.exit_code, "no such file" in gone.output) == (2, True)
