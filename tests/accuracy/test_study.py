"""``flipflow study accuracy`` from outside, on a ball on a strip: orders, files, going on."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from statistics import median

import pytest
from pyarrow import parquet

from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.cli.planning import time_by_study
from orchestrator.output.records.run_folder import write_case
from orchestrator.output.records.summary import write_summary
from orchestrator.output.results.quantities import Question, Unknown, number_of
from orchestrator.preflight.judge import load_judged
from orchestrator.studies.accuracy.combinations import DECISIVE, StudyRequest
from orchestrator.studies.accuracy.convergence import MeasuredSeries
from orchestrator.studies.accuracy.report import write_study
from orchestrator.studies.accuracy.stored import find_study
from orchestrator.studies.accuracy.study import AccuracyStudy, plan_study, run_study
from orchestrator.studies.points import CaseStudy, Crew
from orchestrator.workbench import Case
from tests.runs.outside import ROOT, flipflow

pytestmark = [pytest.mark.slow, pytest.mark.process]
BALL = ROOT / "cases/ball-on-panel"
# Nothing is lost in the contact, and the strip's cells resolve what its bending makes of the clamps
SETS = (
    "bed.particles.ball.position_m=[0.152, 0.10, 0.014]",
    "duration_s=0.05",
    "particles.step_s=5e-5",
    "panel.cells=[44, 1]",
    "contacts.0.restitution=1.0",
    "contacts.1.restitution=1.0",
    "monitor.largest_created_in_total=1.0",  # coarse intervals are studied, too, not condemned
)
# The error of the particles' step, of first order, stays below that of the interval
FINE_STEPS = ("coupling.scheme=particles-first", "particles.step_s=2.5e-5")


def asked(out: Path, parameters: tuple[str, ...], *sets: str) -> StudyRequest:
    return StudyRequest(
        CaseStudy(BALL, "draft", (*SETS, *sets), out, Crew(2)), parameters, 3, 1, 600.0, DECISIVE
    )


def made(wanted: StudyRequest) -> AccuracyStudy:
    """A study with all its runs, each of which is done."""
    steps = run_study(wanted)
    while True:
        try:
            line = next(steps)
        except StopIteration as end:
            study: AccuracyStudy = end.value
            return study
        assert "done" in line, line


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("accuracy") / "ball"


@pytest.fixture(scope="module")
def study(out: Path) -> AccuracyStudy:
    return made(asked(out, ("sync", "panel-mesh"), *FINE_STEPS))


def family(study: AccuracyStudy, parameter: str) -> MeasuredSeries:
    return next(each for each in study.measured_series if each.series.parameter == parameter)


def observed_order(series: MeasuredSeries) -> float:
    """Return the median order of the shape and the quantities that decide, where errors fall along a line."""
    names = {"shape", *DECISIVE} & series.orders.keys()
    return median(series.orders[name].order for name in names if series.orders[name].is_clean)


def test_particles_first_is_of_second_order(study: AccuracyStudy) -> None:
    """The order holds in motion and in the energy that the scheme creates, as in theory
    (docs/theory/coupling.md)."""
    series = family(study, "sync")
    for name in ("deflection_m", "shape", "energy_defect"):
        assert series.orders[name].order == pytest.approx(series.series.expected, abs=0.25)
        assert series.orders[name].is_clean


def test_a_strip_is_of_second_order_in_its_cells(study: AccuracyStudy) -> None:
    """Median of the quantities that decide.  They scatter about 2, as the ball's place lies elsewhere between
    the strip's corners in each mesh."""
    series = family(study, "panel-mesh")
    assert observed_order(series) == pytest.approx(2.0, abs=0.6)
    assert series.errors[0]["shape"].value > 3 * series.errors[1]["shape"].value


def test_a_criterion_may_ask_for_what_studies_compare_by(study: AccuracyStudy) -> None:
    run = study.base.runs[0].folder
    assert number_of(Question(measure="deflection_m"), run) == study.base.mean("deflection_m")
    with pytest.raises(Unknown, match="passing_kg_per_s is not known"):
        number_of(Question(measure="passing_kg_per_s"), run)


def test_a_study_of_nothing_says_so(out: Path) -> None:
    """The ball hangs above the panel for the whole run: 0 % of nothing is no accuracy."""
    sets = ("gravity_m_per_s2=[0, 0, 0]", "bed.particles.ball.position_m=[0.152, 0.10, 0.09]")
    with pytest.raises(CaseError) as refused:
        made(asked(out.with_name("nothing"), ("sync",), *sets))
    (problem,) = refused.value.problems
    assert (problem.file, problem.kind) == (str(out.with_name("nothing") / "base"), "conflict")


def test_a_seed_that_finds_no_room_is_a_problem_of_the_case(tmp_path: Path) -> None:
    """298 stones find room by the case's own random numbers, and not by those of all other seeds."""
    stones = ("bed.blocks.coal.count=298", "bed.blocks.coal.shape=stone")
    study = CaseStudy(ROOT / "cases/quickstart", "draft", stones, tmp_path, Crew(1))
    study.check()
    with pytest.raises(CaseError, match="fit in the box"):
        plan_study(StudyRequest(study, ("sync",), 3, 6, 600.0, DECISIVE))


def test_a_study_without_a_quantity_that_decides_says_so(study: AccuracyStudy, out: Path) -> None:
    """No particle leaves this panel, so that no efficiency can be wrong."""
    with pytest.raises(CaseError) as refused:
        made(replace(study.request, judged_by=("efficiency_percent",)))
    (problem,) = refused.value.problems
    assert (problem.file, problem.kind) == (str(out / "base"), "conflict")
    assert "efficiency_percent" in problem.what


def test_a_failed_run_of_another_case_is_not_taken_for_one_of_this(out: Path) -> None:
    """The case that failed has been changed since."""
    request = asked(out.with_name("changed"), ("sync",))
    run = plan_study(request).points[0].runs[0]
    run.folder.mkdir(parents=True)
    write_summary(run.folder, {"status": "failed", "reason": "the panel became unstable"})
    write_case(run.folder, load_judged(BALL, "draft", ["panel.cells=[11, 1]"]))
    with pytest.raises(FolderUnusable, match=str(run.folder)):
        made(request)
    assert not (run.folder / "history.h5").exists()


def test_serial_staggered_is_of_first_order(out: Path) -> None:
    """The largest deflection, off by 0.02 % only, is not of first order: the ball leaves before it comes."""
    sets = ("coupling.scheme=serial-staggered",)
    series = family(made(asked(out.with_name("serial"), ("sync",), *sets)), "sync")
    assert series.series.expected == 1.0
    for name in ("shape", "energy_defect"):
        assert series.orders[name].order == pytest.approx(1.0, abs=0.25)
    assert observed_order(series) == pytest.approx(1.0, abs=0.25)


@pytest.mark.parametrize(
    ("sets", "quantity", "order"),
    [
        (("panel.solver=rigid", "coupling.sync_interval_s=2e-4"), "clamp_rms_N", 2.0),
        (("coupling.scheme=robin", "coupling.sync_interval_s=1e-4"), "shape", 2.0),
        (("coupling.scheme=particles-first",), "shape", 2.0),
    ],
    ids=["rigid", "robin", "particles-first"],
)
def test_the_particles_step_is_of_the_order_expected(
    out: Path, sets: tuple[str, ...], quantity: str, order: float
) -> None:
    """2 where a contact loses nothing, also where the surface jumps at sync points."""
    name = "-".join(("step", *sets)).replace("/", "")
    series = family(made(asked(out.with_name(name), ("particle-step",), *sets)), "particle-step")
    assert series.series.expected == order
    assert series.orders[quantity].order == pytest.approx(order, abs=0.3)


def test_what_is_proposed_together_keeps_what_it_promises(study: AccuracyStudy) -> None:
    """Every proposal was run and is off by at most twice what was predicted, and 0.1 %; the
    reference is the finest of them and the best there is of each parameter."""
    table = study.rows
    assert study.reference in study.proposals
    best = study.measured[study.reference].settings
    assert {axis: choice.h for axis, choice in best.items()} == {"coupling": 4e-5, "panel": 0.5}
    for row in table:
        if row.proposal and row.error:
            assert row.error.value < 2 * row.proposal.error + 1e-3
    front = study.front()
    costs = [row.point.processor_s for row in front]
    assert costs == sorted(costs)
    own = study.reference_error
    assert own is not None
    for tolerance in (own / 2, 1.1 * own, 4 * own):
        row = study.recommend(tolerance).row
        assert (row is None) is (tolerance < own)
        if row is not None:
            assert (row.error.value if row.error else 0.0) + own <= tolerance
    assert study.recommend(4 * own).is_proven


def test_called_again_nothing_is_run_and_the_files_are_there(study: AccuracyStudy, out: Path) -> None:
    """The command line finds all that was done, and the tables agree with each other."""
    before = {file: file.stat().st_mtime_ns for file in out.glob("*/summary.json")}
    sets = [word for each in (*SETS, *FINE_STEPS) for word in ("--set", each)]
    words = ["study", "accuracy", str(BALL), "--level", "draft", "--out", str(out), "--quick"]
    done = flipflow(*words, "--parameters", "sync,panel-mesh", "--workers", "2", *sets)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.count("done before") == len(before)
    assert {file: file.stat().st_mtime_ns for file in out.glob("*/summary.json")} == before
    table = list(csv.DictReader((out / "accuracy.csv").read_text().splitlines()))
    arrow = parquet.read_table(out / "accuracy.parquet").to_pylist()
    assert [row["point"] for row in table] == [row["point"] for row in arrow]
    assert len(table) == len(before) - 1  # the short part is no point
    stored = json.loads((out / "accuracy.json").read_text())
    assert stored["reference"] == study.reference
    assert all(0 < int(row["side_by_side"]) <= 2 for row in table)
    page = (out / "accuracy.html").read_text()
    assert page.count("data:image/png") == len(list(out.glob("*.png"))) == 4


def test_what_would_be_run_is_listed_first(tmp_path: Path) -> None:
    words = ["study", "accuracy", str(BALL), "--level", "draft", "--dry", "--quick"]
    done = flipflow(*words, "--parameters", "sync,number", "--out", str(tmp_path / "x"))
    assert done.returncode == 0, done.stderr
    assert "not offered: number: single particles stand for themselves" in done.stdout
    assert done.stdout.count("1 to be run") == 4
    assert not (tmp_path / "x").exists()
    wrong = flipflow(*words, "--parameters", "synch")
    assert (wrong.returncode, 'did you mean "sync"?' in wrong.stderr) == (2, True)
    for unknown in ("shape", "deflection_m=3", "sync"):  # the first is compared, but has no value of its own
        wrong = flipflow(*words, "--quantities", unknown)
        assert (wrong.returncode, f'no "{unknown}"' in wrong.stderr) == (2, True)
    twice = flipflow(*words, "--parameters", "sync,sync", "--out", str(tmp_path / "x"))
    assert twice.stdout.count("1 to be run") == 4


def test_a_plan_by_the_study_is_one_of_its_short_run(study: AccuracyStudy, out: Path) -> None:
    """The command tools/plan_series.py measures how well predicted times are kept."""
    write_study(study, out)
    stored = find_study(Case(load_judged(BALL, "draft")), out / "accuracy.json")
    assert stored is not None
    timing, own_s = time_by_study(stored, BALL, "draft"), study.base.processor_s
    short_s, long_s = (timing.wall_s(own_s, duration_s) for duration_s in (0.05, 0.1))
    assert timing.start_s < short_s < long_s < 2 * short_s
    assert timing.duration_s(own_s, short_s, 1.0) == pytest.approx(0.05)


def test_answers_known_from_elsewhere_stand_beside_every_point(tmp_path: Path) -> None:
    """A plate is driven: what is recorded misses its top by at most (w H)^2 / 8 between two sync
    points, H = 0.8 ms at most.  All are alike, so that the finest is the reference."""
    words = ["study", "accuracy", str(ROOT / "cases/bushing-hysteresis"), "--quick"]
    words += ["--parameters", "sync,particle-step"]
    done = flipflow(*words, "--out", str(tmp_path / "x"))
    assert done.returncode == 0, done.stdout + done.stderr
    table = list(csv.DictReader((tmp_path / "x/accuracy.csv").read_text().splitlines()))
    assert len(table) == 3
    for row in table:
        assert float(row["against amplitude of the plate"]) < (78.5 * 8e-4) ** 2 / 8
        assert float(row["against largest speed of the plate"]) < (78.5 * 8e-4) ** 2 / 8
        assert (row["kind"] == "reference") == row["sets"].endswith("=0.0002")
    page = (tmp_path / "x/accuracy.html").read_text()
    assert "the case has no particles" in page
    assert "the drive that is given" in page
