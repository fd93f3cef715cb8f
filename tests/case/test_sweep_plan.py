"""The plan of a sweep over several keys, and the results that are drawn; nothing is run here."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib.image
import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.cli.studies.sweep import command
from orchestrator.figures.short_names import Value
from orchestrator.studies.points import CaseStudy, parse_vary
from orchestrator.studies.sweep_plan import Arrangement, plan_sweep
from orchestrator.studies.sweep_results import SweptSetting, draw_results, results_table, short_keys
from orchestrator.workbench import Picture
from tests.cases import keys_and_kinds
from tests.runs.outside import ROOT

SPEED, SLOPE = "screen.exciters.shaft.speed_rad_per_s", "screen.inclination_deg"
TWO = (f"{SPEED}=58:84:26", f"{SLOPE}=10,15")


@pytest.mark.smoke
def test_a_grid_has_all_combinations() -> None:
    plan = plan_sweep([*TWO, "panel.solver=rigid,strip"], Arrangement.GRID, 0, 1)
    assert plan.keys == (SPEED, SLOPE, "panel.solver")
    assert len(plan.settings) == 8
    assert plan.settings[0] == ("58.0", "10", "rigid")


def test_a_list_takes_one_value_of_each_key() -> None:
    assert plan_sweep(TWO, Arrangement.LIST, 0, 1).settings == (("58.0", "10"), ("84.0", "15"))


def test_a_list_may_take_a_value_again_and_a_grid_may_not() -> None:
    again = ("panel.solver=rigid,strip,strip", f"{SLOPE}=10,10,15")
    settings = (("rigid", "10"), ("strip", "10"), ("strip", "15"))
    assert plan_sweep(again, Arrangement.LIST, 0, 1).settings == settings
    with pytest.raises(CaseError, match="one twice"):
        plan_sweep(again, Arrangement.GRID, 0, 1)


def test_random_settings_are_repeatable_and_can_be_continued() -> None:
    """A larger number keeps the settings that have been run."""
    wanted = (f"{SPEED}=58:110", f"{SLOPE}=10,15")
    few, more = (plan_sweep(wanted, Arrangement.RANDOM, number, 7) for number in (5, 9))
    other = plan_sweep(wanted, Arrangement.RANDOM, 5, 8)
    assert more.settings[:5] == few.settings
    assert other.settings != few.settings
    assert all(58 <= float(speed) <= 110 and slope in ("10", "15") for speed, slope in more.settings)


def test_a_random_plan_has_as_many_different_settings_as_were_asked_for() -> None:
    """A short list would have nearly each setting drawn twice; all settings there are can be asked for, and
    no more."""
    wanted = (f"{SLOPE}=10,15,20", "panel.solver=rigid,strip")
    every = plan_sweep(wanted, Arrangement.RANDOM, 6, 1).settings
    assert len(set(every)) == 6
    assert plan_sweep(wanted, Arrangement.RANDOM, 4, 1).settings == every[:4]
    with pytest.raises(CaseError, match="finds 6 different settings, not 7"):
        plan_sweep(wanted, Arrangement.RANDOM, 7, 1)


@pytest.mark.parametrize(("first", "last"), [(1000.2, 1000.4), (10.004, 20.0), (-0.1, 0.1), (58.0, 110.0)])
def test_random_values_lie_in_their_range(first: float, last: float) -> None:
    plan = plan_sweep([f"{SPEED}={first}:{last}"], Arrangement.RANDOM, 50, 1)
    values = [float(value) for (value,) in plan.settings]
    assert all(first <= value <= last for value in values)
    assert len(set(values)) == 50


@pytest.mark.parametrize("how", [Arrangement.GRID, Arrangement.RANDOM])
def test_values_are_given_back_in_the_units_in_which_they_came(tmp_path: Path, how: Arrangement) -> None:
    """750 rpm are 78.54 rad/s, as the column of sweep.csv says."""
    plan = plan_sweep([f"{SPEED}=700 rpm,750 rpm", f"{SLOPE}=15"], how, 2, 1)
    points = plan.points(CaseStudy(ROOT / "cases/empty-machine", "draft", out=tmp_path))
    (faster,) = (point for point in points if plan.given_of(point) == {SPEED: "750 rpm"})
    assert faster.folder.name == "speed_rad_per_s-750_rpm_inclination_deg-15"
    assert faster.loaded.tables.screen.exciters["shaft"].speed_rad_per_s == pytest.approx(25 * math.pi)
    assert float(plan.setting_of(faster)[SPEED]) == pytest.approx(25 * math.pi)
    rows = [SweptSetting(plan.setting_of(p), "done", {}, (), plan.given_of(p)) for p in points]
    assert sorted(results_table(plan.keys, rows, []).columns[0].cells) == ["700 rpm", "750 rpm"]


def test_values_between_two_with_a_unit_are_told_in_it() -> None:
    plan = plan_sweep([f"{SPEED}=700:800 rpm"], Arrangement.RANDOM, 3, 1)
    for (value,) in plan.settings:
        rpm, unit = plan.given[SPEED][value].split()
        assert unit == "rpm"
        assert 700 <= float(rpm) <= 800
        assert float(value) == pytest.approx(float(rpm) * math.pi / 30)


def test_one_varied_key_gives_back_its_unit() -> None:
    vary = parse_vary(f"{SPEED}=700:750:25 rpm")
    assert [*vary.given.values()] == ["700 rpm", "725 rpm", "750 rpm"]
    assert vary.folder(vary.values[0]) == "speed_rad_per_s-700_rpm"


def test_a_dry_sweep_lists_and_predicts_its_runs_and_writes_nothing(tmp_path: Path) -> None:
    study = CaseStudy(ROOT / "cases/empty-machine", "draft", out=tmp_path / "out")
    lines = [*command(study, [f"{SPEED}=700:750:50 rpm"], dry=True)]
    assert lines[0].startswith(f"{SPEED} = 700 rpm: ")
    assert lines[1].startswith(f"{SPEED} = 750 rpm: ")
    assert lines[2].startswith("2 of 2 runs are to be made, ")
    assert not (tmp_path / "out").exists()


def test_each_point_has_a_folder_of_its_own_and_its_keys(tmp_path: Path) -> None:
    plan = plan_sweep(TWO, Arrangement.GRID, 0, 1)
    points = plan.points(CaseStudy(ROOT / "cases/empty-machine", "draft", out=tmp_path))
    assert len({point.folder for point in points}) == 4
    assert points[1].folder.name == "speed_rad_per_s-58.0_inclination_deg-15"
    assert points[1].loaded.tables.screen.inclination_deg == 15
    assert plan.setting_of(points[1]) == {SPEED: "58.0", SLOPE: "15"}


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("panel.cells.0=10:30:10", ("10", "20", "30")),
        ("bed.feeds.coal.seed=3:1:-1", ("3", "2", "1")),
        ("frictions.0.friction=0:1:0.5", ("0.0", "0.5", "1.0")),
        (f"{SPEED}=58:84:26", ("58.0", "84.0")),
    ],
)
def test_a_range_of_whole_numbers_is_one_of_counts(text: str, values: tuple[str, ...]) -> None:
    """A key with a unit is none of a count."""
    assert parse_vary(text).values == values


@pytest.mark.parametrize("text", ["1e400:2e400:1e400", "nan:1:1", "1e-999999999:0:1e999999999"])
def test_a_range_of_no_numbers_is_refused(text: str) -> None:
    with pytest.raises(CaseError) as refused:
        parse_vary(f"screen.inclination_deg={text}")
    assert keys_and_kinds(refused.value.problems) == [": wrong-type"]


def test_a_table_that_the_case_lacks_is_named_with_the_nearest(tmp_path: Path) -> None:
    case = CaseStudy(ROOT / "cases/empty-machine", "draft", out=tmp_path / "out")
    mistyped = command(case, ["screen.exciters.shft.speed_rad_per_s=58,84"])
    with pytest.raises(
        CaseError, match=r'--vary .*: the case has no "shft" in screen\.exciters; did you mean "shaft"\?'
    ):
        next(mistyped)
    assert not (tmp_path / "out").exists()


def test_the_folder_of_a_sweep_over_other_keys_is_refused(tmp_path: Path) -> None:
    (tmp_path / "sweep.csv").write_text(f"{SLOPE},status,settled\n", encoding="utf-8")
    case = CaseStudy(ROOT / "cases/empty-machine", "draft", out=tmp_path)
    with pytest.raises(FolderUnusable, match=r"sweep\.csv:"):
        next(command(case, [f"{SPEED}=58,84"]))


@pytest.mark.parametrize(
    ("vary", "how", "places"),
    [
        ((f"{SPEED}=1,2", f"{SPEED}=3,4"), "grid", [f"--vary {SPEED}"]),
        ((f"{SPEED}=1,2", f"{SLOPE}=3"), "list", ["--plan list"]),
        ((f"{SPEED}=1:1000:1", f"{SLOPE}=1:2:1"), "grid", ["--plan grid"]),
        ((f"{SPEED}=2:1",), "random", [f"--vary {SPEED}=2:1"]),
        ((f"{SPEED}=0:1000:1",), "grid", [f"--vary {SPEED}=0:1000:1"]),
        ((f"{SPEED}=a:b",), "random", [f"--vary {SPEED}=a:b"]),
        (("x", "y="), "grid", ["--vary x", "--vary y="]),
    ],
)
def test_a_wrong_plan_is_refused(vary: tuple[str, ...], how: str, places: list[str]) -> None:
    with pytest.raises(CaseError) as refused:
        plan_sweep(vary, Arrangement(how), 3, 1)
    assert [problem.file for problem in refused.value.problems] == places
    assert {problem.kind for problem in refused.value.problems} == {"wrong-type"}


@pytest.mark.parametrize(("how", "pictures"), [("grid", 2), ("random", 4)])
def test_results_are_drawn_with_their_intervals(tmp_path: Path, how: str, pictures: int) -> None:
    """Lines over the first key of a grid; for scattered settings, a picture over each key."""
    keys = ("a.x_m", "b.y_m")
    settings = [("1", "1"), ("2", "1"), ("1", "2"), ("2", "2")] if how == "grid" else [("1", "3"), ("2", "4")]
    rows = [
        SweptSetting(dict(zip(keys, each, strict=True)), "done", {"stroke": Value(0.01, 0.001)})
        for each in settings
    ]
    wanted = ("stroke", "results.bed.depth_m")
    (file,) = draw_results(keys, rows, wanted, tmp_path / "results.png")
    height = matplotlib.image.imread(file).shape[0]
    assert (height > 600) == (pictures > 2), "two parts in one row, or four in two"
    assert draw_results(keys, rows[:1], wanted, tmp_path / "none.png") == []


def test_settings_without_numbers_stand_below_each_other(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    keys, settings = ("bed.shape", "deck.rims"), [("sphere", "thin"), ("stone", "thin"), ("stone", "deep")]
    rows = [
        SweptSetting(dict(zip(keys, words, strict=True)), "done", {"stroke": Value(0.01 * number, 0.001)})
        for number, words in enumerate(settings)
    ]
    drawn: list[Any] = []
    monkeypatch.setattr(Picture, "save", lambda picture, _: drawn.append(picture.figure))
    draw_results(keys, rows, ["stroke"], tmp_path / "results.png")
    (axes,) = drawn[0].axes
    assert [label.get_text() for label in axes.get_yticklabels()] == [", ".join(words) for words in settings]
    assert [each[0].get_xdata()[0] for each in axes.containers] == [0.0, 0.01, 0.02]
    assert axes.yaxis_inverted(), "the first on top"


def test_a_transient_run_is_told_and_has_an_open_mark(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    rows = [
        SweptSetting({"a.x_m": str(number)}, status, {"stroke": Value(0.01, 0.001)}, transient)
        for number, (status, transient) in enumerate(
            (("done", ()), ("done", ("not settled",)), ("doubtful", ("not settled", "not steady")))
        )
    ]
    table = results_table(["a.x_m"], rows, ["stroke", "velocity", "results.bed.particles"])
    names = [column.header for column in table.columns]
    assert names == ["x_m", "stroke / m", "velocity / (m/s)", "results.bed.particles", "state"]
    assert [*table.columns[-1].cells] == ["done", "done, not settled", "doubtful, not settled, not steady"]
    assert [row.look for row in rows] == ["good", "open", "cross"]
    drawn: list[Any] = []
    monkeypatch.setattr(Picture, "save", lambda picture, _: drawn.append(picture.figure))
    draw_results(["a.x_m"], rows, ["stroke"], tmp_path / "results.png")
    (axes,) = drawn[0].axes
    drawn[0].draw_without_rendering()
    assert axes.yaxis.label.get_window_extent().y0 >= 0.0, "the unit is in the picture"
    assert [each[0].get_markerfacecolor() for each in axes.containers][1] == "white"
    assert [each[0].get_marker() for each in axes.containers] == ["o", "o", "x"]


def test_columns_are_headed_by_as_many_words_as_tell_them_apart() -> None:
    assert short_keys(["duration_s", "screen.frames.driven.mass_kg"]) == ["duration_s", "mass_kg"]
    frames = [f"screen.frames.{name}.mass_kg" for name in ("driving", "driven")]
    assert short_keys(frames) == ["driving.mass_kg", "driven.mass_kg"]
