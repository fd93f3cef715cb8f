"""``flipflow plan --for``: how chance falls, and what it costs, against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import tomli_w
import typer
from typer.testing import CliRunner

from orchestrator.case.file.whole import write_json
from orchestrator.cli.chance import Basis, ChancePlan, Numerics, Way
from orchestrator.cli.main import app
from orchestrator.cli.plan_result import numerics, parse_tolerance
from orchestrator.cli.planning import Timing
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.output.records.summary import SUMMARY_FORMAT
from orchestrator.preflight.judge import load_judged
from orchestrator.studies.accuracy.stored import FORMAT, StoredStudy
from tests.runs.outside import ROOT

CALL = CliRunner()
# 4 s counted after 2 s leave 3 points; 1 s to start, then 10 s of a processor for each second, a fifth of it
# the particles'
BASIS = Basis(3.0, 4.0, 2.0, 6.0, 61.0, Timing(1.0, 6.0, 1.0, 1.0, 0.2), 0.1, least_s=2.0)


def plan(tolerance: float, budget_s: float = 1e9, **more: Any) -> ChancePlan:
    return ChancePlan(BASIS, tolerance, budget_s, **more)


def test_four_times_as_long_halves_chance() -> None:
    (way,) = plan(1.5).ways
    assert way.half_width(6.0) == pytest.approx(3.0)
    assert way.half_width(2.0 + 16.0) == pytest.approx(1.5)
    assert way.duration_s(1.5) == pytest.approx(18.0)
    assert way.price_s(18.0) == pytest.approx(1.0 + 180.0)


def test_each_seed_pays_for_its_start_and_its_settling() -> None:
    """Four runs of 4 s, of 2 + 4 s each, leave as much to chance as one of 16 s, of 2 + 16 s; on two cores
    they take the time of two."""
    way = Way(BASIS, Numerics(), runs=4, cores=2)
    duration_s = way.duration_s(1.5)
    assert duration_s == pytest.approx(6.0)
    assert way.price_s(duration_s) == pytest.approx(4 * 61.0)
    assert way.wall_s(duration_s) == pytest.approx(2 * 61.0)
    chosen = plan(1.5, cores=4).choice
    assert chosen is not None
    assert chosen.way.runs == 1


def test_a_wider_slice_settles_once_and_costs_its_particles() -> None:
    """A second of w widths takes 8 + 2 w s, and 2 + 16 / w s are run: the price is least at the w whose
    square is 8 x 16 / (2 x 2)."""
    widths_m = tuple(0.1 * ratio for ratio in (1, 2, 4, 5, 5.657, 6.5, 8))
    fine = replace(BASIS, every_s=1e-4, least_s=0.0)
    chosen = ChancePlan(fine, 1.5, 1e9, widths_m=widths_m).choice
    assert chosen is not None
    ratio = chosen.way.width_ratio
    assert ratio == pytest.approx(math.sqrt(8 * 16 / (2 * 2)), rel=1e-3)
    assert chosen.duration_s == pytest.approx(2.0 + 16.0 / ratio, abs=1e-4)
    assert chosen.price_s == pytest.approx(1.0 + (8 + 2 * ratio) * chosen.duration_s)


def test_going_on_pays_for_what_is_added() -> None:
    chosen = plan(1.5, can_go_on=True).choice
    assert chosen is not None
    assert chosen.way.goes_on
    assert chosen.price_s == pytest.approx(1.0 + 10.0 * 12.0)
    there = plan(4.0, can_go_on=True).choice
    assert there is not None
    assert there.duration_s == pytest.approx(6.0)


def test_more_cores_buy_time_and_not_price() -> None:
    """One run of 18 s takes 181 s; four of 6 s take 61 s on four cores, and 244 s of processors."""
    chosen = plan(1.5, 70.0, cores=4).choice
    assert chosen is not None
    assert (chosen.way.runs, chosen.wall_s, chosen.price_s) == (4, pytest.approx(61.0), pytest.approx(244.0))


def test_a_run_counts_no_less_than_settles() -> None:
    (way,) = plan(30.0).ways
    assert way.duration_s(30.0) == pytest.approx(4.0)


def test_the_bound_of_numerics_is_taken_off_the_tolerance() -> None:
    """At half the price a mesh is off by at most one point, so that chance may have 1.5 of 2.5 points; where
    no settings are known to be within it, the case as it is comes, whose error is not known."""
    coarse = Numerics("coarse", ("panel.cells=[8, 1]",), 1.0, 0.5)
    chosen = plan(2.5, numerics=(coarse, Numerics())).choice
    assert chosen is not None
    assert chosen.way.numerics is coarse
    assert chosen.duration_s == pytest.approx(18.0)
    assert chosen.price_s == pytest.approx(1.0 + 5.0 * 18.0)
    own = plan(0.9, numerics=(coarse, Numerics())).choice
    assert own is not None
    assert own.way.numerics.at_most is None
    assert plan(0.9, numerics=(coarse, Numerics(at_most=2.0))).choice is None


def test_what_is_not_feasible_says_what_would_be() -> None:
    """Of 101 s, 10 s are simulated, of which 8 s are counted: 3 points over the root of two."""
    made = plan(1.5, 101.0)
    assert made.choice is None
    assert made.best is not None
    assert made.best.duration_s == pytest.approx(10.0)
    assert made.best.half_width == pytest.approx(3.0 / math.sqrt(2))
    assert plan(1.5, 20.0).best is None


def test_a_feed_that_stops_limits_the_run() -> None:
    short = replace(BASIS, longest_s=8.0)
    made = ChancePlan(short, 1.5, 1e9, cores=4)
    assert made.choice is not None
    assert made.choice.way.runs == 3
    assert made.choice.duration_s <= 8.0
    assert ChancePlan(short, 1.5, 1e9).choice is None


@pytest.mark.parametrize(
    ("text", "means"), [("5%", (0.05, 0.0)), ("0.05", (0.05, 0.0)), ("2 points", (None, 2.0))]
)
def test_a_tolerance_is_relative_or_in_points(text: str, means: tuple[float | None, float]) -> None:
    assert parse_tolerance(text, "efficiency") == means


@pytest.mark.parametrize("text", ["5", "0%", "-1 points", "five", "2 mm", "nan%"])
def test_what_is_no_tolerance_is_refused(text: str) -> None:
    with pytest.raises(typer.Exit):
        parse_tolerance(text, "efficiency")


def test_settings_of_a_study_count_with_the_upper_end_of_their_error() -> None:
    """Of a third; a width is no numerics, and settings of a single seed are not bounded."""
    point = {"status": "done", "settings": "as it is", "processor_s": 20.0}
    error = {"efficiency_percent_error": 0.02, "efficiency_percent_error_half_width": 0.01}
    points = [
        point | error | {"point": "base", "sets": ""},
        point | error | {"point": "a", "sets": "'panel.cells=[8, 1]'", "processor_s": 10.0},
        point | error | {"point": "b", "sets": "slice.width_m=0.1"},
        point | error | {"point": "d", "sets": "bed.feeds.coal.smallest_fed_m=0.001"},
        point
        | error
        | {"point": "c", "sets": "panel.step_s=1e-5", "efficiency_percent_error_half_width": None},
    ]
    stored = StoredStudy(Path("accuracy.json"), {"format_version": FORMAT, "points": points})
    coarse, own = numerics(stored, "computed_efficiency", 30.0)
    assert coarse.sets == ("panel.cells=[8, 1]",)
    assert (coarse.at_most, coarse.ratio) == (pytest.approx(0.9), 0.5)
    assert own.at_most == pytest.approx(0.9)
    assert [*numerics(None, "efficiency", 30.0)] == [Numerics()]


def run_folder(folder: Path, **changed: Any) -> Path:
    """Write what a plan reads of a run of near-mesh: 6 s, of which 3 s counted, of 31 s of a processor."""
    folder.mkdir()
    loaded = load_judged(ROOT / "cases/near-mesh", "draft")
    (folder / "case.toml").write_text(tomli_w.dumps(resolved_case(loaded)))
    efficiency = {"value": 30.0, "half_width": 3.0, "batches": 37, "standard_error": 3.0 / 2.4469}
    steady = {"is_steady": True, "reason": "", "start_s": 3.0, "end_s": 6.0, "cycles": 37}
    results = {"share_of_width": 0.149, "slice_width_m": 0.119, "steady": steady, "missing": {}}
    summary: dict[str, Any] = {
        "format_version": SUMMARY_FORMAT,
        "status": "done",
        "case": "near-mesh",
        "level": "draft",
        "simulated_s": 6.0,
        "processor_s": 31.0,
        "processor_before_s": 0.5,
        "wall_s": 30.5,
        "wall_by_part_s": {"particles": 20.0, "coupling": 10.0, "rest": 0.5},
        "repeated_by_part_s": {},
        "results": results | {"screening": {"efficiency_percent": efficiency}},
    }
    steady.update(changed.pop("steady", {}))
    write_json(folder / "summary.json", summary | changed)
    return folder


def called(*words: str) -> tuple[int, str]:
    done = CALL.invoke(app, ["plan", str(ROOT / "cases/near-mesh"), *words])
    return done.exit_code, done.output


def test_a_run_is_planned_from(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """3 s leave 10 % of the value; 5 % want 12 s.  Without --from the run in runs/ counts."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "runs").mkdir()
    run = run_folder(tmp_path / "runs/near-mesh-1")
    (run / "checkpoints/0001").mkdir(parents=True)
    asked = ("--for", "efficiency", "--budget", "2h", "--jobs", "1")
    for words in (("--tolerance", "5%", "--from", str(run)), ("--tolerance", "1.5 points")):
        code, output = called(*asked, *words)
        assert code == 0
        assert "± 1.5 points, 5 % of the value" in output
        assert "flipflow run" in output or "flipflow resume" in output
    code, output = called(*asked[:2], "--budget", "10s", "--tolerance", "0.5%")
    assert code == 4
    assert "flipflow study accuracy" in output


@pytest.mark.parametrize(
    "words",
    [
        ("--for", "efficiency", "--tolerance", "5 apples"),
        ("--for", "efficient", "--tolerance", "5%"),
        ("--for", "stroke", "--tolerance", "5%"),
        ("--for", "efficiency", "--tolerance", "5%", "--from", "nowhere"),
        ("--for", "efficiency", "--tolerance", "5%", "--write", "planned"),
        ("--tolerance", "5%", "--from", "run"),
        ("--tolerance", "5%", "--jobs", "2"),
    ],
)
def test_a_wrong_question_ends_with_2(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert called("--budget", "1h", *words)[0] == 2


@pytest.mark.parametrize(
    "changed",
    [
        {"case": "quickstart"},
        {"level": "fine"},
        {"status": "failed"},
        {"steady": {"reason": "it grows", "is_steady": False}},
        {"results": {"steady": {"reason": ""}, "missing": {}}},
    ],
)
def test_a_run_that_tells_no_chance_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, changed: dict[str, Any]
) -> None:
    monkeypatch.chdir(tmp_path)
    run = run_folder(tmp_path / "run", **changed)
    words = ("--for", "efficiency", "--tolerance", "5%", "--budget", "1h", "--from", str(run))
    assert called(*words)[0] == 2
