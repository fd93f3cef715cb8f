"""Verdicts that brute force, the same run with and without the effect, has shown to be wrong: what
was left out by them, and what closed forms say of it now."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from orchestrator.figures.short_names import SHORT_NAMES
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.account import account
from orchestrator.preflight.judgement.catalogue import (
    EFFECTS,
    Judged,
    all_needs,
    find_also_lost,
    judge_effects,
)
from orchestrator.preflight.judgement.pair import Pair, key_of, remember
from orchestrator.preflight.judgement.weighing import weigh_effects, with_doubt
from orchestrator.preflight.scene.effect import Verdict
from orchestrator.preflight.scene.moved_panel import stiffness_share
from orchestrator.preflight.scene.observed import Observed
from orchestrator.preflight.scene.scene import scene
from orchestrator.run.trials.pairs import Pairs
from tests.cases import kinds, load_case, loaded
from tests.effects.verdicts import APERTURES, DRIVEN_CASE, TILTED

CASES = Path(__file__).parents[2] / "cases"
TAUT = (
    "screen.decks.deck.tension_m=0.008",
    "screen.decks.deck.length_m=0.290",
    "screen.decks.deck.apertures.margin_along_m=0.03",
)
ACROSS = (
    "screen.decks.deck.apertures={length_m=0.003, width_m=0.020, pitch_along_m=0.018, pitch_across_m=0.025}"
)
WEAK = "screen.exciters.shaft.motor.rated_power_W=200.0"
ONE_MAT = (  # 0.3 m, mounted taut by 3 mm, its frame shaken normal to it
    "screen.panels.deck.frames=['driving', 'driving']",
    "screen.panels.deck.tension_m=0.003",
    "screen.panels.deck.length_m=0.3",
    "screen.frames.driving.drive.amplitude_m=[0.0, 0.0, 0.0015]",
    "particles.solver=none",
)


def of(case: str, *sets: str, level: str | None = "draft") -> dict[str, Judged]:
    """Return the verdicts of a shipped case, by effect."""
    described = load_judged(CASES / case, level, sets).described
    return weigh_effects(described)


def test_taut_mats_that_hold_the_frames_together_are_not_left_out() -> None:
    """Brute force: a relative amplitude of 32.5 mm without panel-deformation instead of 3.43."""
    judged = of("ffs0827-empty", *TAUT)["panel-deformation"]
    assert judged.verdict.matters is True
    assert judged.verdict.value == pytest.approx(31.8 / 3.58 - 1, rel=0.01)
    auto = load_judged(CASES / "ffs0827-empty", "draft", [*TAUT, "effects=auto"])
    assert auto.case.panel.solver == "strip"
    assert "panel-deformation" not in auto.left_out


def test_openings_that_soften_the_mats_are_not_left_out() -> None:
    """Brute force: 3.61 mm without the slots across the pull instead of 7.88."""
    judged = of("ffs0827-empty", ACROSS)["apertures"]
    assert judged.verdict.matters is True
    assert "change of the stroke" in judged.verdict.number
    auto = load_judged(CASES / "ffs0827-empty", "draft", [ACROSS, "effects=auto"])
    assert "apertures" not in auto.left_out


@pytest.mark.parametrize("speed_share", [1.0, 0.9, 0.5])
def test_a_mat_at_its_own_frequency_is_not_left_out(tmp_path: Path, speed_share: float) -> None:
    """Brute force at resonance: 1.5 mm without panel-deformation instead of 11.8."""
    case = load_case(tmp_path, DRIVEN_CASE, ONE_MAT).case
    mat = judge_effects(case)["panel-inertia"]
    assert mat.verdict.value is not None
    own_rad_per_s = 80.0 / mat.verdict.value**0.5
    turns = f"screen.frames.driving.drive.speed_rad_per_s={speed_share * own_rad_per_s}"
    there = load_judged(tmp_path, None, [*ONE_MAT, turns, "effects=auto"])
    deforms = EFFECTS["panel-deformation"].judge(scene(there.described))
    assert deforms is not None
    assert deforms.value is not None
    square = speed_share**2
    if speed_share < 1:
        assert deforms.value == pytest.approx(4 / math.pi * square / (1 - square), rel=1e-6)
    else:
        assert deforms.value > 1e6
    assert there.case.panel.solver == "sheet"
    assert "panel-deformation" not in there.left_out


def test_a_motor_that_a_resonance_may_catch_is_not_left_out() -> None:
    """Brute force: caught at the resonance with 200 W; a strong one passes."""
    assert of("motor-start", WEAK)["motor-slip"].verdict.matters is True
    auto = load_judged(CASES / "motor-start", "draft", [WEAK, "effects=auto"])
    assert "motor-slip" not in auto.left_out
    assert of("motor-start")["motor-slip"].verdict.matters is None, "900 W: 0.54 of the torque"
    strong = WEAK.replace("200.0", "2000.0")
    assert of("motor-start", strong)["motor-slip"].verdict.matters is False


def test_removal_and_feed_stay_where_material_may_reach_the_exits() -> None:
    """Measured: 1.1 to 1.9 m/s, where 0.34 was assumed."""
    judged = of("ffs0827-slice", "duration_s=0.7", level=None)
    assert judged["removal"].verdict.matters is None
    assert judged["feed"].verdict.matters is True
    auto = load_judged(CASES / "ffs0827-slice", None, ["duration_s=0.7", "effects=auto"])
    assert not {"feed", "removal"} & set(auto.left_out)


def test_what_passes_the_openings_leaves_in_the_shortest_run(tmp_path: Path) -> None:
    """Closed mats keep what lies on them for as long as it takes to go over the deck."""
    short = (TILTED, "duration_s=0.001")
    ball = "bed.particles.ball.sieve_size_m=0.005"

    def removal(*sets: str) -> Verdict:
        case = loaded(tmp_path, [*short, *sets]).case
        every = weigh_effects(case)
        return every["removal"].verdict

    assert removal().matters is False
    assert removal(APERTURES, ball).matters is None


@pytest.mark.parametrize("case", ["ffs0827-slice", "quickstart", "banana", "motor-start"])
def test_softened_contacts_of_shipped_cases_are_no_false_alarms(case: str) -> None:
    """Runs from 1e6 to 1e8 Pa differ by 0.3 %; a radius deep, particles fall through."""
    judged = of(case, level=None)
    assert judged["contact-stiffness"].verdict.matters is False
    if "stiffness-at-openings" in judged:
        assert judged["stiffness-at-openings"].verdict.matters is False
    soft = of(case, "particles.largest_youngs_modulus_Pa=1e4", level=None)["contact-stiffness"]
    assert soft.verdict.matters is True


CONSISTENT = [
    ("ffs0827-empty", "draft", ()),
    ("ffs0827-empty", "draft", TAUT),
    ("ffs0827-empty", "draft", (ACROSS,)),
    ("motor-start", "draft", (WEAK,)),
    ("quickstart", "draft", ()),
    ("ball-on-panel", None, ()),
    ("panel-cycle", None, ()),
    ("banana", None, ()),
]


@pytest.mark.parametrize(("case", "level", "sets"), CONSISTENT)
def test_nothing_is_left_out_that_something_needs(
    case: str, level: str | None, sets: tuple[str, ...]
) -> None:
    judged = of(case, *sets, level=level)
    for row in judged.values():
        along = find_also_lost(load_judged(CASES / case, level, sets).described, row.effect)
        others = [
            other
            for other in judged.values()
            if row.effect in all_needs(other.effect) or other.effect in along
        ]
        if row.verdict.matters is False and row.present:
            assert all(o.verdict.matters is False for o in others if o.present), row


def test_an_estimate_near_its_threshold_does_not_decide() -> None:
    near = Verdict("number", 0.05, "0.1", False, "why", limit=0.1)
    far = Verdict("number", 0.03, "0.1", False, "why", limit=0.1)
    assert (near.is_close, far.is_close) == (True, False)
    other = Verdict("layers", 4.0, "5", False, "why")
    assert not other.is_close, "a count is what it is"


def test_a_run_without_openings_says_the_same_of_them() -> None:
    """Its panels are stiffer by what openings take; with them the stroke would be as estimated."""
    estimated = scene(load_judged(CASES / "ffs0827-empty", "draft", [ACROSS]).described)
    before = EFFECTS["apertures"].judge(estimated)
    whole = tuple(
        replace(
            spring,
            stiffness_N_per_m=spring.stiffness_N_per_m
            / stiffness_share(panel.panel.apertures, panel.panel.rectangle),
        )
        for panel, spring in zip(estimated.panels, estimated.springs, strict=True)
    )
    run = replace(estimated, springs=whole, observed=Observed(closed=True))
    after = EFFECTS["apertures"].judge(run)
    assert before is not None
    assert after is not None
    assert after.value == pytest.approx(before.value, rel=1e-9)
    assert EFFECTS["apertures"].checked_by == "frames_throw"


def test_names_of_results_are_in_the_manual() -> None:
    text = (CASES.parent / "docs" / "run-folder.md").read_text()
    assert all(f"(`{name}`" in text for name in SHORT_NAMES)


def test_auto_takes_what_two_runs_said_and_asks_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A pair that is remembered lets "auto" leave out what no estimate can decide about, for the
    results that the case is for; another case does not have it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    sets = ["effects=auto", 'effects_for=["stroke"]']
    name, before = "motor-slip", load_judged(CASES / "motor-start", "draft", sets)
    assert name not in before.left_out
    assert name in before.choice.undecided
    assert "panel-damping" not in before.choice.undecided, "an estimate says that it matters"

    def run(stroke_m: float) -> dict[str, object]:
        motion = {"frames": {"a": {"amplitude_m": [stroke_m, 0.0, 0.0]}}}
        return {"results": {"motion": motion}}

    pair = Pair(name, summary_with=run(0.006), summary_without=run(0.0061))
    remember(key_of(before.origin.read(), name), pair)
    after = load_judged(CASES / "motor-start", "draft", sets)
    assert name in after.left_out
    assert name not in after.choice.undecided
    entry = account(after.described, after.left_out, after.choice.pairs, after.choice.asked)[name]
    assert entry.before is not None
    assert entry.before.measured
    other = load_judged(CASES / "motor-start", "draft", [*sets, "duration_s=0.3"])
    assert name not in other.left_out


def test_results_that_there_are_not_are_refused(tmp_path: Path) -> None:
    assert kinds(tmp_path, "effects=auto", 'effects_for=["eficiency"]') == ["effects_for: unknown-name"]


def test_two_runs_take_the_place_of_an_estimate() -> None:
    """Panels whose deformation matters by an estimate, and 1 % of the stroke by two runs."""

    def run(stroke_m: float) -> dict[str, object]:
        motion = {"frames": {"a": {"amplitude_m": [stroke_m, 0.0, 0.0]}}}
        return {"results": {"motion": motion}}

    pair = Pair("frame-rotation", summary_with=run(0.006), summary_without=run(0.00606))
    described = load_judged(CASES / "ffs0827-empty", "draft").described
    judged = weigh_effects(described, {"frame-rotation": pair}, ("stroke",))["frame-rotation"]
    assert judged.verdict.measured
    assert judged.verdict.value == pytest.approx(0.01)
    assert judged.verdict.matters is False
    nothing = weigh_effects(described, {"frame-rotation": pair}, ("efficiency",))
    assert not nothing["frame-rotation"].verdict.measured


def test_a_surface_that_carries_particles_slowly_is_not_left_out() -> None:
    """Brute force, in the scene slow-lift of cases/effects.toml: a ball that lies on a panel goes
    up and down with it by 1.5 mm, and by 0.2 mm without the panel's motion, at a throw of 0.096."""
    lift = (
        "screen.frames.lift={drive={amplitude_m=[0.0, 0.0, 0.001], speed_rad_per_s=12.0}}",
        "screen.panels.deck.frames=['lift', 'lift']",
    )
    judged = of("ball-on-panel", *lift)["panel-motion"]
    assert judged.verdict.value == pytest.approx(12.0**2 * 0.001 / 9.81, rel=1e-3)
    assert judged.verdict.matters is None


@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "effect", "sets", "with_it", "without"),
    [
        ("ffs0827-empty", "panel-deformation", TAUT, 3.30e-3, 28.75e-3),
        ("ffs0827-empty", "apertures", (ACROSS,), 7.23e-3, 3.10e-3),
    ],
)
def test_brute_force_of_the_stroke(
    case: str,
    effect: str,
    sets: tuple[str, ...],
    with_it: float,
    without: float,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Run the same case with and without the effect for 0.8 s."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    short = (*sets, "duration_s=0.8", "output.interval_s=0.1", "coupling.sync_interval_s=8e-4")
    pair = Pairs(limit_s=600.0).of(load_judged(CASES / case, "draft", short), effect)
    assert pair.refused == ""
    change = pair.change("stroke")
    assert change is not None
    assert change.with_it == pytest.approx(with_it, rel=0.05)
    assert change.without == pytest.approx(without, rel=0.05)


def asked_of(names: Sequence[str], case: str, *sets: str) -> dict[str, Judged]:
    """Return the verdicts of a shipped case at level draft, by effect, for some results."""
    described = load_judged(CASES / case, "draft", sets).described
    return {name: with_doubt(judged) for name, judged in weigh_effects(described, asked=names).items()}


def test_an_estimate_cries_wolf_over_its_own_results_only() -> None:
    """Brute force: without panel-damping the stroke of empty-machine changes by 8 %, accelerations
    of its panels tenfold; without frame-rotation the stroke of ffs0827-empty changes by 2 %."""
    of_stroke = asked_of(["stroke"], "empty-machine")["panel-damping"].verdict
    assert of_stroke.matters is None
    assert "of the frames it does not say" in of_stroke.why
    for names in (["rms_g"], ["stroke", "rms_g"], ["probes.centre.cycle_peak_g"], []):
        assert asked_of(names, "empty-machine")["panel-damping"].verdict.matters is True
    assert asked_of(["stroke"], "ffs0827-empty")["frame-rotation"].verdict.matters is None
    assert asked_of(["rms_g"], "ffs0827-empty")["frame-rotation"].verdict.matters is True


def test_friction_on_the_level_is_about_what_lies_there() -> None:
    """Brute force: a ball that falls on the middle of a level panel never slides."""
    panel = asked_of(["probes.middle.peak_m"], "ball-on-panel")
    ball = asked_of(["probes.ball.mean_m.2"], "ball-on-panel")
    for name in ("sliding-friction", "rolling-friction"):
        assert (panel[name].verdict.matters, ball[name].verdict.matters) == (None, True)
    assert panel["particle-load"].verdict.matters is True


def test_what_is_near_its_threshold_from_above_is_for_a_pair_to_say() -> None:
    """Brute force: panel-damping of slow panels, 0.124 of 0.1, changes 3 %."""
    slow = (
        "screen.frames.moving.drive.amplitude_m=[0.0015, 0.0, 0.0]",
        "screen.frames.moving.drive.speed_rad_per_s=8.0",
    )
    near = asked_of(["middle_half_range"], "panel-cycle", *slow)["panel-damping"].verdict
    assert near.value == pytest.approx(0.124, abs=0.001)
    assert near.matters is None
    assert "within a factor of 3" in near.why
    assert asked_of(["stretch"], "panel-cycle")["panel-damping"].verdict.matters is True


def test_taut_panels_far_below_resonance_move_as_their_clamps() -> None:
    """Brute force: without panel-damping 0.0 % of a mat's middle at a sixth of its frequency."""
    stiff = (
        "screen.panels.deck.tension_m=0.015",
        'screen.panels.deck.frames=["moving", "moving"]',
        "screen.frames.moving.drive.amplitude_m=[0.0, 0.0, 0.002]",
        "screen.frames.moving.drive.speed_rad_per_s=40.0",
    )
    verdict = asked_of(["middle_half_range"], "panel-cycle", *stiff)["panel-damping"].verdict
    assert verdict.matters is None
    assert "taut panels' middles" in verdict.why


def test_panels_that_answer_their_clamps_are_about_panels() -> None:
    """Brute force, hard/bushings: flat panels change the frames' amplitude by 0.001 %, though the
    panels' middles answer their clamps by a third."""
    of_frames = asked_of(["frame_amplitude"], "hard/bushings")["panel-deformation"].verdict
    assert of_frames.value == pytest.approx(0.35, rel=0.02)
    assert of_frames.matters is None
    of_panels = asked_of(["middle_half_range"], "hard/bushings")["panel-deformation"].verdict
    assert of_panels.matters is True
    assert asked_of(["stroke"], "ffs0827-empty", *TAUT)["panel-deformation"].verdict.matters is True
