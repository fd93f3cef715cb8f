"""``python -m tools.effect_bank``: verdicts against runs with and without each effect."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from orchestrator.case.tables.case import Case
from orchestrator.output.records.summary import write_summary
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.catalogue import Judged
from orchestrator.preflight.judgement.pair import Change
from orchestrator.preflight.scene.effect import Verdict
from tests.runs.outside import ROOT
from tools.effect_bank import bank as banks
from tools.effect_bank import confusion, tables
from tools.effect_bank.__main__ import app
from tools.effect_bank.confusion import (
    BY_CHANCE,
    CANNOT_SAY,
    CHANGED,
    MATTERS,
    MAY_GO,
    NOT_COMPARED,
    NOT_RUN,
    UNCHANGED,
    Confusion,
    Row,
    change,
    outcome,
)
from tools.effect_bank.trials import Countdown

CALL = CliRunner()
CASES = ROOT / "cases"
SHIPPED = CASES / "effects.toml"
TINY = """
[scenes.slack]
why = "a slack panel: it bends"
case = "CASES/panel-cycle"
level = "draft"
sets = ["panel.cells=[4, 1]", "panel.surface_cells=[4, 2]"]
duration_s = 0.32
asked = ["middle_half_range"]
effects = ["panel-deformation"]

[scenes.high]
why = "a panel high above a beam"
case = "CASES/panel-cycle"
level = "draft"
sets = [
  "panel.cells=[4, 1]",
  "panel.surface_cells=[4, 2]",
  "screen.panels.deck.stops.beam={from_m=0.13, to_m=0.17, gap_m=0.12}",
]
duration_s = 0.32
asked = ["middle_half_range"]
effects = ["beam-contact"]
"""


def tiny_bank(folder: Path, text: str = TINY) -> Path:
    """A bank in a folder, of the shipped cases."""
    file = folder / "bank.toml"
    file.write_text(text.replace("CASES", str(CASES)))
    return file


def study(*words: object) -> Any:
    return CALL.invoke(app, [*map(str, words), "--jobs", "1"])


def turned_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Makes all effects say the opposite of what they say."""
    weighed = confusion.weigh_effects

    def opposite(judged: Judged) -> Judged:
        matters = None if judged.verdict.matters is None else not judged.verdict.matters
        return replace(judged, verdict=replace(judged.verdict, matters=matters, limit=None))

    def all_opposite(case: Case, asked: Sequence[str]) -> dict[str, Judged]:
        return {name: opposite(judged) for name, judged in weighed(case, asked=asked).items()}

    monkeypatch.setattr(confusion, "weigh_effects", all_opposite)


def test_two_scenes_are_run_once_and_a_verdict_turned_over_is_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bank, out = tiny_bank(tmp_path), tmp_path / "out"
    first = study(bank, "--out", out)
    assert first.exit_code == 0, first.output
    assert 'wrong "may be left out": 0; false alarms: 0 %' in first.output
    assert "slack-without-panel-deformation: done; 2 to go, about" in first.output
    with (out / "effects.csv").open(newline="") as text:
        rows = {row["scene"]: row for row in csv.DictReader(text)}
    assert (rows["slack"]["verdict"], rows["slack"]["outcome"]) == (MATTERS, CHANGED)
    assert (rows["high"]["verdict"], rows["high"]["outcome"]) == (MAY_GO, UNCHANGED)
    assert float(rows["slack"]["without"]) < 0.2 * float(rows["slack"]["with"])
    assert float(rows["high"]["change"]) < 0.1

    monkeypatch.setattr(
        "orchestrator.workbench.run.python", lambda *words, **more: pytest.fail("it was run again")
    )
    turned_over(monkeypatch)
    again = study(bank, "--out", out)
    assert again.exit_code == 4, again.output
    assert "wrong: slack: panel-deformation" in again.output
    assert "false alarm: high: beam-contact" in again.output
    assert 'wrong "may be left out": 1; false alarms: 100 %' in again.output
    assert "**WRONG**" in (out / "effects.md").read_text()


def test_dry_says_what_would_be_run_and_runs_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("orchestrator.workbench.run.python", lambda *words, **more: pytest.fail("it was run"))
    out = tmp_path / "out"
    result = study(tiny_bank(tmp_path), "--dry", "--out", out, "--scene", "high")
    assert result.exit_code == 0, result.output
    assert "high: a panel high above a beam" in result.output
    assert "slack" not in result.output
    assert "without beam-contact: 1 to be run, about" in result.output
    assert "in all 2 runs, about" in result.output
    assert not out.exists()


@pytest.mark.parametrize(
    ("instead", "words", "message"),
    [
        ('["midle_half_range"]', (), 'no result "midle_half_range"; did you mean "middle_half_range"'),
        ('["middle_half_range"]', ("--scene", "hihg"), 'no scene "hihg"; did you mean "high"'),
    ],
)
def test_a_bank_with_mistakes_is_refused(
    tmp_path: Path, instead: str, words: tuple[str, ...], message: str
) -> None:
    bank = tiny_bank(tmp_path, TINY.replace('["middle_half_range"]', instead))
    result = study(bank, *words, "--dry")
    assert result.exit_code == 2
    assert message in result.output


def test_mistakes_of_all_scenes_are_said_with_their_names(tmp_path: Path) -> None:
    bank = tiny_bank(tmp_path, TINY.replace("cells=[4, 1]", "cells=[4.5, 1]"))
    result = study(bank, "--dry")
    assert result.exit_code == 2
    assert "scene slack, --set" in result.output
    assert "scene high, --set" in result.output
    missing = study(tmp_path / "none.toml", "--dry")
    assert missing.exit_code == 2
    assert "there is no bank of scenes" in missing.output


def test_the_shipped_bank_has_every_shipped_case() -> None:
    bank = banks.read(SHIPPED)
    assert len(bank) >= 24
    cases = {file.parent.name for file in CASES.glob("*/case.toml")}
    assert cases <= {scene.case for scene in bank.values()}


def test_without_an_effect_the_others_stay(tmp_path: Path) -> None:
    """The runs differ in what the effect is made of, and in nothing else."""
    from tools.effect_bank.trials import try_scene

    scene = banks.read(tiny_bank(tmp_path))["high"]
    scene = scene.model_copy(update={"effects": ()})
    tried = try_scene("high", scene, tmp_path, tmp_path / "out")
    kinds = {trial.without: trial.runs[0].loaded.tables for trial in tried.trials}
    assert kinds[""].panel.solver == "strip"
    assert kinds[""].materials["PU"].hyperelastic.maxwell
    assert kinds["panel-deformation"].panel.solver == "rigid"
    assert not kinds["panel-damping"].materials["PU"].hyperelastic.maxwell
    assert kinds["panel-damping"].panel == kinds[""].panel
    assert kinds["run-up"].screen.frames["moving"].drive.run_up_s == 0.0
    assert load_judged(CASES / "panel-cycle", "draft").case.screen.frames["moving"].drive.run_up_s > 0


def summary(value: float | None, half_width: float | None = None) -> dict[str, Any]:
    return {"results": {"bed": {"velocity_m_per_s": {"value": value, "half_width": half_width}}}}


def test_the_interval_of_a_run_counts_where_chance_is_at_work() -> None:
    first, second = [summary(1.0, 0.3)], [summary(1.2, 0.4)]
    assert change("velocity", first, second, by_chance=True) == Change(1.0, 1.2, pytest.approx(0.2), 0.5)
    assert change("velocity", first, second, by_chance=False).uncertain is None


@pytest.mark.parametrize(
    ("with_it", "without", "relative", "half_width"),
    [
        ([1.0], [1.2], 0.2, None),
        ([1.0], [None], math.inf, None),
        ([None], [None], None, None),
        ([1e-5], [2e-5], None, None),  # both are below what is resolved
        # Welch: variances 0.02/2 each: t(0.975, 2 degrees of freedom) 4.3027 x sqrt(0.02)
        ([0.9, 1.1], [1.4, 1.6], 0.5, 4.3027 * math.sqrt(0.02)),
        ([1.0, 1.0], [1.0, 1.0], 0.0, 0.0),
    ],
)
def test_change_of_means_and_its_interval(
    with_it: list[float | None], without: list[float | None], relative: float | None, half_width: float | None
) -> None:
    sides = ([summary(value) for value in side] for side in (with_it, without))
    result = change("velocity", *sides, by_chance=True)
    assert result.relative == (relative if relative is None else pytest.approx(relative))
    expected = half_width if half_width is None else pytest.approx(half_width, rel=1e-4)
    assert result.uncertain == expected


def test_one_changed_result_is_enough_and_chance_is_no_change() -> None:
    same, other = Change(1.0, 1.05, 0.05), Change(1.0, 1.5, 0.5)
    wide, nothing = Change(1.0, 1.5, 0.5, 0.6), Change(None, None, None)
    assert outcome({"a": same}) == UNCHANGED
    assert outcome({"a": same, "b": other}) == CHANGED
    assert outcome({"a": same, "b": wide}) == BY_CHANCE
    assert outcome({"a": same, "b": nothing}) == UNCHANGED
    assert outcome({"b": nothing}) == NOT_COMPARED


def row(matters: bool | None, change_found: str) -> Row:
    return Row("scene", "wear", Verdict("number", 1.0, "2", matters, "why"), {}, change_found)


def test_false_alarms_are_a_share_of_what_was_decided() -> None:
    rows = [row(True, CHANGED)] * 9 + [row(True, UNCHANGED)] * 2 + [row(True, BY_CHANCE)] * 3
    table = Confusion([*rows, row(False, UNCHANGED), row(None, CHANGED)])
    assert table.false_alarms == pytest.approx(2 / 11)
    assert table.is_good
    assert table.count(CANNOT_SAY, CHANGED) == 1
    assert not Confusion([*rows, row(False, CHANGED)]).is_good
    assert not Confusion([*rows, row(True, UNCHANGED)]).is_good  # 3 of 12
    assert not Confusion([*rows, row(False, NOT_RUN)]).is_good
    shown = tables.markdown(table)
    assert "| matters | 9 | 2 | 3 | 0 | 0 |" in shown


def test_time_left_is_scaled_by_what_the_runs_took() -> None:
    lines: list[str] = []
    clock = iter([0.0, 30.0, 60.0])
    countdown = Countdown({"a": 10.0, "b": 10.0, "c": 20.0}, lines.append, lambda: next(clock))
    for line in ("old: done before", "a: done", "b: done"):
        countdown(line)
    assert lines == ["old: done before", "a: done; 2 to go, about 90 s", "b: done; 1 to go, about 60 s"]


def test_json_of_runs_is_read_where_they_came_to_an_end(tmp_path: Path) -> None:
    """A run that failed gives no summary to compare; one that is doubtful does."""
    from tools.effect_bank.trials import Trial

    scene = banks.read(tiny_bank(tmp_path))["high"]
    from tools.effect_bank.trials import try_scene

    runs = try_scene("high", scene, tmp_path, tmp_path / "out").trials[0].runs
    trial = Trial("high", "", runs)
    for status, count in (("failed", 0), ("doubtful", 1), ("done", 1), ("interrupted", 0)):
        runs[0].folder.mkdir(parents=True, exist_ok=True)
        write_summary(runs[0].folder, {"status": status})
        assert len(trial.summaries) == count
