"""A case against its paper, on runs whose motion is made up: what is found, met and refused."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.cli.studies.paper import command
from orchestrator.output.records.history import HISTORY_FORMAT
from orchestrator.output.records.summary import write_summary
from orchestrator.output.results.quantities import Unknown
from orchestrator.studies.criteria import Runs, read_criteria, wanted_runs
from orchestrator.studies.paper import find_papers
from orchestrator.studies.points import CaseStudy, Point
from orchestrator.studies.verdicts import CriterionResult, judge, write_verdicts
from tests.cases import CASE, case_folder, keys_and_kinds

SPEED = "screen.exciters.shaft.speed_rad_per_s"
DRIVEN = (
    "[screen.frames.driven]\nmass_kg = 30.0\ninertia_kg_m2 = [1.0, 2.0, 2.0]\n"
    "center_of_mass_m = [0.0, 0.1, 0.0]\n"
)
HELD = (
    '[screen.bushings.shear]\nbetween = ["driving", "driven"]\n'
    "positions_m = [[0.0, 0.1, 0.0]]\nstiffness_N_per_m = [1e4, 1e4, 1e4]\n"
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
fact = "stroke"
band = [5.4, 6.6]
"""


HALF_WIDTH_MM = 0.05
FILES = ("paper.csv", "paper.md", "paper_facts.csv", "paper.html")


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
    """Return the comparison with runs in which both frames swing along x, against each other."""
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
    width_m = 1e-3 * HALF_WIDTH_MM
    return {"amplitude_m": [1e-3 * abs(along_mm), 0.0, 0.0], "half_width_m": [width_m, 0.0, 0.0]}


def test_relative_amplitude(case: Path) -> None:
    (line,) = compared(case, ROW)
    assert line.measured == pytest.approx(sum(moved_mm(70)), rel=1e-6)
    assert line.error == pytest.approx(sum(moved_mm(70)) / 6 - 1, rel=1e-6)
    assert line.verdict == "NOT MET"


def test_bands_and_fits(case: Path) -> None:
    met = ROW.replace("[5.4, 6.6]", "[8.0, 9.0]")
    lines = compared(case, met + met + 'ours = "fitted"\n' + ROW + 'ours = "fitted"\n')
    assert [line.verdict for line in lines] == ["met", "fitted, inside", "fitted, OUTSIDE"]
    assert all(line.is_good for line in lines)


def test_a_band_from_own_theory_is_never_met(case: Path) -> None:
    own = 'band_from = "own-theory"\n'
    inside, outside = compared(case, ROW.replace("[5.4, 6.6]", "[8.0, 9.0]") + own + ROW + own)
    assert (inside.verdict, outside.verdict) == ("as own theory", "NOT as own theory")
    assert [line.is_good for line in (inside, outside)] == [True, False]


def test_a_band_is_the_sources_error_to_both_sides(case: Path) -> None:
    """The stroke is 8.64 mm: nine tenths of a millimetre from the reference is inside, half of one is not."""
    assert sum(moved_mm(70)) == pytest.approx(8.64)
    rows = [
        ROW.replace("6.0", reference).replace("band = [5.4, 6.6]", f"error = {error}")
        for reference, error in (("8.0", 0.9), ("8.0", 0.5), ("9.2", 0.9), ("9.2", 0.5))
    ]
    lines = compared(case, "".join(rows))
    assert [line.verdict for line in lines] == ["met", "NOT MET", "met", "NOT MET"]
    assert lines[0].band_in_words == "7.1 to 8.9 mm"
    assert lines[0].reference_in_words == "8 ± 0.9 mm"


def test_a_band_that_begins_or_ends_at_zero_is_only_a_sign(case: Path) -> None:
    """The frames swing further against each other at 90 than at 60 rad/s."""
    growth = ROW.replace('at = "70"\n', 'compare = "growth"\nbetween = [60, 90]\n').replace('"mm"', '"%"')
    growth = growth.replace("reference = 6.0\n", "")
    rows = [growth.replace("[5.4, 6.6]", band) for band in ("[0, 100]", "[-100, 0]", "[1, 100]")]
    lines = compared(case, "".join(rows))
    assert lines[0].measured == pytest.approx(100 * (sum(moved_mm(90)) / sum(moved_mm(60)) - 1))
    assert [line.verdict for line in lines] == ["sign only", "NOT MET", "met"]
    assert [line.is_good for line in lines] == [True, False, True]


@pytest.mark.parametrize("compare", ["growth", "ratio"])
def test_a_number_relative_to_zero_is_none(case: Path, compare: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("orchestrator.output.results.quantities.number_of", lambda question, run: 0.0)
    still = ROW.replace('at = "70"', f'compare = "{compare}"\nagainst = "speed"')
    (line,) = compared(case, still)
    assert (line.measured, line.verdict, line.why[:11]) == (None, "no number", "is relative")


def test_the_distance_is_in_the_papers_unit_and_in_per_cent(case: Path) -> None:
    (line,) = compared(case, ROW)
    assert line.distance == pytest.approx(sum(moved_mm(70)) - 6)
    assert line.distance_in_words == "+2.6 mm (+44 %)"


def test_intervals(case: Path) -> None:
    """The intervals are those of one run, of a growth between two runs in quadrature, and by the scatter of
    other runs."""
    growth = ROW.replace('at = "70"\n', 'compare = "growth"\nbetween = [60, 90]\n').replace('"mm"', '"%"')
    scatter = ROW + 'scatter = "seeds"\n'
    seeds = '[runs.seeds]\nvary = "screen.exciters.shaft.speed_rad_per_s=60,70"\n'
    (case / "criteria.toml").write_text(HEAD + seeds + ROW + growth + scatter)
    runs = runs_of(case)
    for each in runs.values():
        for point in each.points:
            fake(point)
    steady, grown, scattered = (judge("case", row, runs) for row in read_criteria(case).criteria)
    assert steady.half_width == pytest.approx(HALF_WIDTH_MM)
    assert f"± {HALF_WIDTH_MM:.2g} mm" in steady.value_in_words
    first, last = sum(moved_mm(60)), sum(moved_mm(90))
    expected = np.hypot(HALF_WIDTH_MM / first, last / first - last / (first + HALF_WIDTH_MM))
    assert grown.half_width == pytest.approx(100 * expected, rel=1e-6)
    spread = abs(sum(moved_mm(70)) - sum(moved_mm(60))) / np.sqrt(2)
    assert scattered.half_width == pytest.approx(12.706 * spread, rel=1e-4)  # Student, one degree of freedom
    alone = (case / "criteria.toml").read_text().replace("s=60,70", "s=60")
    (case / "criteria.toml").write_text(alone)
    assert judge("case", read_criteria(case).criteria[2], runs_of(case)).half_width is None


@pytest.mark.parametrize("theirs", [10.0, 9.5, 10.5, 40.0])
def test_the_interval_of_a_difference_does_not_depend_on_its_sign(case: Path, theirs: float) -> None:
    """The runs have 10 and ``theirs``, both plus or minus 1: near zero as well as far from it."""
    row = ROW.replace('"amplitude"', '"result"').replace("driven-driving", "results.power.drives_W")
    row = row.replace('"mm"', '"W"') + 'compare = "difference"\nagainst = "other"\n'
    (case / "criteria.toml").write_text(HEAD + "[runs.other]\n" + row)
    runs = runs_of(case)
    for run, value in ((runs["speed"].at("70"), 10.0), (runs["other"], theirs)):
        power = {"drives_W": {"value": value, "half_width": 1.0, "batches": 20}}
        run.points[0].folder.mkdir(parents=True)
        write_summary(run.points[0].folder, {"status": "done", "results": {"power": power}})
    (criterion,) = read_criteria(case).criteria
    line = judge("case", criterion, runs)
    assert line.measured == pytest.approx(abs(theirs - 10.0))
    assert line.half_width == pytest.approx(np.sqrt(2.0))


def test_criteria_over_those_of_another_case(case: Path) -> None:
    """Its own runs, all criteria but those from the other case's own theory."""
    (case / "criteria.toml").write_text(HEAD + ROW + ROW + 'band_from = "own-theory"\n')
    other = case.parent / "other"
    other.mkdir()
    text = 'base = "../case"\n[runs.speed]\nvary = "screen.exciters.shaft.speed_rad_per_s=70"\n'
    (other / "criteria.toml").write_text(text + ROW.replace("relative", "own"))
    criteria = read_criteria(other)
    assert [row.of for row in criteria.criteria] == ["driven-driving"] * 2
    assert criteria.runs["speed"].vary.endswith("=70")
    assert criteria.source == read_criteria(case).source
    (other / "criteria.toml").write_text(text.replace("../case", "../nowhere"))
    with pytest.raises(CaseError, match=r'base: "\.\./nowhere" is not another case with criteria\.toml'):
        read_criteria(other)


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
    ("change", "message"),
    [
        (("driven-driving", "nowhere"), 'no point "nowhere"'),
        (('at = "70"', 'at = "71"'), "no run with speed_rad_per_s = 71"),
    ],
)
def test_what_the_runs_do_not_tell(case: Path, change: tuple[str, str], message: str) -> None:
    (line,) = compared(case, ROW.replace(*change))
    assert line.measured is None
    assert not line.is_good
    assert message in line.value_in_words


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
    assert line.measured is None
    assert {"speed_rad_per_s-70:", "failed"} <= {*line.value_in_words.split()}


@pytest.mark.parametrize(
    ("change", "kind"),
    [
        (('run = "speed"', 'run = "load"'), "criteria.0.run: unknown-name"),
        (("amplitude", "amplitudes"), "criteria.0.measure: unknown-name"),
        (('what = "a"\n', ""), "criteria.0.what: missing"),
        (("what = ", "whut = "), "criteria.0.whut: unknown-key"),
        (('unit = "mm"', 'unit = "mm"\naxis = "size"'), "criteria.0.axis: wrong-type"),
        (('unit = "mm"', 'unit = "N"'), "criteria.0.unit: wrong-type"),
    ],
)
def test_a_wrong_table_is_said(case: Path, change: tuple[str, str], kind: str) -> None:
    with pytest.raises(CaseError) as caught:
        compared(case, ROW.replace(*change))
    assert keys_and_kinds(caught.value.problems) == [kind]


def test_the_file_has_every_row(case: Path) -> None:
    lines = compared(case, ROW)
    none = replace(lines[0], measured=None, why="not run")
    file = write_verdicts([*lines, none], case, "paper")[0]
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert [row["verdict"] for row in rows] == ["NOT MET", "no number"]
    assert float(rows[0]["value"]) == pytest.approx(sum(moved_mm(70)), rel=1e-6)
    assert rows[1]["measured"] == "not run"


@pytest.mark.parametrize("case_folder", sorted(Path(__file__).parents[1].glob("cases/*/criteria.toml")))
def test_every_papers_table_is_right(case_folder: Path) -> None:
    """Its bands hold the paper's own values, and are two-sided where a size is published."""
    for row in read_criteria(case_folder.parent).criteria:
        if row.limits is not None:
            low, high = row.limits
            assert row.reference is None or not row.is_sign_only
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
    with pytest.raises(Unknown, match="is not a number"):
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


def test_one_printed_number_is_not_counted_twice(case: Path) -> None:
    """Two of our numbers beside one reference must say whether they are one fact."""
    bare = ROW.replace('fact = "stroke"\n', "")
    with pytest.raises(CaseError) as caught:
        compared(case, bare + bare)
    assert keys_and_kinds(caught.value.problems) == ["criteria.1.fact: missing"]
    for other in (bare + 'ours = "fitted"\n', bare.replace("6.0", "6.1"), bare.replace("band", "#")):
        assert compared(case, bare + other)


def papers_of(folder: Path) -> tuple[CaseStudy, list[str]]:
    """The study of a folder of cases with runs, and what its command says without runs of its own."""
    study = CaseStudy(folder, out=folder / "out")
    for paper, _ in find_papers(study):
        for point in paper.points:
            if not point.folder.exists():
                fake(point)
    output = command(study, dry=True)
    return study, [str(item) for item in output if isinstance(item, Path)]


def test_all_papers_of_a_folder_are_one_table(case: Path) -> None:
    """Cases without a source are no papers; each judged number comes with distance and interval, and those
    that prove nothing are counted."""
    fitted = ROW.replace("[5.4, 6.6]", "[8.0, 9.0]") + 'ours = "fitted"\n'
    for name, text in (("other", HEAD + fitted), ("known", HEAD.partition("\n")[2] + ROW)):
        case_folder(case.parent / name, (case / "case.toml").read_text())
        (case.parent / name / "criteria.toml").write_text(text)
    study, files = papers_of(case.parent)
    assert files == [str(study.folder / name) for name in FILES]
    rows = list(csv.DictReader((study.folder / "paper.csv").read_text().splitlines()))
    assert [(row["case"], row["ours"]) for row in rows] == [("case", "predicted"), ("other", "fitted")]
    text = (study.folder / "paper.md").read_text()
    assert "Of 1 facts: 1 NOT MET." in text
    assert "| stroke | a, case | 6 mm | 8.64 ± 0.05 mm | NOT MET |" in text
    (fact,) = csv.DictReader((study.folder / "paper_facts.csv").read_text().splitlines())
    assert (fact["distance"], fact["band"]) == ("+2.6 mm (+44 %)", "5.4 to 6.6 mm")
    assert "a, other" not in text
    cases = "- made up\n  - case: Of 1 numbers: 1 NOT MET.\n  - other: Of 1 numbers: 1 fitted, inside.\n"
    assert cases in text
    assert (study.folder / "paper.html").read_text().count("<td>a</td>") == 2


def two_readings(case: Path) -> None:
    """Two cases beside one fact, which one of them meets, and beside another one."""
    met = ROW.replace("[5.4, 6.6]", "[8.0, 9.0]")
    slow = ROW.replace('"a"', '"b"').replace('"stroke"', '"slow stroke"').replace('at = "70"', 'at = "60"')
    (case / "criteria.toml").write_text(HEAD + slow.replace("[5.4, 6.6]", "[6.0, 12.0]") + met)
    case_folder(case.parent / "other", (case / "case.toml").read_text())
    (case.parent / "other" / "criteria.toml").write_text(HEAD + met + ROW.replace('"a"', '"c"'))


def test_a_fact_counts_once_with_its_worst_number_and_misses_come_first(case: Path) -> None:
    two_readings(case)
    study, _ = papers_of(case.parent)
    text = (study.folder / "paper.md").read_text()
    assert "Of 2 facts: 1 NOT MET, 1 met." in text
    (line,) = (line for line in text.splitlines() if line.endswith(("NOT MET |", "met |")))
    assert line.startswith("| stroke | c, other | ")
    assert "\n- **Met**: slow stroke.\n- **stroke**: 2 of 3 numbers are met.\n" in text
    facts = [*csv.DictReader((study.folder / "paper_facts.csv").read_text().splitlines())]
    assert [row["fact"] for row in facts] == ["stroke", "stroke", "stroke", "slow stroke"]
    assert [row["number"] for row in facts] == ["c, other", "a, case", "a, other", "b, case"]
    assert [row["verdict"] for row in facts] == ["NOT MET", "met", "met", "met"]
    page = (study.folder / "paper.html").read_text()
    assert page.index("slow stroke") > page.index("<td>stroke")


def test_the_page_of_recorded_numbers_needs_no_run(case: Path) -> None:
    """The page of a table is that of the runs from which the table was written."""
    two_readings(case)
    study, _ = papers_of(case.parent)
    table = study.folder / "paper.csv"
    rows = (study.folder / "paper.md").read_text().splitlines()
    again = replace(study, out=case.parent / "again")
    assert [*command(again, recorded=table)]
    text = (again.folder / "paper.md").read_text()
    assert [line for line in text.splitlines() if line not in rows] == [
        f"`flipflow study paper {case.parent} --recorded {table}` makes this page. "
        "Of 2 facts: 1 NOT MET, 1 met."
    ]
    head = "case,criterion,value,half width,unit,note\n"
    table.write_text(head + "case,a,8.5,,mm,an old run\ncase,b,,,mm,\nnowhere,a,1,,mm,\n")
    assert [*command(again, recorded=table)]
    text = (again.folder / "paper.md").read_text()
    assert "\ncase: an old run\n" in text
    assert ",8.5 mm," in (again.folder / "paper_facts.csv").read_text()
    assert "| slow stroke | b, case | 6 mm | no number |" in text
    assert "not recorded" in text


@pytest.mark.parametrize(
    ("table", "kind"),
    [
        ("case,criterion,value,unit\n", "half width: missing"),
        ("case,criterion,value,half width,unit\ncase,aa,1,,mm\n", "case.aa: unknown-name"),
        ("case,criterion,value,half width,unit\ncase,a,1,,m\n", "case.a: unit"),
        ("case,criterion,value,half width,unit\ncase,a,one,,mm\n", "0.value: wrong-type"),
        (None, ": file"),
    ],
)
def test_a_wrong_table_of_recorded_numbers_is_refused(case: Path, table: str | None, kind: str) -> None:
    file = case.parent / "recorded.csv"
    if table is not None:
        file.write_text(table)
    study = CaseStudy(case, out=case.parent / "out")
    with pytest.raises(CaseError) as caught:
        [*command(study, recorded=file)]
    assert keys_and_kinds(caught.value.problems) == [kind]
    assert not study.folder.exists()


def test_a_number_without_a_run_is_no_verdict(case: Path) -> None:
    study = CaseStudy(case, out=case.parent / "out")
    assert list(command(study, dry=True))
    assert "Of 1 facts: 1 no number." in (study.folder / "paper.md").read_text()


def test_the_level_of_the_criteria(case: Path) -> None:
    for name in ("draft", "fine"):
        (case / "levels").mkdir(exist_ok=True)
        (case / f"levels/{name}.toml").write_text("")
    (case / "criteria.toml").write_text('level = "fine"\n' + HEAD + ROW)
    ((paper, _),) = find_papers(CaseStudy(case))
    assert paper.level == "fine"
    ((paper, _),) = find_papers(CaseStudy(case, "draft"))
    assert paper.level == "draft"


def test_wrong_cases_of_a_folder_are_all_said(case: Path, tmp_path: Path) -> None:
    case_folder(case.parent / "other", (case / "case.toml").read_text())
    for folder in (case, case.parent / "other"):
        (folder / "criteria.toml").write_text(HEAD + ROW.replace("amplitude", "amplitudes"))
    with pytest.raises(CaseError) as caught:
        find_papers(CaseStudy(case.parent))
    assert [str(problem).partition(":")[0] for problem in caught.value.problems] == ["case", "other"]
    with pytest.raises(CaseError, match="is not a case, and has no case with a source"):
        find_papers(CaseStudy(tmp_path / "nowhere"))
