"""New cases from templates: they are right at once, reach the wanted stroke, and refuse the impossible."""

from __future__ import annotations

import math
import re
import shlex
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from orchestrator.case.materials.typical_feed import finer_share
from orchestrator.cli import new
from orchestrator.cli.main import app
from orchestrator.cli.proposal import levels, machine, two_mass
from orchestrator.cli.proposal import propose as propose_module
from orchestrator.cli.proposal.layout import lay_out, panel_length_m
from orchestrator.cli.proposal.proposal import Proposal, mean_stroke_m
from orchestrator.cli.proposal.propose import find_refusals, propose
from orchestrator.cli.proposal.wishes import TEMPLATES, ImpossibleWishes, read_wishes
from orchestrator.ports.plans import SolverMissing
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.cost import in_words
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.scene.shaking import solve_shakings
from orchestrator.preflight.stability.report import stability_report
from tests.grains import sphere_kg
from tests.runs.outside import flipflow, summary

CALL = CliRunner()
FREE = [name for name, template in TEMPLATES.items() if template.is_free]


@cache
def proposed(template: str) -> Proposal:
    return propose(read_wishes(template, {}), template)


@pytest.fixture
def mats_as_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Proposals without the trials that choose how mats are mounted, which take most of their time."""

    def missing(_: object) -> None:
        raise SolverMissing("no trial")

    monkeypatch.setattr(propose_module, "choose_mounting", missing)


def write(template: str, place: Path) -> Path:
    new.write_files(proposed(template).files, place / template)
    return place / template


def complaints(judged: JudgedCase) -> list[str]:
    stability = stability_report(judged.case)
    return [*map(str, find_problems(judged)), *warnings(judged), *stability.warnings()]


@pytest.mark.solver
@pytest.mark.parametrize("level", ["draft", "study"])
@pytest.mark.parametrize("template", TEMPLATES)
def test_a_new_case_is_right_at_once(template: str, level: str, tmp_path: Path) -> None:
    """The only exception is crushed stone as spheres on 20 degrees in a thin bed, which is told as a
    doubt."""
    complaints_found = complaints(load_judged(write(template, tmp_path), level))
    steep = [
        line for line in complaints_found if line.startswith("lone spheres may never reach a steady speed")
    ]
    assert complaints_found == steep
    assert len(steep) == (template in ("flip-flow", "crank-link"))
    assert [f"doubtful: {line}" for line in steep] == [
        line for line in proposed(template).remarks if line.startswith("doubtful")
    ]


@pytest.mark.solver
@pytest.mark.parametrize("template", FREE)
def test_the_case_itself_meets_the_closed_form_of_two_masses(template: str, tmp_path: Path) -> None:
    """The masses, bushings and unbalance of the written case give stroke and ratio, without the proposal."""
    case = load_judged(write(template, tmp_path), "draft").case.whole_machine
    moved = scene(case)
    assert mean_stroke_m(moved) == pytest.approx(0.006, rel=2e-3)
    frames, bushings = case.screen.frames, case.screen.bushings
    carried_kg = sum(spring.mass_kg for spring in moved.springs) / 2
    along = np.array([math.cos(math.radians(case.screen.inclination_deg)), 0.0, 0.0])
    along[2] = -math.sin(math.radians(case.screen.inclination_deg))
    shear = bushings["shear"]
    shear_N_per_m = len(shear.positions_m) * shear.stiffness_N_per_m[0]
    shear_N_per_m += sum(spring.stiffness_N_per_m * (spring.along @ along) ** 2 for spring in moved.springs)
    driving_kg, driven_kg = ((frames[name].mass_kg or 0.0) + carried_kg for name in ("driving", "driven"))
    ground = bushings["isolation"]
    amplitudes_m = two_mass.amplitudes_m(0.006, machine.RATIO)
    (speed,) = (exciter.speed_rad_per_s for exciter in case.screen.exciters.values())
    assert shear_N_per_m == pytest.approx(
        two_mass.shear_stiffness_N_per_m(driven_kg, speed, machine.RATIO), rel=1e-2
    )
    moment_kg_m = two_mass.mass_moment_kg_m(
        driving_kg, driven_kg, len(ground.positions_m) * ground.stiffness_N_per_m[0], speed, amplitudes_m
    )
    (given_kg_m,) = (exciter.mass_moment_kg_m for exciter in case.screen.exciters.values())
    assert given_kg_m == pytest.approx(moment_kg_m, rel=0.05)  # damping wants a little more
    (undamped,) = solve_shakings(moved.plan, moved.springs, loss_factor=0.0)
    driving_m, driven_m = (abs(undamped.amplitude_m[name] @ along) for name in ("driving", "driven"))
    assert driven_m / driving_m == pytest.approx(machine.RATIO, rel=0.03)


@pytest.mark.solver
def test_another_machine_has_its_own_stroke_and_a_draft_that_says_what_it_leaves_out(tmp_path: Path) -> None:
    """The feed has so many fine particles that the draft feeds only a part of them."""
    answers = {"stroke": "4 mm", "speed": "850 rpm", "width": "1.2 m", "panels": "15"}
    answers |= {"opening": "3 mm", "throughput": "100 t/h", "material": "iron ore"}
    proposal = propose(read_wishes("flip-flow", answers), "mine")
    assert mean_stroke_m(proposal.scene) == pytest.approx(0.004, rel=2e-3)
    assert proposal.draft.rate_share < 1
    assert f"{proposal.draft.rate_share:.0%} of the throughput" in proposal.files["levels/draft.toml"]
    new.write_files(proposal.files, tmp_path / "mine")
    judged = load_judged(tmp_path / "mine", "draft")
    rolling, warned = sorted(complaints(judged), reverse=True)
    assert rolling.startswith("lone spheres may never reach a steady speed")
    assert f"feeds {proposal.draft.rate_share:.0%} of the case's throughput" in warned
    assert f"doubtful: {warned}" in proposal.remarks
    assert judged.case.bed.feeds["iron-ore"].rate_kg_per_s < 100 / 3.6 * proposal.draft.rate_share
    assert levels.predicted_s(judged.case) == pytest.approx(proposal.run_s["draft"])


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_air_is_proposed_where_it_matters_to_the_finest_grains_of_the_study() -> None:
    """Coal of 0.75 mm falls with 3.7 m/s in the end (Schiller and Naumann) and is thrown with 2; limestone of
    3 mm, a quarter of the default opening, falls with 14."""
    answers = {"material": "coal", "opening": "3 mm", "throughput": "20 t/h"}
    fine = propose(read_wishes("flip-flow", answers), "mine")
    assert "[air]" in fine.files["case.toml"]
    (line,) = (line for line in fine.remarks if line.startswith("air:"))
    assert "0.75 mm" in line
    coarse = proposed("flip-flow")
    assert "[air]" not in coarse.files["case.toml"]
    assert not any(line.startswith("air:") for line in coarse.remarks)


IMPOSSIBLE: dict[str, tuple[str, dict[str, str], list[str]]] = {
    "shaken to pieces": (
        "flip-flow",
        {"stroke": "40 mm"},
        ["--stroke: out-of-range", "--stroke: out-of-range"],
    ),
    "torn": (
        "flip-flow",
        {"stroke": "20 mm", "length": "1.3 m"},
        ["--stroke: out-of-range", "--stroke: out-of-range"],
    ),
    "buried": (
        "flip-flow",
        {"throughput": "5000 t/h"},
        ["--throughput: out-of-range", "--throughput: out-of-range"],
    ),
    "all opening": ("flip-flow", {"opening": "200 mm"}, ["--opening: out-of-range"]),
    "one opening": ("flip-flow", {"opening": "100 mm"}, ["--opening: out-of-range"]),
    "short": ("flip-flow", {"length": "0.4 m"}, ["--length: out-of-range"]),
    "only clamps": (
        "flip-flow",
        {"panels": "28", "length": "1 m", "throughput": "5000 t/h"},
        ["--length: out-of-range", "--throughput: out-of-range"],
    ),
    "ranges in the answer's own unit": (
        "flip-flow",
        {"speed": "-750 rpm", "throughput": "1e9 t/h", "stroke": "0 mm", "slope": "80 deg"},
        ["--speed: wrong-type", "--throughput: wrong-type", "--stroke: wrong-type", "--slope: wrong-type"],
    ),
    "millimetres meant": ("flip-flow", {"stroke": "6"}, ["--stroke: wrong-type"]),
    "template and number": (
        "bananna",
        {"width": "12 Hz"},
        ["--template: unknown-name", "--width: wrong-type"],
    ),
    "slopes": ("banana", {"panels": "2"}, ["--slope: out-of-range"]),
    "material": ("flip-flow", {"material": "limstone"}, ["--material: unknown-name"]),
    "template": ("bananna", {}, ["--template: unknown-name"]),
    "units": (
        "flip-flow",
        {"width": "12 Hz", "speed": "2 m"},
        ["--width: wrong-type", "--speed: wrong-type"],
    ),
    "no numbers": (
        "flip-flow",
        {"panels": "2.5", "width": "wide"},
        ["--panels: wrong-type", "--width: wrong-type"],
    ),
    "one of many": (
        "banana",
        {"width": "nan", "slope": "20 deg, x"},
        ["--width: wrong-type", "--slope: wrong-type"],
    ),
    "not asked": ("test-rig", {"throughput": "5 t/h"}, ["--throughput: unknown-key"]),
    "on a rig": ("test-rig", {"material": "coal"}, ["--material: unknown-key"]),
    "two lengths": (
        "flip-flow",
        {"opening": "8 x 20 mm", "opening-length": "3 mm"},
        ["--opening-length: conflict"],
    ),
    "not grains": ("flip-flow", {"material": "garden waste"}, ["--material: unknown-name"]),
}


@pytest.mark.parametrize(("template", "answers", "kinds"), IMPOSSIBLE.values(), ids=IMPOSSIBLE)
def test_the_impossible_is_refused_with_all_reasons(
    template: str, answers: dict[str, str], kinds: list[str]
) -> None:
    """The words stand in tests/words."""
    with pytest.raises(ImpossibleWishes) as error:
        propose(read_wishes(template, answers), "mine")
    assert [f"{problem.file}: {problem.kind}" for problem in error.value.problems] == kinds


@pytest.mark.parametrize(
    ("option", "given", "others", "offered"),
    [
        ("length", "0.3 m", {"opening": "2 mm", "throughput": "4 t/h"}, r"at least (\S+ m)"),
        ("stroke", "18 mm", {}, r"at most (\S+ mm)"),
        ("stroke", "19 mm", {"length": "1 m", "speed": "300 rpm"}, r"at most (\S+ mm)"),
        ("throughput", "974 t/h", {}, r"at most (\S+ t/h)"),
        ("speed", "-1 rpm", {}, r"range (\S+) to \S+ (rpm)"),
        ("speed", "1 GHz", {"stroke": "0.5 mm"}, r"range \S+ to (\S+) (GHz)"),
    ],
)
def test_the_limit_that_a_refusal_offers_is_accepted(
    option: str, given: str, others: dict[str, str], offered: str
) -> None:
    (refusal,) = find_refusals("flip-flow", others | {option: given})
    limit = re.search(offered, str(refusal))
    assert limit is not None, refusal
    assert find_refusals("flip-flow", others | {option: " ".join(limit.groups())}) == []


def test_an_answer_of_blanks_is_left_to_the_template() -> None:
    wishes = read_wishes("flip-flow", {"width": " ", "slope": "", "opening-length": "  "})
    assert (wishes.width_m, wishes.slopes_deg, wishes.opening_length_m) == (2.0, (20.0,), 0.012)


ANALYSIS = "sieve;passing / %\n31,5 mm;100\n16 mm;72\nNo. 4;31\n63 µm;4\n"


def test_a_typical_feed_is_the_curve_of_its_material() -> None:
    """Fuller and Thompson: half of the mass below a quarter of the largest size; coal has an exponent of 0.8.

    Half an opening and less are there: 45 % of the default feed of 0 to 30 mm is finer than 6 mm.
    """
    for material, exponent in (("gravel", 0.5), ("coal", 0.8)):
        wishes = read_wishes("flip-flow", {"feed": "0-40 mm", "material": material})
        for size_m in (0.01, 0.02):
            assert finer_share(wishes.feed_m, size_m) == pytest.approx((size_m / 0.04) ** exponent, abs=0.02)
    assert finer_share(read_wishes("flip-flow", {}).feed_m, 0.006) == pytest.approx(0.45, abs=0.02)
    scalped = read_wishes("flip-flow", {"feed": "5 to 30 mm", "material": "gravel"}).feed_m
    assert (scalped[0], scalped[-1]) == ((0.005, 0.0), (0.03, 1.0))
    removed = math.sqrt(5 / 30)
    expected = (math.sqrt(0.5) - removed) / (1 - removed)
    assert finer_share(scalped, 0.015) == pytest.approx(expected, abs=0.01)


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_feed_cut_and_moisture_reach_the_case(tmp_path: Path) -> None:
    """The sieve analysis goes into the case's folder as it is; both levels can be run."""
    (tmp_path / "lab.csv").write_text(ANALYSIS, encoding="utf-8")
    answers = {"feed": str(tmp_path / "lab.csv"), "cut": "6 mm", "moisture": "moist"}
    proposal = propose(read_wishes("flip-flow", answers), "mine")
    new.write_files(proposal.files, tmp_path / "mine")
    for level in ("draft", "study"):
        judged = load_judged(tmp_path / "mine", level)
        assert find_problems(judged) == []
        feed = judged.case.bed.feeds["moist-limestone"]
        assert [point.passing for point in feed.curve] == [0.0, 0.04, 0.31, 0.72, 1.0]
        assert judged.case.output.cut_size_m == 0.006
        assert feed.smallest_fed_m is not None
        assert feed.smallest_fed_m < 0.012
    assert (tmp_path / "mine" / "feed.csv").read_text(encoding="utf-8") == ANALYSIS
    (remark,) = (line for line in proposal.remarks if line.startswith("feed: "))
    assert "by its sieve analysis; 36% is finer than the cut of 6 mm" in remark


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_a_curve_of_twelve_sieves_is_sampled_in_both_levels(tmp_path: Path) -> None:
    """The particles are sampled from a quarter of the openings up, in a draft that takes minutes and leaves
    out no throughput.

    Of each 20 % in size of the sample, a hundred grains come in the time over which a draft is balanced.
    """
    sieves_mm = [0.063, 0.125, 0.25, 0.5, 1, 2, 4, 5.6, 8, 11.2, 16, 31.5]
    passing = [(mm / 31.5) ** 0.5 for mm in sieves_mm]
    rows = [f"{mm:g} mm;{100 * share:.1f}" for mm, share in zip(sieves_mm, passing, strict=True)]
    (tmp_path / "lab.csv").write_text("\n".join(["sieve;passing / %", *rows]), encoding="utf-8")
    proposal = propose(read_wishes("flip-flow", {"feed": str(tmp_path / "lab.csv")}), "mine")
    assert proposal.run_s["draft"] < levels.DRAFT_S
    new.write_files(proposal.files, tmp_path / "mine")
    for level in ("draft", "study"):
        judged = load_judged(tmp_path / "mine", level)
        assert find_problems(judged) == []
        feed, machine_ = judged.case.bed.feeds["limestone"], judged.case.slice
        assert machine_ is not None
        assert feed.rate_kg_per_s == pytest.approx(50 / 3.6 * machine_.width_m / 2.0)
        assert feed.smallest_fed_m == pytest.approx(0.003)
        assert feed.sampled_below_m is not None
        assert feed.sampled_as_m is not None
        balanced_kg = feed.rate_kg_per_s * 30 * 0.08
        grain_kg = sphere_kg(feed.sampled_as_m, judged.case.materials["limestone"].density_kg_per_m3)
        edges_mm = np.arange(3.0, 1e3 * feed.sampled_below_m / 1.19, 0.1)
        shares = [np.diff(np.interp([mm, 1.2 * mm], sieves_mm, passing))[0] for mm in edges_mm]
        assert balanced_kg * min(shares) / grain_kg > 95


def test_a_wrong_feed_cut_or_moisture_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.csv").write_text("sieve / mm,passing\n16,1\n8,0.2\n4,0.3\n")
    for answers, text in (
        ({"feed": str(tmp_path / "bad.csv")}, "the curve falls: 20 % pass 8"),
        ({"feed": str(tmp_path / "none.csv")}, "cannot be read: No such file"),
        ({"feed": "30 mm"}, "is not a range of sizes; give two"),
        ({"feed": "30-5 mm"}, "is not a range of sizes"),
        ({"feed": "0-30"}, "has no unit; is '30 mm' meant?"),
        ({"feed": "0-10 mm"}, "--feed: the cut of 12 mm is above the coarsest grain"),
        ({"feed": "20-30 mm"}, "--feed: the cut of 12 mm is below the finest grain"),
        ({"cut": "40 mm", "opening": "12 mm"}, "--cut: the cut of 40 mm is above the coarsest grain"),
        ({"cut": "15 mm", "opening": "12 mm"}, "--cut: no grain between 12 and 15 mm passes the openings"),
        ({"moisture": "damp"}, "--moisture: 'damp' is not a class of moisture"),
        (
            {"moisture": "wet", "material": "moist coal"},
            "--moisture: wet contradicts --material 'moist coal'",
        ),
    ):
        assert any(text in str(refusal) for refusal in find_refusals("flip-flow", answers)), text


def test_the_feed_of_short_openings_can_pass_them() -> None:
    layout = lay_out(read_wishes("flip-flow", {"opening": "12 mm", "opening-length": "3 mm"}))
    assert layout.finest_m < 0.003 < layout.largest_m


@pytest.mark.parametrize(("length", "width"), [("15 m", "2 m"), ("0.7 m", "6 m")])
def test_the_inertia_of_long_and_wide_frames_is_that_of_a_body(length: str, width: str) -> None:
    made = machine.propose_machine(
        lay_out(read_wishes("flip-flow", {"length": length, "width": width})), 0.0, 0.0, 1.0
    )
    for frame in (made.driving, made.driven):
        assert 2 * max(frame.inertia_kg_m2) <= sum(frame.inertia_kg_m2) * (1 + 1e-12)


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
@pytest.mark.parametrize(
    ("panels", "length", "near"), [("1", "0.25 m", "+3%"), ("1", "0.2 m", "-11%"), ("2", "0.3 m", "+15%")]
)
def test_a_machine_near_resonance_is_called_doubtful(
    panels: str, length: str, near: str, tmp_path: Path
) -> None:
    """The bushings of a short deck stand close together, and the frames pitch at the working speed."""
    answers = {"panels": panels, "length": length, "throughput": "20 t/h"}
    proposal = propose(read_wishes("flip-flow", answers), "mine")
    new.write_files(proposal.files, tmp_path / "mine")
    doubts = [line for line in proposal.remarks if line.startswith("doubtful: ")]
    assert any(f"{near}  pitch of the driven frame against the driving frame" in r for r in proposal.remarks)
    assert any("a mode of the frames: pitch of the driven frame" in line for line in doubts)
    for complaint in complaints(load_judged(tmp_path / "mine", "draft")):
        assert f"doubtful: {complaint}" in doubts
        assert complaint in proposal.files["README.md"]


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_a_deck_of_long_panels_is_meshed_and_called_doubtful() -> None:
    proposal = propose(read_wishes("flip-flow", {"length": "6 m", "panels": "2"}), "mine")
    usual = propose(read_wishes("flip-flow", {}), "mine")
    assert len(doubts(proposal)) > len(doubts(usual))


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.parametrize(
    ("answers", "doubt"),
    [
        ({"stroke": "0.5 mm"}, "throw"),
        ({"slope": "2 deg"}, "degrees"),
        ({"slope": "12 deg, 20 deg"}, "steeper"),
        ({"length": "0.6 m"}, "heavier"),
    ],
)
@pytest.mark.solver
def test_an_unusual_machine_is_called_doubtful(answers: dict[str, str], doubt: str) -> None:
    assert any(doubt in remark for remark in doubts(propose(read_wishes("flip-flow", answers), "mine")))


def doubts(proposal: Proposal) -> list[str]:
    """Return the remarks that call a proposal doubtful."""
    return [remark for remark in proposal.remarks if remark.startswith("doubtful")]


def test_panels_are_not_stretched_to_any_length_by_a_large_stroke() -> None:
    """25 mm at 300 rpm want panels of 1.25 m at a stretch of 2 %; published ones have 0.3 to 0.45 m."""
    wishes = read_wishes("flip-flow", {"stroke": "25 mm", "speed": "300 rpm"})
    assert panel_length_m(wishes) == pytest.approx(0.45)


def test_a_range_of_slopes_and_both_sides_of_openings_are_understood() -> None:
    wishes = read_wishes("banana", {"slope": "28 to 12 deg", "panels": "10", "opening": "8 x 20 mm"})
    assert wishes.slopes_deg == (28.0, 24.0, 20.0, 16.0, 12.0)
    assert (wishes.opening_m, wishes.opening_length_m) == (0.008, 0.02)
    assert read_wishes("banana", {"slope": "30 to 12 deg", "panels": "2"}).slopes_deg == (30.0, 12.0)
    mixed = read_wishes("flip-flow", {"opening": "8 mm x 2 cm"})
    assert (mixed.opening_m, mixed.opening_length_m) == (0.008, 0.02)


def test_a_crank_moves_each_frame_by_half_of_the_stroke() -> None:
    """20 mm at 900 rpm are 9.1 g of each frame, which frames bear; on free frames they would be 24 g."""
    answers = {"stroke": "20 mm", "speed": "900 rpm", "length": "2 m"}
    assert find_refusals("crank-link", answers) == []
    (refusal,) = find_refusals("flip-flow", answers)
    assert "to 24 g" in str(refusal)


def test_what_is_thrown_beyond_the_end_is_oversize() -> None:
    """Half a metre behind the end, at any height up to 2.5 m above it; boxes leave no gap between them."""
    layout = lay_out(read_wishes("banana", {}))
    below, beyond = layout.exits[-2:]
    assert (below.product, beyond.product) == ("oversize", "oversize")
    assert beyond.box_m[0][0] == pytest.approx(below.box_m[1][0])
    assert beyond.box_m[0][0] == pytest.approx(layout.end_m[0] + 0.5)
    assert beyond.box_m[1][2] == pytest.approx(layout.end_m[2] + 2.5)
    assert beyond.box_m[0][2] == below.box_m[0][2]


@pytest.mark.solver
def test_panels_that_are_too_stiff_for_the_speed_are_refused() -> None:
    with pytest.raises(ImpossibleWishes) as refused:
        propose(read_wishes("flip-flow", {"speed": "150 rpm"}), "mine")
    (problem,) = refused.value.problems
    assert (problem.file, problem.kind) == ("--speed", "out-of-range")


def test_nothing_is_written_or_overwritten_where_wishes_are_wrong(tmp_path: Path) -> None:
    there = tmp_path / "there"
    there.mkdir()
    done = CALL.invoke(app, ["new", str(there), "--panels", "none", "--material", "limstone"])
    assert done.exit_code == 2
    for text in (
        "3 problems in the options",
        "exists already",
        "--panels: 'none' is not a number",
        '"limestone"',
    ):
        assert text in done.stderr
    done = CALL.invoke(app, ["new", str(there), "--stroke", "40 mm"])
    assert done.exit_code == 2
    assert "exists already" in done.stderr
    assert "--stroke: 40 mm" in done.stderr
    assert [file.name for file in tmp_path.rglob("*")] == ["there"]


def test_a_place_inside_of_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    done = CALL.invoke(app, ["new", str(tmp_path / "file" / "mine")])
    assert (done.exit_code, "is not a folder" in done.stderr) == (2, True)


def test_wrong_options_are_refused_before_anything_is_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(new, "can_ask", lambda: True)
    done = CALL.invoke(app, ["new", str(tmp_path / "mine"), "--width", "12 Hz"], input="\n" * 20)
    assert done.exit_code == 2
    assert "is a frequency" in done.stderr
    assert "?" not in done.stdout


@pytest.mark.parametrize("stop", [typer.Abort, KeyboardInterrupt])
def test_interrupted_questions_end_with_130_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stop: type[BaseException]
) -> None:
    """A prompt makes click's Abort of Ctrl-C; elsewhere, Ctrl-C is itself."""

    def interrupted(*_: object, **__: object) -> None:
        raise stop

    monkeypatch.setattr(new, "can_ask", lambda: True)
    monkeypatch.setattr(typer, "prompt", interrupted)
    done = CALL.invoke(app, ["new", str(tmp_path / "mine")])
    assert (done.exit_code, done.stderr.strip()) == (130, "interrupted: nothing is written")
    assert not [*tmp_path.iterdir()]


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_defaults_are_named_where_nobody_can_be_asked(tmp_path: Path) -> None:
    words = ["--template", "test-rig", "--width", "0.4 m"]
    done = CALL.invoke(app, ["new", str(tmp_path / "mine"), *words])
    assert done.exit_code == 0, done.output
    first = done.stdout.splitlines()[0]
    assert first.startswith("no terminal to ask in; taken: --opening '12 mm' --speed ")
    assert "--template" not in first
    assert "--width" not in first
    again = ["new", str(tmp_path / "again"), *words, *shlex.split(first.partition("taken: ")[2]), "--yes"]
    done = CALL.invoke(app, again)
    assert done.exit_code == 0, done.output
    assert "no terminal" not in done.stdout
    texts = [(tmp_path / name / "case.toml").read_text(encoding="utf-8") for name in ("mine", "again")]
    assert texts[0] == texts[1]


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
@pytest.mark.smoke
def test_a_terminal_is_asked_and_a_wrong_answer_is_asked_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(new, "can_ask", lambda: True)
    typed = "test-rg\ntest-rig\n0.4 m\n\n12 s\n10 mm\n700 rpm\n\n"
    words = ["new", str(tmp_path / "mine"), "--opening-length", "12 mm"]
    done = CALL.invoke(app, words, input=typed)
    assert done.exit_code == 0, done.output
    assert 'did you mean "test-rig"?' in done.output
    assert "'12 s' is a time; give a length" in done.output
    case = load_judged(tmp_path / "mine").case
    (panel,) = case.screen.panels.values()
    assert panel.apertures is not None
    assert (panel.width_m, panel.apertures.width_m, panel.apertures.length_m) == (0.4, 0.01, 0.012)
    assert "Which material" not in done.output
    (command,) = (line for line in done.output.splitlines() if "without questions" in line)
    words = shlex.split(command.partition(": flipflow ")[2].replace("mine", "again"))
    assert CALL.invoke(app, words).exit_code == 0
    texts = [(tmp_path / name / "case.toml").read_text(encoding="utf-8") for name in ("mine", "again")]
    assert texts[0] == texts[1]


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_an_impossible_answer_in_a_terminal_is_asked_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three openings of 150 mm do not fit on a rig of 0.4 m; all other answers are kept."""
    monkeypatch.setattr(new, "can_ask", lambda: True)
    words = ["new", str(tmp_path / "rigs" / "mine"), "--template", "test-rig", "--opening-length", "12 mm"]
    done = CALL.invoke(app, words, input="0.4 m\n\n150 mm\n\n\n10 mm\n")
    assert done.exit_code == 0, done.output
    assert "--opening: 150 mm: only 1 opening fits" in done.output
    (panel,) = load_judged(tmp_path / "rigs" / "mine").case.screen.panels.values()
    assert panel.apertures is not None
    assert (panel.width_m, panel.apertures.width_m) == (0.4, 0.01)
    readme = (tmp_path / "rigs" / "mine" / "README.md").read_text()
    assert f"flipflow check {tmp_path}/rigs/mine " in readme


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_a_draft_that_takes_too_long_is_called_doubtful() -> None:
    """Openings of half a millimetre want so many particles that no draft is cheap."""
    answers = {"opening": "0.5 mm", "throughput": "50 t/h"}
    proposal = propose(read_wishes("flip-flow", answers), "mine")
    assert proposal.run_s["draft"] > levels.DRAFT_S
    (draft,) = (line for line in proposal.remarks if line.startswith("draft: "))
    assert f"about {in_words(proposal.run_s['draft'])} of processor time" in draft
    assert any("even the coarsest draft is predicted to take more" in line for line in proposal.remarks)


@pytest.mark.solver
@pytest.mark.process
@pytest.mark.slow
def test_a_new_case_runs_and_loses_nothing(tmp_path: Path) -> None:
    """Half a second: the machine has its speed, and the first particles are fed and fall onto the deck."""
    words = ["--set", "duration_s=0.48", "--set", "output.pictures=false", "--out", str(tmp_path / "run")]
    assert flipflow("run", str(write("flip-flow", tmp_path)), *words).returncode == 0
    results = summary(tmp_path / "run")
    material = results["material"]
    through = sum(row["number"] for row in material["exits"].values())
    assert material["fed"]["number"] > 20
    assert material["lost"]["number"] == material["escaped"]["number"] == 0
    assert material["fed"]["number"] == through + material["on_deck"]["number"]
    stroke_m = results["results"]["motion"]["relative"]["driven-driving"]["along_m"]["value"]
    assert stroke_m == pytest.approx(0.006, rel=0.15)  # a few turns after the run-up


@pytest.mark.solver
@pytest.mark.process
@pytest.mark.slow
@pytest.mark.parametrize("template", ["test-rig", "crank-link", "banana"])
def test_each_template_runs(template: str, tmp_path: Path) -> None:
    """The run has no doubt until the first particles fall onto the deck; none is lost."""
    words = ["--set", "duration_s=0.15", "--set", "output.pictures=false"]
    words += ["--set", "bed.feeds.limestone.start_s=0.05"] if template != "test-rig" else []
    done = flipflow("run", str(write(template, tmp_path)), *words, "--out", str(tmp_path / "run"))
    assert done.returncode == 0, done.stderr
    results = summary(tmp_path / "run")
    assert results["status"] == "done"
    if template != "test-rig":
        assert results["material"]["fed"]["number"] > 5
        assert results["material"]["lost"]["number"] == results["material"]["escaped"]["number"] == 0


@pytest.mark.usefixtures("mats_as_drawn")
@pytest.mark.solver
def test_the_shape_of_grains_is_that_of_the_material_or_as_it_is_asked_for(tmp_path: Path) -> None:
    """Crushed limestone is angular, and the answer says so; pebbles of it are rounded."""
    assert any(
        remark.startswith("grains: angular (broken or crushed") for remark in proposed("banana").remarks
    )
    usual = load_judged(write("banana", tmp_path), "draft").case
    assert {row.rolling_friction for row in usual.contacts} == {0.25}
    asked = propose(read_wishes("banana", {"shape": "Rounded", "material": "moist limestone"}), "mine")
    new.write_files(asked.files, tmp_path / "mine")
    mine = load_judged(tmp_path / "mine", "draft").case
    assert mine.materials["moist-limestone"].shape == "rounded"
    assert {row.rolling_friction for row in mine.contacts} == {0.05}
    assert "grains: rounded" in asked.files["README.md"]
    with pytest.raises(ImpossibleWishes, match='did you mean "angular"'):
        read_wishes("banana", {"shape": "angluar"})
