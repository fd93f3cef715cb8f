"""The data that a study takes from the run of a trial, and those that it does not take."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from orchestrator.case.file.folder import FolderUnusable
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.output.records.summary import SUMMARY_FORMAT
from orchestrator.output.results import run_reader
from orchestrator.studies.design.runs import Runs
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.design.trials import Trial
from orchestrator.studies.points import CaseStudy, Crew
from tests.design.plates import CASE, write_plates


def outcome_of(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    replaced: str,
    summary: dict[str, Any],
    *others: tuple[str, str],
) -> Any:
    """Return the outcome of a trial of the plates whose run has a summary."""
    study = read_study(write_plates(folder, *(others or [('unit = "m/s"', replaced)])))
    monkeypatch.setattr(run_reader, "summary_of", lambda run: {"status": "done", **summary})
    runs = Runs(study, CaseStudy(CASE, None, (), folder / "runs", Crew()))
    return next(
        iter(runs.finished([Trial(1, "plan", (0.0, 0.0), 0, values={"amplitude": 8.0, "rate": 70.0})]))
    )


PROBES = {"probes": {"plate": {"peak_speed_m_per_s": 0.5, "half_range_m": [0.008, 0.0, 0.0]}}}


@pytest.mark.parametrize("is_steady", [True, False])
def test_a_response_of_steady_runs_is_not_taken_from_another(
    is_steady: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    summary = PROBES | {"results": {"steady": {"is_steady": is_steady}}}
    asked = 'unit = "m/s"\nsteady = true'
    outcome = outcome_of(tmp_path, monkeypatch, asked, summary)
    assert set(outcome.responses) == ({"speed", "way"} if is_steady else {"way"})
    assert outcome.is_data


@pytest.mark.parametrize(
    ("result", "reasons"),
    [
        ("probes.plate.peak_speed_m_per_s", "the machine has not settled: a motor"),
        ("results.bed.velocity_m_per_s", "filling; the machine has not settled: a motor"),
        ("results.wear.panels.deck.worn_m3", "filling; the machine has not settled: a motor"),
    ],
)
def test_a_run_says_why_what_its_responses_depend_on_is_not_steady(
    result: str, reasons: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    results = {
        "steady": {"is_steady": False, "reason": "filling"},
        "motion": {"reason": "a motor"},
        "bed": {"velocity_m_per_s": 0.2},
        "wear": {"panels": {"deck": {"worn_m3": 1e-9}}},
    }
    path = ("probes.plate.peak_speed_m_per_s", result)
    no_unit = ('unit = "m/s"', "")
    outcome = outcome_of(tmp_path, monkeypatch, "", PROBES | {"results": results}, path, no_unit)
    assert outcome.not_steady == reasons
    assert outcome.is_data


def test_a_run_without_any_response_says_why(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    outcome = outcome_of(tmp_path, monkeypatch, 'unit = "m/s"\nsteady = true', {"results": {"steady": None}})
    assert (outcome.is_data, outcome.why) == (False, "the run did not become steady")
    outcome = outcome_of(tmp_path, monkeypatch, 'unit = "m/s"', {})
    assert outcome.why == "the run does not tell speed, way"


@pytest.mark.parametrize(
    ("scale", "value", "why"),
    [
        ("percent", 117.3, 'speed = 117.3 is not on the scale "percent"'),
        ("percent", 100.0, ""),
        ("logarithm", 0.0, 'speed = 0 is not on the scale "logarithm"'),
        ("plain", -3.0, ""),
    ],
)
def test_a_run_with_a_value_off_its_scale_is_no_data(
    scale: str, value: float, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = ('probes.plate.peak_speed_m_per_s"\nunit = "m/s"', f'extra.share"\nscale = "{scale}"')
    outcome = outcome_of(tmp_path, monkeypatch, "", {"extra": {"share": value}}, path)
    assert (outcome.why, outcome.is_data) == (why, not why)


@pytest.mark.parametrize(
    ("stated", "deviation"),
    [
        (
            {"half_width": 12.7, "standard_error": 1.0, "counting": 3.0},
            1.0,
        ),  # Student's quantile of 2 batches
        ({"half_width": 1.96}, 1.0),
        ({"half_width": None, "counting": 3.0}, 3.0),
        ({"half_width": None}, None),
    ],
)
def test_the_noise_of_a_run_is_its_standard_error(
    stated: dict[str, float], deviation: float | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    summary = {"probes": {"plate": {"peak_speed_m_per_s": {"value": 0.5, **stated}}}}
    outcome = outcome_of(tmp_path, monkeypatch, 'unit = "m/s"', summary)
    assert outcome.responses["speed"].deviation == deviation


@pytest.mark.parametrize("is_steady", [True, False])
def test_a_run_of_another_duration_is_data_where_only_steady_runs_are(
    is_steady: bool, tmp_path: Path
) -> None:
    """The run has another duration, and no other difference."""
    text = 'unit = "{}"' + "\nsteady = true" * is_steady
    changes = [(f'unit = "{unit}"\n', text.format(unit) + "\n") for unit in ("m/s", "m")]
    study = read_study(write_plates(tmp_path, *changes, ("duration_s=0.3", "duration_s=0.9")))
    runs = Runs(study, CaseStudy(CASE, None, (), tmp_path / "runs", Crew()))
    trial = Trial(1, "plan", (0.0, 0.0), 0, values={"amplitude": 8.0, "rate": 70.0})
    shorter = read_study(write_plates(tmp_path, ("duration_s=0.3", "duration_s=0.6")))
    stored = Runs(shorter, CaseStudy(CASE, None, (), tmp_path / "runs", Crew()))._point(trial)
    stored.folder.mkdir(parents=True)
    (stored.folder / "case.toml").write_text(tomli_w.dumps(resolved_case(stored.loaded.judged)))
    summary = {"format_version": SUMMARY_FORMAT, "status": "done"}
    (stored.folder / "summary.json").write_text(json.dumps(summary))
    if is_steady:
        assert [each.status for each in runs.finished([trial])] == ["done"]
    else:
        with pytest.raises(FolderUnusable, match="differs in duration_s"):
            runs.finished([trial])
