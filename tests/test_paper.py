"""A case against its paper, on runs whose motion is made up: what is found, met and refused."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.output.records.history import HISTORY_FORMAT
from orchestrator.output.records.summary import write_summary
from orchestrator.studies.criteria import Runs, read_criteria, wanted_runs
from orchestrator.studies.points import CaseStudy, Point
from orchestrator.studies.quantities import Unknown
from orchestrator.studies.verdicts import CriterionResult, judge, write_verdicts
from tests.cases import CASE, case_folder

SPEED = "screen.exciters.shaft.speed_rad_per_s"
DRIVEN = "[screen.frames.driven]\nmass_kg = 30.0\ninertia_kg_m2 = [1.0, 2.0, 2.0]\n"
HELD = (
    '[screen.bushings.shear]\nbetween = ["driving", "driven"]\n'
    "positions_m = [[0.0, 0.0, 0.0]]\nstiffness_N_per_m = [1e4, 1e4, 1e4]\n"
)
HEAD = f'source = "made up"\n[runs.speed]\nvary = "{SPEED}=70,60,80,90"\n'
ROW = """
[[criteria]]
what = "a"
run = "speed"
at = "70"
measure = "amplitude"
of = "driven-driving"
unit = "mm"
reference = 6.0
band = [5.4, 6.6]
"""


def moved_mm(speed: float) -> tuple[float, float]:
    """Amplitudes of both frames: the driving one is least at 78."""
    return 1.0 + 0.01 * (speed - 78) ** 2, speed / 10


@pytest.fixture
def case(tmp_path: Path) -> Path:
    before, after = CASE.split("[screen.bushings.isolation]")
    text = before + DRIVEN + HELD + "[screen.bushings.isolation]" + after
    folder = case_folder(tmp_path / "case", text)
    (folder / "criteria.toml").write_text(HEAD + ROW)
    return folder


def compared(case: Path, text: str) -> list[CriterionResult]:
    """With runs in which both frames swing along x, against each other."""
    (case / "criteria.toml").write_text(HEAD + text)
    runs = runs_of(case)
    for point in runs["speed"].points:
        if not point.folder.exists():
            fake(point)
    return [judge("case", row, runs) for row in read_criteria(case).criteria]


def runs_of(case: Path) -> dict[str, Runs]:
    return wanted_runs(read_criteria(case), CaseStudy(case, out=case.parent / "out"))


def fake(point: Point) -> None:
    speed = float(point.value)
    driving, driven = moved_mm(speed)
    case_folder(point.folder, (point.loaded.folder / "case.toml").read_text())
    screening = {
        "efficiency_percent": {"value": speed},
        "sections": [{"depth_m": speed / 100 - step} for step in (0.0, 0.3, 0.4)],
    }
    bed = {"velocity_m_per_s": {"value": speed / 10}}
    motion = {
        "frames": {"driving": orbit(driving), "driven": orbit(-driven)},
        "relative": {"driven-driving": orbit(driven + driving)},
    }
    results = {"screening": screening, "bed": bed, "motion": motion}
    write_summary(point.folder, {"status": "done", "cycle_s": 2 * np.pi / speed, "results": results})
    with h5py.File(point.folder / "history.h5", "w") as history:
        history.attrs["format_version"] = HISTORY_FORMAT
        history["panel_cycles/deck/time_s"] = [0.5, 1.0, 1.5, 2.0]
        history["panel_cycles/deck/sag_most_m"] = [0.05, 0.03, 0.01, 0.02]


def orbit(along_mm: float) -> dict[str, list[float]]:
    return {"amplitude_m": [1e-3 * abs(along_mm), 0.0, 0.0]}


def test_relative_amplitude(case: Path) -> None:
    (line,) = compared(case, ROW)
    assert line.measured == pytest.approx(sum(moved_mm(70)), rel=1e-6)
    assert line.error == pytest.approx(sum(moved_mm(70)) / 6 - 1, rel=1e-6)
    assert line.verdict == "NOT MET"


def test_bands_and_fits(case: Path) -> None:
    met = ROW.replace("[5.4, 6.6]", "[8.0, 9.0]")
    found = compared(case, met + met + "fitted = true\n")
    assert [line.verdict for line in found] == ["met", "met (fitted)"]


@pytest.mark.parametrize(
    ("quantity", "unit", "expected"),
    [("growth", "%", 100 * (moved_mm(90)[0] / moved_mm(60)[0] - 1)), ("lowest-at", "rad/s", 78.0)],
)
def test_quantities_of_a_sweep(case: Path, quantity: str, unit: str, expected: float) -> None:
    """A parabola through three of its points is the parabola."""
    row = ROW.replace('at = "70"\n', f'compare = "{quantity}"\n').replace('"mm"', f'"{unit}"')
    (line,) = compared(case, row.replace("driven-driving", "driving"))
    assert line.measured == pytest.approx(expected, rel=1e-6)


def test_the_arch_of_a_panel(case: Path) -> None:
    row = ROW.replace("amplitude", "arch").replace("driven-driving", "deck")
    (line,) = compared(case, row)
    assert line.measured == pytest.approx(20.0)  # mm; the first half of the run does not count


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("driven-driving", "nowhere"), 'no point "nowhere"'),
        (('at = "70"', 'at = "71"'), "no run with speed_rad_per_s = 71"),
    ],
)
def test_what_the_runs_do_not_tell(case: Path, change: tuple[str, str], said: str) -> None:
    (line,) = compared(case, ROW.replace(*change))
    assert line.measured is None
    assert not line.is_good
    assert said in line.value_in_words


def test_a_run_without_first_harmonics_says_why(case: Path) -> None:
    compared(case, ROW)
    folder = case.parent / "out/speed/speed_rad_per_s-70"
    seldom = "the series have 1.8 rows in a cycle of 0.0898 s; 20 are needed"
    write_summary(folder, {"status": "done", "results": {"missing": {"orbits": seldom}}})
    (line,) = compared(case, ROW)
    assert line.value_in_words.endswith(seldom)


def test_a_run_that_failed_is_no_value(case: Path) -> None:
    compared(case, ROW)
    write_summary(case.parent / "out/speed/speed_rad_per_s-70", {"status": "failed"})
    (line,) = compared(case, ROW)
    assert (line.value_in_words, line.verdict) == ("speed_rad_per_s-70: failed", "NOT MET")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('run = "speed"', 'run = "load"'), 'criteria.0.run: no run "load"'),
        (("amplitude", "amplitudes"), 'no measure "amplitudes"'),
        (('what = "a"\n', ""), "what: missing"),
        (("what = ", "whut = "), 'did you mean "what"?'),
    ],
)
def test_a_wrong_table_is_said(case: Path, change: tuple[str, str], said: str) -> None:
    with pytest.raises(CaseError) as caught:
        compared(case, ROW.replace(*change))
    assert said in str(caught.value)


def test_the_file_has_every_row(case: Path) -> None:
    found = compared(case, ROW)
    none = replace(found[0], measured=None, why="not run")
    file = write_verdicts([*found, none], case, "paper")[0]
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert [row["verdict"] for row in rows] == ["NOT MET", "NOT MET"]
    assert float(rows[0]["value"]) == pytest.approx(sum(moved_mm(70)), rel=1e-6)
    assert rows[1]["measured"] == "not run"


@pytest.mark.parametrize("case_folder", sorted(Path(__file__).parents[1].glob("cases/*/criteria.toml")))
def test_every_papers_table_is_right(case_folder: Path) -> None:
    """Its bands hold the paper's own values."""
    for row in read_criteria(case_folder.parent).criteria:
        if row.band is not None:
            low, high = row.band
            assert low is not None
            assert high is not None
            assert low < high
            assert row.reference is None or low <= row.reference <= high


def test_what_cannot_be_compared_is_shown(case: Path) -> None:
    (line,) = compared(case, ROW.replace("band = [5.4, 6.6]\n", ""))
    assert line.measured == pytest.approx(sum(moved_mm(70)), rel=1e-3)
    assert line.verdict == "not compared"


def test_a_sweep_may_be_cut(case: Path) -> None:
    (whole,) = runs_of(case).values()
    assert whole.between((65, 85)).values.tolist() == [70.0, 80.0]


def test_values_that_are_no_numbers(case: Path) -> None:
    """Whole tables, in the order given; a range of them cannot be asked for."""
    (runs,) = runs_of(case).values()
    values = ["[0.0035, 0, 0]", "[0.0015, 0, 0]"]
    points = [replace(runs.points[n], value=value) for n, value in enumerate(values)]
    tables = Runs(tuple(points), runs.vary)
    assert [point.value for point in tables.between(None).points] == values
    with pytest.raises(Unknown, match="is no number"):
        tables.between((0, 1))


def test_results_and_their_change_over_a_sweep(case: Path) -> None:
    """Numbers of the results by their path; shares where the summary has percents."""
    rows = [
        ROW.replace('at = "70"\n', part)
        .replace('"amplitude"', f'"{measure}"')
        .replace('"driven-driving"', f'"results.{path}"')
        .replace("5.4, 6.6", band)
        .replace('"mm"', f'"{unit}"')
        for measure, part, path, band, unit in (
            ("result", 'at = "80"\n', "screening.efficiency_percent", "79.9, 80.1", "%"),
            ("result", 'compare = "change"\n', "screening.efficiency_percent", "29.9, 30.1", "%"),
            ("result", 'compare = "change"\n', "bed.velocity_m_per_s", "2.9, 3.1", "m/s"),
            ("result", 'at = "80"\n', "screening.sections.0.depth_m", "0.79, 0.81", "m"),
            ("rise", 'at = "80"\n', "screening.sections.*.depth_m", "-0.11, -0.09", "m"),
            ("result", 'at = "80"\n', "screening.absent.value_m", "0, 1", "m"),
        )
    ]
    *known, unknown = compared(case, "".join(rows))
    assert [line.verdict for line in known] == ["met"] * 5
    assert "absent" in unknown.value_in_words
