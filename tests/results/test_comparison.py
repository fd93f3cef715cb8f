"""``flipflow results`` and ``flipflow compare``: rows, verdicts on differences, the page, and refusals."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from typer.testing import CliRunner

from orchestrator.case.bed import saved_bed
from orchestrator.case.bed.saved_bed import BED
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.case.tables.quantities import unit_along
from orchestrator.cli.main import app
from orchestrator.figures.figure import Figure
from orchestrator.output.records.summary import SUMMARY_FORMAT
from orchestrator.output.results.comparison import (
    BY_CHANCE,
    MORE,
    SAME,
    UNKNOWN,
    ComparedResult,
    judge_difference,
)
from orchestrator.output.results.tidy import Result, single_numbers, tidy_results
from tests.cases import CASE, case_folder
from tests.grains import spheres
from tests.results.synthetic import folder_of

CALL = CliRunner()


def estimate(value: float, half_width: float | None) -> dict[str, Any]:
    return {"value": value, "half_width": half_width, "batches": 10}


def bed_of(velocity: dict[str, Any]) -> dict[str, Any]:
    """The table of a bed of which little more than the velocity is known."""
    names = ("on_deck_kg", "load_kg_per_m2", "mean_depth_m", "largest_depth_m")
    profile: dict[str, Any] = {
        name: [] for name in ("along_m", "mass_kg_per_m", "velocity_m_per_s", "depth_m")
    }
    bed: dict[str, Any] = {name: {"value": None, "half_width": None, "batches": 0} for name in names}
    bed |= {"velocity_m_per_s": velocity, "particles": 40.0, "output_times": 9, "profile": profile}
    return bed


def run_folder(place: Path, velocity: dict[str, Any], case: str = CASE, **summary: Any) -> Path:
    """The folder of a run of which only the case and the results are there."""
    case_folder(place, case)
    results = {"bed": bed_of(velocity), "missing": {}, "failed": {}}
    lost_W = {"frames.bushing_damping": estimate(3.0, None)}
    results |= {"power": {"start_s": 0.0, "end_s": 1.0, "lost_W": lost_W}}
    table = {"format_version": SUMMARY_FORMAT, "status": "done", "case": "by-hand", "level": "draft"}
    text = json.dumps(table | {"results": results} | summary)
    (place / "summary.json").write_text(text)
    (place / "provenance.json").write_text("{}")
    return place


@pytest.fixture
def runs(tmp_path: Path) -> list[str]:
    """Three runs; the second is like the first but for chance, and the third is faster."""
    longer = CASE.replace("duration_s = 0.1", "duration_s = 0.2")
    first = run_folder(tmp_path / "a", estimate(0.30, 0.03))
    second = run_folder(tmp_path / "b", estimate(0.34, 0.03))
    third = run_folder(tmp_path / "c", estimate(0.35, 0.03), longer)
    return [str(folder) for folder in (first, second, third)]


LENGTH = Figure("length", resolution=1e-6, path="x_m")
SPEED = Figure("speed", resolution=1e-3, path="x_m_per_s")


@pytest.mark.parametrize(
    ("other", "verdict"),
    [((1.0, 0.1), SAME), ((1.13, 0.1), BY_CHANCE), ((1.15, 0.1), MORE), ((1.13, None), UNKNOWN)],
)
def test_the_interval_of_a_difference(other: tuple[float, float | None], verdict: str) -> None:
    """Half widths of 0.1 make 0.141 for the difference."""
    first, second = Result("x", 1.0, 0.1, LENGTH), Result("x", *other, LENGTH)
    assert judge_difference(first, second) == verdict
    assert judge_difference(second, first) == verdict


def test_what_a_run_does_not_resolve_is_the_same() -> None:
    first, second = (Result("x", value, None, LENGTH) for value in (1e-9, 5e-7))
    assert judge_difference(first, second) == SAME


def test_a_difference_that_intervals_show_is_told_however_small() -> None:
    slow, fast = (Result("x", value, 5e-5, SPEED) for value in (8e-4, 1.6e-3))
    assert judge_difference(slow, fast) == MORE
    assert judge_difference(*(Result("x", value, None, SPEED) for value in (0.1624, 0.1628))) == SAME


@pytest.mark.parametrize(
    ("path", "floor", "values", "change"),
    [
        ("x_m", 1e-9, (0.5, 0.4), -0.2),
        ("x_m", 1e-9, (9e-16, 2.2e-6), None),
        ("x_percent", 0.0, (0.0, 3.0), None),
        ("x_rad", 1e-9, (0.5, -0.7), None),
        ("x_deg", 0.0, (-5.9, 79.3), None),
    ],
)
def test_a_relative_change_is_told_only_where_it_has_a_meaning(
    path: str, floor: float, values: tuple[float, float], change: float | None
) -> None:
    figure = Figure("x", resolution=floor, path=path)
    first, second = (Result("x", value, None, figure) for value in values)
    assert ComparedResult("x", figure.unit, (first, second)).changes()[1] == pytest.approx(change)


def test_single_numbers_of_results() -> None:
    table = {"a": {"b_m": [1.0, 2.0, 3.0]}, "c": estimate(4.0, 0.5), "rows": [{"exit": "one", "d": 5.0}]}
    assert dict(single_numbers(table | {"text": "no", "curve": [1.0, 2.0]})) == {
        "a.b_m.x": 1.0,
        "a.b_m.y": 2.0,
        "a.b_m.z": 3.0,
        "c": 4.0,
        "c.half_width": 0.5,
        "rows.one.d": 5.0,
    }


def test_three_entries_of_a_series_are_no_vector() -> None:
    """A run of 18 cycles has three windows, and a feed may have three size classes."""
    windows = {"along_m": [1.0, 2.0, 3.0], "half_width_m": [0.1, 0.1, 0.1]}
    course = {"end_s": [0.5, 1.0, 1.5], "relative": {"b-a": windows}, "on_deck_kg": [1.0, 2.0, 3.0]}
    sizes = {"edges_m": [0.1, 0.2, 0.3, 0.4], "feed_percent": [20.0, 30.0, 50.0]}
    partition = sizes | {"d50_m": estimate(0.2, None)}
    assert dict(single_numbers({"course": course, "partition": partition})) == {"partition.d50_m": 0.2}


def test_a_vector_has_its_half_widths_by_component() -> None:
    vector = {"amplitude_m": [1.0, 2.0, 3.0], "phase_rad": [0.1, 0.2, 0.3]}
    plain = {"a.amplitude_m.x": 1.0, "a.amplitude_m.y": 2.0, "a.amplitude_m.z": 3.0}
    plain |= {"a.phase_rad.x": 0.1, "a.phase_rad.y": 0.2, "a.phase_rad.z": 0.3}
    assert dict(single_numbers({"a": vector | {"half_width_m": None}})) == plain
    results = tidy_results({"results": {"a": vector | {"half_width_m": [0.3, 0.2, 0.1]}}})
    assert {name: result.value for name, result in results.items()} == plain
    assert results["a.amplitude_m.x"].half_width == 0.3
    assert results["a.amplitude_m.z"].half_width == 0.1


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_results_are_written_as_rows(runs: list[str], tmp_path: Path, ending: str) -> None:
    file = tmp_path / f"results.{ending}"
    done = CALL.invoke(app, ["results", *runs, "--out", str(file)])
    assert done.exit_code == 0, done.output
    table = pd.read_csv(file) if ending == "csv" else pd.read_parquet(file)
    assert [*table.columns] == [
        *("run", "case", "level", "status", "result", "kind", "value", "half_width", "unit")
    ]
    row = table[(table["result"] == "velocity") & (table["run"] == runs[1])].iloc[0]
    assert (row["value"], row["half_width"], row["unit"], row["kind"]) == (0.34, 0.03, "m/s", "short name")
    lost = table[table["result"] == "power.lost_W.frames.bushing_damping"]
    assert set(lost["unit"]) == {"W"}
    assert lost["half_width"].isna().all()


def test_results_are_printed_as_csv_and_json(runs: list[str], tmp_path: Path) -> None:
    """The folder of a study stands for the runs in it."""
    printed = CALL.invoke(app, ["results", str(tmp_path)]).stdout.splitlines()
    table = json.loads(CALL.invoke(app, ["results", *runs, "--json"]).stdout)
    assert table["format_version"] == 1
    assert len(table["results"]) == len(printed) - 1
    assert {row["run"] for row in table["results"]} == {*runs}


def test_the_folder_of_a_design_study_stands_for_its_runs(runs: list[str], tmp_path: Path) -> None:
    """A run that was killed and repeated is put aside by the study, and is no run of it."""
    study = tmp_path / "study"
    moved = [shutil.move(run, study / "runs" / str(number)) for number, run in enumerate(runs)]
    run_folder(study / "runs" / "1-unfinished-1", estimate(0.3, 0.1), results={"missing": {}})
    done = CALL.invoke(app, ["results", str(study), "--json"])
    assert done.exit_code == 0, done.output
    assert {row["run"] for row in json.loads(done.stdout)["results"]} == {*map(str, moved)}


def test_a_comparison_tells_keys_and_results_that_differ(runs: list[str]) -> None:
    done = CALL.invoke(app, ["compare", *runs, "--json"])
    assert done.exit_code == 0, done.output
    table = json.loads(done.stdout)
    assert table["keys"] == {"duration_s": ["0.1", "0.1", "0.2"]}
    velocity = table["results"]["velocity"]
    assert velocity["values"] == [0.30, 0.34, 0.35]
    assert velocity["verdicts"] == [None, BY_CHANCE, MORE]
    assert table["results"]["bed.particles"]["verdicts"] == [None, SAME, SAME]
    # the velocity has a short name and a path, and counts once
    assert (table["compared"], table["more_than_chance"]) == (2, 1)
    lines = CALL.invoke(app, ["compare", *runs]).stdout
    assert "bed.velocity_m_per_s" not in lines
    assert "0.300 ± 0.030" in lines
    assert "+13.3 %" in lines


def test_tables_that_no_terminal_shows_cut_nothing(tmp_path: Path) -> None:
    """The runs of a sweep have long names, and so have points of a machine and values of tables."""
    point = "a-point-with-a-name-that-is-longer-than-many"
    names = [f"speed_rad_per_s-{73.30382858376184 + n}_tension_m-0.002" for n in range(6)]
    for number, name in enumerate(names):
        points = {f"{point}-{k}": {"rms_g": estimate(1.0 + 5 * number + k, 0.1)} for k in range(2)}
        tables = {"motion": {"panel_points": points}, "missing": {}, "failed": {}}
        longer = CASE.replace("duration_s = 0.1", f"duration_s = 0.{number + 1}")
        run_folder(tmp_path / name, {}, longer, results=tables)
    lines = CALL.invoke(app, ["compare", *(str(tmp_path / name) for name in names)]).stdout
    assert "\n  duration_s   0.1" in lines
    assert "…" not in lines
    for shown in (*names, f"  motion.panel_points.{point}-1.rms_g "):
        assert shown in lines


def test_files_of_one_name_differ_by_their_contents(tmp_path: Path) -> None:
    """Every run keeps the bed with which it began as bed.h5, and its surfaces under the same names."""
    case = CASE.replace('title = "a test"', 'title = "a test"\nbed.table = "bed.h5"')
    case += '[screen.surfaces.wall]\nstl = "wall.stl"\n'
    folders = [run_folder(tmp_path / name, estimate(0.3, 0.03), case) for name in ("a", "b", "c")]
    for folder, height_m in zip(folders, (0.1, 0.1, 0.2), strict=True):
        saved_bed.write(folder / BED, bed_of_one_grain(height_m))
        (folder / "wall.stl").write_text("solid")
    (folders[2] / "provenance.json").write_text('{"bed": {"file": "else/bed.h5", "time_s": 1.5}}')
    done = CALL.invoke(app, ["compare", *map(str, folders[:2])])
    assert "the cases are the same" in done.stdout, done.output
    keys = json.loads(CALL.invoke(app, ["compare", *map(str, folders), "--json"]).stdout)["keys"]
    assert [*keys] == ["bed.table"]
    first, second, third = keys["bed.table"]
    assert first == second != third
    assert third.endswith(" from else/bed.h5 at t = 1.5 s")
    (folders[1] / "wall.stl").write_text("another")
    keys = json.loads(CALL.invoke(app, ["compare", *map(str, folders[:2]), "--json"]).stdout)["keys"]
    assert [*keys] == ["screen.surfaces.wall.stl"]


def bed_of_one_grain(height_m: float) -> CarriedBed:
    """A grain at rest."""
    return CarriedBed(
        materials=("coal",),
        position_m=np.array([[0.0, 0.0, height_m]]),
        velocity_m_per_s=np.zeros((1, 3)),
        spin_rad_per_s=np.zeros((1, 3)),
        grains=spheres([0.01]),
        time_s=1.5,
        coarse_graining=1.0,
        source="",
    )


def test_the_page_of_a_comparison_needs_nothing_else(tmp_path: Path) -> None:
    first = folder_of(tmp_path / "one", cycles=12)
    second = tmp_path / "two"
    shutil.copytree(first, second)
    for folder, speed, share in ((first, 0.3, 1.0), (second, 0.4, 0.5)):
        summary = json.loads((folder / "summary.json").read_text())
        results: dict[str, Any] = {"bed": bed_of(estimate(speed, 0.01))}
        results |= {"missing": {}, "failed": {}, "share_of_width": share}
        (folder / "summary.json").write_text(json.dumps(summary | {"results": results}))
        (folder / "deck.png").write_bytes(b"\x89PNG")
    page = tmp_path / "page.html"
    done = CALL.invoke(app, ["compare", str(first), str(second), "--out", str(page)])
    assert done.exit_code == 0, done.output
    text = page.read_text()
    assert "more than chance" in text
    assert "compared as those of the whole width.</p>" in text
    assert "not to be trusted" not in text
    assert 'alt="orbits of the frames in the last cycle"' in text
    assert 'alt="The deck at the end of two"' in text
    assert text.count("src=") == text.count('src="data:')


@pytest.mark.parametrize("command", ["compare", "results"])
def test_runs_that_cannot_be_read_are_all_named_and_nothing_is_written(
    runs: list[str], tmp_path: Path, command: str
) -> None:
    old = run_folder(tmp_path / "old", estimate(0.3, 0.1), format_version=1)
    nothing = {"missing": {"everything": "short"}, "failed": {}, "share_of_width": 1.0}
    empty = run_folder(tmp_path / "empty", estimate(0.3, 0.1), results=nothing)
    page = tmp_path / "page.csv"
    places = [runs[0], str(old), str(empty), str(tmp_path / "nowhere")]
    done = CALL.invoke(app, [command, *places, "--out", str(page)])
    assert done.exit_code == 2
    for text in (
        "old/summary.json: has format 1",
        "empty: the run has no results",
        "nowhere: no such folder",
    ):
        assert text in done.stderr
    assert not page.exists()


def test_what_cannot_be_compared_is_refused(runs: list[str], tmp_path: Path) -> None:
    assert "nothing to compare it with" in CALL.invoke(app, ["compare", runs[0]]).stderr
    assert "named twice" in CALL.invoke(app, ["compare", runs[0], runs[0]]).stderr
    whole = {"share_of_width": 1.0, "slice_width_m": None}
    runs[0] = str(run_folder(tmp_path / "e", {}, results=whole | {"bed": {"particles": 40.0}}))
    other = run_folder(tmp_path / "d", {}, results=whole | {"wear": {"deepest_m": 1.0}})
    done = CALL.invoke(app, ["compare", runs[0], str(other), "--out", str(tmp_path / "page.html")])
    assert done.exit_code == 2
    assert "has no results in common with" in done.stderr
    assert not (tmp_path / "page.html").exists()
    wrong = CALL.invoke(app, ["results", runs[0], "--out", str(tmp_path / "x.txt")])
    assert wrong.exit_code == 2
    assert ".csv or .parquet" in wrong.stderr


def test_runs_of_different_programs_are_told_apart(runs: list[str]) -> None:
    """A change by the program would be taken for a change by the keys."""
    for run, commit in zip(runs, ("aa", "aa+", "aa"), strict=True):
        about = {"commit": commit, "versions": {"numpy": "1.24.2"}}
        (Path(run) / "provenance.json").write_text(json.dumps(about))
    message = CALL.invoke(app, ["compare", *runs]).stderr
    assert "other programs made the runs, which may change results: commit aa, aa+, aa" in message
    assert "numpy" not in message
    assert "other programs" not in CALL.invoke(app, ["compare", runs[0], runs[2]]).stderr
    (Path(runs[2]) / "provenance.json").write_text("[")
    assert "commit aa, unknown" in CALL.invoke(app, ["compare", runs[0], runs[2]]).stderr


def test_efficiencies_of_different_cuts_are_not_compared(tmp_path: Path) -> None:
    """Other grains are fine at another cut: a change of the efficiency would say nothing of the machine."""
    folders = []
    for place, cut_m, efficiency in (("a", 0.012, 60.0), ("b", 0.012, 70.0), ("c", 0.006, 80.0)):
        screening = {"cut_size_m": cut_m, "efficiency_percent": estimate(efficiency, 2.0)}
        screening |= {"feed_kg_per_s": estimate(5.0, 0.1), "recovered_percent": estimate(efficiency, 2.0)}
        tables = {"screening": screening, "missing": {}, "failed": {}}
        folders.append(str(run_folder(tmp_path / place, {}, results=tables)))
    done = CALL.invoke(app, ["compare", *folders, "--json"])
    results = json.loads(done.stdout)["results"]
    cut_names = ("efficiency", "recovery", "screening.efficiency_percent", "screening.recovered_percent")
    for name in cut_names:
        assert results[name]["values"] == [60.0, 70.0, None]
        assert results[name]["verdicts"] == [None, "more than chance", None]
    assert results["screening.feed_kg_per_s"]["values"] == [5.0, 5.0, 5.0]
    message = " ".join(done.stderr.split())
    assert "different cuts (12 mm, 12 mm, 6 mm): their efficiencies are not compared" in message
    assert "different cuts" not in CALL.invoke(app, ["compare", *folders[:2]]).stderr


def test_slices_and_transients_are_told_apart(tmp_path: Path) -> None:
    """Results are compared as those of the whole width: a slice and the whole machine have the same power."""
    whole, sliced = tmp_path / "whole", tmp_path / "sliced"
    reason = "in less out is +8.0 % of the feed over the last 30 cycles; up to 2 % counts as steady"
    for place, share, steady in ((whole, 1.0, ""), (sliced, 0.25, reason)):
        power = {"drives_W": estimate(400.0 * share, 8.0 * share)}
        tables = {
            "power": power,
            "share_of_width": share,
            "steady": {"is_steady": not steady, "reason": steady},
            "held": {"stickers": estimate(20.0 * share, 0.1)},
            "wear": {"panels": {"deck": {"worn_m3": estimate(1e-9 * share, 1e-11)}}},
            "motion": {"ground": {"amplitude_N": {"z": estimate(800.0 * share, 1.0)}}, "reason": ""},
        }
        tables |= {"bed": {"velocity_m_per_s": estimate(0.5, 0.1)}, "missing": {}, "failed": {}}
        run_folder(place, {}, results=tables)
    done = CALL.invoke(app, ["compare", str(whole), str(sliced), "--json"])
    comparison = json.loads(done.stdout)
    for name in ("power", "power.drives_W"):
        assert comparison["results"][name]["values"] == pytest.approx([400.0, 400.0])
        assert comparison["results"][name]["half_widths"] == pytest.approx([8.0, 8.0])
    assert comparison["results"]["motion.ground.amplitude_N.z"]["values"] == pytest.approx([800.0, 800.0])
    assert comparison["results"]["wear.panels.deck.worn_m3"]["values"] == pytest.approx([1e-9, 1e-9])
    assert comparison["results"]["held.stickers"]["values"] == pytest.approx([20.0, 20.0])
    assert comparison["more_than_chance"] == 0
    assert f"{sliced}: not steady: {reason}" in " ".join(done.stderr.split())
    assert "slices of different shares of the width (whole 1, sliced 0.25)" in " ".join(done.stderr.split())
    rows = json.loads(CALL.invoke(app, ["results", str(sliced), "--json"]).stdout)["results"]
    values = {row["result"]: row["value"] for row in rows}
    assert (values["power"], values["power.drives_W"]) == (400.0, 100.0)


def test_rounding_is_no_difference_and_an_unsettled_machine_is_named(tmp_path: Path) -> None:
    """A machine in its plane moves across the deck by 1e-17 m, in one run five times as far as in another."""
    first, other = tmp_path / "one", tmp_path / "other"
    for place, across_m, reason in (
        (first, 1.9e-17, ""),
        (other, 1.1e-16, "range of driving changes by 6.4 %"),
    ):
        frame = {"amplitude_m": [0.002, across_m, 0.003], "half_width_m": [1e-5, 1e-18, 1e-5]}
        motion = {"frames": {"driving": frame}, "is_settled": not reason, "reason": reason}
        run_folder(place, {}, results={"motion": motion, "missing": {}, "failed": {}})
    done = CALL.invoke(app, ["compare", str(first), str(other), "--json"])
    result = json.loads(done.stdout)["results"]["motion.frames.driving.amplitude_m.y"]
    assert result["verdicts"] == [None, SAME]
    assert f"{other}: the machine has not settled: range of driving" in " ".join(done.stderr.split())
    assert f"{first}: the machine" not in done.stderr


@pytest.mark.parametrize("command", ["results", "compare"])
@pytest.mark.parametrize(("status", "count"), [("done", 0), ("doubtful", 1)])
def test_a_doubtful_run_is_warned_of(tmp_path: Path, command: str, status: str, count: int) -> None:
    run = run_folder(tmp_path / "one", estimate(0.3, 0.03))
    other = run_folder(tmp_path / "other", estimate(0.3, 0.03), status=status)
    done = CALL.invoke(app, [command, str(run), str(other)])
    assert done.exit_code == 0
    warned = "".join(done.stderr.split()).count("warning:")
    assert warned == count
    assert (str(other) in "".join(done.stderr.split())) is bool(count)


def test_units_are_those_of_the_nearest_key() -> None:
    assert unit_along(["results", "power", "lost_W", "frames.bushing_damping"]) == "W"
    assert unit_along(["results", "bed", "velocity_m_per_s"]) == "m/s"
    assert unit_along(["results", "motion", "shafts_rad_per_s", "main"]) == "rad/s"
    assert unit_along(["particle_steps_per_s"]) == "1/s"
    assert unit_along(["results", "screening", "particles"]) == "1"
