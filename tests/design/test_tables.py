"""The files of a study: their columns, and that they follow from the runs alone."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from orchestrator.studies.design.campaign import Campaign
from orchestrator.studies.design.findings import Findings
from orchestrator.studies.design.page import doubts, write_study_page
from orchestrator.studies.design.pictures import draw_all
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.design.tables import write_tables
from orchestrator.studies.design.trials import Outcome
from orchestrator.views.style import data_uri
from tests.design.campaigns import NoisyFunction, belt, run_all

PICTURES = ["trade_off", "effects", "surface", "sensitivity", "parity", "progress"]


def write(whole: Campaign, folder: Path) -> Path:
    """Write everything that follows from the outcomes of a study."""
    findings = Findings(whole)
    list(write_tables(findings, folder))
    write_study_page(findings, draw_all(findings, folder), folder)
    return folder


def jams(x: dict[str, float]) -> str:
    """Fail at one end of the space, for a reason that a page must escape."""
    return "jams at <2 mm>" if x["slope"] > 27 and x["stroke"] < 4 else ""


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    """A study with two best settings and a simpler design, one run of which failed."""
    folder = tmp_path_factory.mktemp("study")
    changes = {
        "limits": ["share >= 50, 65"],
        "simpler": {"stroke": "slope / 5"},
        "plan/runs": 12,
        "responses/share/scale": "percent",
    }
    whole = run_all(belt(folder, **changes), folder, failing=jams)
    assert any(not each.is_data for each in whole.outcomes)
    return whole


@pytest.fixture(scope="module")
def written(whole: Campaign, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the study."""
    return write(whole, tmp_path_factory.mktemp("all") / "written")


def rows_of(file: Path) -> list[dict[str, str]]:
    """Read a table."""
    return list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))


def test_points_have_a_row_for_each_trial_and_a_column_for_all_that_is_known(
    written: Path, whole: Campaign
) -> None:
    rows = rows_of(written / "points.csv")
    assert list(rows[0]) == [
        *["trial", "stage", "role", "seed", "slope", "stroke", "status", "why_no_data", "not_steady"],
        "particle_steps",
        *["speed", "speed deviation", "share", "share deviation"],
        *["speed predicted", "speed predicted half width", "share predicted", "share predicted half width"],
    ]
    assert [int(row["trial"]) for row in rows] == list(range(1, len(whole.outcomes) + 1))
    for row, outcome in zip(rows, whole.outcomes, strict=True):
        assert {name: float(row[name]) for name in ("slope", "stroke")} == outcome.trial.values
        assert row["why_no_data"] == outcome.why
        if outcome.is_data:
            assert float(row["speed"]) == outcome.responses["speed"].value
            assert float(row["speed deviation"]) == pytest.approx(0.01 * whole.data().widened[0])
            assert float(row["share deviation"]) == pytest.approx(0.5 * whole.data().widened[1])
        else:
            assert not row["speed"]
            assert not row["speed deviation"]
        if outcome.trial.stage in ("centre", "plan"):
            assert not row["speed predicted"]
        else:
            mean, deviation, *_ = outcome.trial.predicted["speed"]
            assert float(row["speed predicted"]) == pytest.approx(mean)
            assert float(row["speed predicted half width"]) == pytest.approx(1.96 * deviation)


def test_runs_that_did_not_become_steady_are_counted_on_the_page_and_named(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path, **{"search/runs": 0, "goals": [], "limits": []}), tmp_path)
    assert not list(doubts(Findings(whole)))
    whole.outcomes[3:5] = [replace(each, not_steady="the deck fills") for each in whole.outcomes[3:5]]
    folder = write(whole, tmp_path / "out")
    text = "2 of the 9 runs that are data did not become steady (0004, 0005;"
    assert text in (folder / "design.html").read_text(encoding="utf-8")
    assert next(doubts(Findings(whole))).startswith(text)
    named = [row["trial"] for row in rows_of(folder / "points.csv") if row["not_steady"] == "the deck fills"]
    assert named == ["4", "5"]


def test_points_are_the_same_in_both_formats(written: Path) -> None:
    columns = pd.read_parquet(written / "points.parquet")
    text = pd.read_csv(written / "points.csv", keep_default_na=False, na_values={"speed": "", "share": ""})
    assert list(columns) == list(text)
    assert columns["speed"].to_numpy() == pytest.approx(text["speed"].to_numpy(), nan_ok=True)
    assert columns["trial"].dtype == np.int64


def test_the_best_settings_stand_beside_their_rivals_and_the_centre(written: Path, whole: Campaign) -> None:
    rows = rows_of(written / "best.csv")
    limits = ["share >= 50", "share >= 65"]
    assert {row["role"] for row in rows} == {
        "centre",
        *(f"{kind}, {limit}" for kind in ("best", "simpler") for limit in limits),
    }
    for row in rows:
        assert row["verdict"] == "as predicted"
        assert int(row["runs"]) >= 2
        assert abs(float(row["speed"]) - float(row["speed predicted"])) < 0.1


def test_the_fit_says_how_far_each_surrogate_is_to_be_trusted(written: Path) -> None:
    fit = json.loads((written / "fit.json").read_text())
    assert set(fit["surrogates"]) == {"quadratic", "gaussian-process", "network"}
    assert fit["surrogates"]["quadratic"]["speed"]["explained"] > 0.9
    assert fit["why_no_optimum"] == {}
    terms = {row["term"]: row for row in fit["quadratic"]["speed"]["anova"]}
    assert terms["slope"]["coefficient"] == pytest.approx(0.7, abs=0.05)
    assert terms["slope*stroke"]["coefficient_in_units"] == pytest.approx(0.05 / 20, abs=0.001)
    assert fit["sobol"]["speed"]["first"]["slope"] > 0.8


def test_the_resolved_study_can_be_read_again(written: Path, whole: Campaign) -> None:
    """The resolved study in its new place names the same case."""
    again = read_study(written / "study.toml")
    assert again.path(again.file.case) == whole.study.path(whole.study.file.case)
    assert again.file.model_copy(update={"case": "."}) == whole.study.file


def test_everything_but_the_runs_follows_from_the_runs_byte_for_byte(written: Path, whole: Campaign) -> None:
    """Outcomes that come in another order make the same files, too."""
    again = Campaign(whole.study, NoisyFunction(whole.study), whole.journal)
    again.read_trials()
    again.outcomes = whole.outcomes[::-1]
    other = write(again, written.with_name("again"))
    names = {file.name for file in written.iterdir()}
    assert names == {file.name for file in other.iterdir()}
    assert {"points.csv", "points.parquet", "design.html", "fit.json", "best.csv", "front.csv"} <= names
    differing = [name for name in names if (written / name).read_bytes() != (other / name).read_bytes()]
    assert not differing


def test_a_level_that_is_recommended_no_more_does_not_stay(written: Path, whole: Campaign) -> None:
    for name in ("recommended.toml", "recommended-2.toml"):
        (written / name).write_text("of an earlier call")
    write(whole, written)
    assert not list(written.glob("recommended*"))


def test_the_page_has_every_picture_and_needs_nothing_from_elsewhere(written: Path) -> None:
    page = (written / "design.html").read_text(encoding="utf-8")
    for name in PICTURES:
        picture = (written / f"{name}.png").read_bytes()
        assert data_uri(picture, "image/png") in page, name
    assert page.count("<img ") == len(PICTURES)
    without_pictures = re.sub(r"data:image/png;base64,[A-Za-z0-9+/=]+", "data:", page)
    links = re.findall(r"(?:src|href)\s*=\s*[\"']([^\"']*)", without_pictures)
    assert all(link.startswith("data:") for link in links)
    assert "http" not in without_pictures
    assert "url(" not in without_pictures


def test_the_page_answers_first_and_tells_what_failed(written: Path) -> None:
    page = (written / "design.html").read_text(encoding="utf-8")
    first = page.index('<p class="answer">')
    assert 0 < first < page.index("All of it holds for the case") < page.index("<h2>")
    assert page.count('<p class="answer">') == 2
    assert "Runs that are no data" in page
    assert "jams at &lt;2 mm&gt;" in page
    assert "<2 mm>" not in page


@pytest.mark.parametrize("runs", [1, 3, 5])
def test_a_study_with_few_runs_is_written_too(runs: int, tmp_path: Path) -> None:
    study = belt(tmp_path)
    first: list[Outcome] = run_all(study, tmp_path).outcomes[:runs]
    few = Campaign(study, NoisyFunction(study), run_all(study, tmp_path).journal, first)
    few.read_trials()
    folder = write(few, tmp_path / "few")
    assert len(rows_of(folder / "points.csv")) == runs
    assert "support no optimum" in (folder / "design.html").read_text(encoding="utf-8")
