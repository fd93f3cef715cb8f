"""The case key ``effects``: what is left out by it, what it refuses, and that the resolved case
says it without it."""

from __future__ import annotations

from pathlib import Path

import pytest
import tomli_w

from orchestrator.case.file.errors import CaseError
from orchestrator.cli.explain import judge_effects
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.judgement.account import account, lines_at_start
from orchestrator.preflight.judgement.catalogue import EFFECTS, has_effect, with_dependents
from tests.cases import BLOCK, CASE, FEED, LEVEL, case_folder, complaints, kinds, load_case, problems
from tests.effects.verdicts import BARE, DEEP, DRIVEN_CASE, EXITS

STICKY = "rolling_friction = 0.05\nwork_of_adhesion_J_per_m2 = 1.0"
WEARING = "sliding_friction = 0.47\nspecific_wear_m3_per_N_m = 1e-12"  # coal on PU
DAMPED = "bulk_modulus_Pa = 2e9, maxwell = [{ratio = 0.2, relaxation_s = 0.01}]"
FULL = (
    CASE.replace("sliding_friction = 0.47", WEARING)
    .replace("rolling_friction = 0.0", STICKY)
    .replace("bulk_modulus_Pa = 2e9", DAMPED)
)
MORE = (BLOCK, FEED, DEEP, EXITS, "screen.exciters.shaft.run_up_s=0.05")
MORE += ("air={}",)
MORE += ("screen.bushings.isolation.damping_N_s_per_m=[90.0, 90.0, 90.0]",)
COARSE = """
without = ["panel-deformation", "frame-rotation"]
frames.solver = "two-mass"
panel.solver = "rigid"
"""
CAN_GO = [
    "adhesion",
    "air-drag",
    "apertures",
    "bushing-damping",
    "feed",
    "frame-dynamics",
    "frame-motion",
    "frame-rotation",
    "opening-depth",
    "panel-damping",
    "panel-deformation",
    "panel-motion",
    "panel-reaction",
    "particle-load",
    "removal",
    "rolling-friction",
    "run-up",
    "sliding-friction",
    "variation-across",
    "wear",
]


OF_SPHERES = {"grain-shape"}  # left out wherever there are particles


def full(folder: Path, *effects: str) -> JudgedCase:
    """A case with all effects that can be left out, and ``effects`` a list of names."""
    return load_case(folder, FULL, [*MORE, f"effects={list(effects)}"])


def has(case: JudgedCase) -> set[str]:
    return {name for name in EFFECTS if has_effect(case.case, name)}


def test_the_full_case_has_these_effects_that_can_be_left_out(tmp_path: Path) -> None:
    judged = load_case(tmp_path, FULL, MORE)
    assert find_problems(judged) == []
    assert set(CAN_GO) <= {name for name in has(judged) if EFFECTS[name].overlay(judged.case)}


@pytest.mark.parametrize("name", CAN_GO)
def test_what_is_not_named_is_left_out_and_nothing_else(tmp_path: Path, name: str) -> None:
    """An effect that is left out takes along the effects that need it."""
    before = has(load_case(tmp_path, FULL, MORE))
    with_it = before & set(with_dependents([name], ""))
    judged = full(tmp_path, *(before - with_it))
    assert find_problems(judged) == []
    assert has(judged) == before - with_it
    assert set(judged.left_out) == with_it | OF_SPHERES


def test_naming_all_changes_nothing(tmp_path: Path) -> None:
    plain = load_case(tmp_path, FULL, MORE)
    judged = full(tmp_path, *has(plain))
    assert judged.case == plain.case
    assert set(judged.left_out) == OF_SPHERES


def test_an_empty_list_leaves_out_all_that_can_be(tmp_path: Path) -> None:
    judged = full(tmp_path)
    assert not has(judged) & set(CAN_GO)
    solvers = judged.case.frames.solver, judged.case.panel.solver
    assert solvers == ("prescribed", "rigid")


@pytest.mark.parametrize(
    ("names", "kind", "name"),
    [
        ('["adhesoin"]', "unknown-name", '"adhesion"'),
        ('["sjkrr"]', "unknown-name", '"sjkr"'),
        ('["jkr", "sjkr"]', "conflict", "adhesion"),
        ('["cdt", "epsd2"]', "conflict", "rolling-friction"),
        ('["frame-rotation"]', "conflict", '"frame-dynamics"'),
        ("autp", "wrong-type", '"auto"'),
        ("[1]", "wrong-type", '"auto"'),
    ],
)
def test_names_that_cannot_be(tmp_path: Path, names: str, kind: str, name: str) -> None:
    (problem,) = problems(tmp_path, f"effects={names}")
    assert (problem.file, problem.key, problem.kind) == ("--set", ("effects",), kind)
    assert name in problem.what_helps


def test_what_is_named_and_not_described_is_a_mistake(tmp_path: Path) -> None:
    assert kinds(tmp_path, 'effects=["adhesion"]') == ["effects: conflict"]


def test_a_named_effect_that_the_solver_lacks_is_a_mistake(tmp_path: Path) -> None:
    named = '["frame-dynamics", "frame-rotation"]'
    assert kinds(tmp_path, f"effects={named}", "frames.solver=two-mass") == ["effects: conflict"]


def test_a_level_may_leave_out_what_is_named_if_it_says_so(tmp_path: Path) -> None:
    named = 'effects = ["panel-deformation", "variation-across"]\n'
    folder = case_folder(tmp_path, named + CASE, draft=LEVEL)
    assert find_problems(load_judged(folder, "draft")) == []
    assert "variation-across" in load_judged(folder, "draft").left_out
    assert "variation-across" in load_judged(folder, "draft", ["effects=auto"]).left_out
    bare = case_folder(tmp_path / "bare", named + CASE)
    problems = find_problems(load_judged(bare, None, ["panel.solver=strip"]))
    assert [str(problem).split(":")[0] for problem in problems] == ["case.toml effects"]


def test_all_mistakes_are_in_one_message(tmp_path: Path) -> None:
    messages = complaints(tmp_path, 'effects=["wind"]', "duration_s=fast", "panel.solver=stripe")
    assert len(messages) == 3
    messages = complaints(tmp_path, 'effects=["wind"]', "duration_s=2e4")
    assert len(messages) == 2


def test_a_law_is_chosen_by_its_name(tmp_path: Path) -> None:
    assert full(tmp_path, "sjkr").case.particles.adhesion == "sjkr"
    assert full(tmp_path, "cdt").case.particles.rolling == "cdt"
    given = [*MORE, 'effects=["sjkr"]', "particles.adhesion=jkr"]
    problems = find_problems(load_case(tmp_path, FULL, given))
    assert "\"sjkr\" is named, and particles.adhesion is 'jkr'" in str(problems[0])


def test_auto_leaves_out_what_may_be_and_says_the_number(tmp_path: Path) -> None:
    """A level frame on bushings does not turn: its exciter is at its centre of mass."""
    centre = "screen.frames.driving.center_of_mass_m=[0.0, 0.1, 0.0]"
    judged = load_case(tmp_path, overrides=["effects=auto", centre])
    assert judged.case.frames.solver == "two-mass"
    (line,) = (
        text
        for text in lines_at_start(account(judged.described, judged.left_out))
        if "frame-rotation: " in text
    )
    assert line == (
        "left out: frame-rotation: frames.solver two-mass: frames translate only; "
        'effects = "auto"; may be left out: rotation x lever / translation 0, threshold 0.1'
    )
    assert judged.case.panel.solver == "sheet"


def test_auto_warns_of_what_is_lacking_and_invents_nothing(tmp_path: Path) -> None:
    tilted = ["effects=auto", "screen.inclination_deg=20", "panel.solver=rigid"]
    judged = load_case(tmp_path, overrides=tilted)
    lines = [line for line in warnings(judged) if "matters, and the case does not have it" in line]
    lacking = {line.split()[0] for line in lines}
    of_panels = {"panel-deformation", "large-deflection", "panel-inertia", "particle-load"}
    assert lacking == of_panels | OF_SPHERES | {"run-up", "rolling-friction"}
    assert judged.case.panel.solver == "rigid"


def test_auto_keeps_a_feed_that_is_all_there_is(tmp_path: Path) -> None:
    given = ["effects=auto", FEED, "duration_s=0.005", "screen.inclination_deg=20"]
    assert load_case(tmp_path, BARE, given).case.bed.feeds
    assert load_case(tmp_path, overrides=given).case.bed.feeds, "any result may be asked for"
    with_ball = load_case(tmp_path, overrides=[*given, 'effects_for=["stroke"]'])
    assert not with_ball.case.bed.feeds
    assert "feed" in with_ball.left_out


def test_frames_that_no_force_moves_are_prescribed(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, DRIVEN_CASE)
    assert load_judged(folder).case.frames.solver == "exudyn"
    for effects in ("auto", '["panel-deformation"]'):
        judged = load_judged(folder, None, [f"effects={effects}"])
        assert judged.case.frames.solver == "prescribed"
        assert "frame-dynamics" not in judged.left_out, "there is none to be left out"
        assert find_problems(judged) == []


def test_auto_leaves_wrong_cases_to_the_checks(tmp_path: Path) -> None:
    refused = kinds(tmp_path, "effects=auto", "screen.panels.deck.material=XX")
    assert refused == ["screen.panels.deck.material: unknown-name"]


@pytest.mark.parametrize("effects", ["auto", '["panel-deformation", "frame-dynamics"]'])
def test_the_resolved_case_is_the_same_without_the_key(tmp_path: Path, effects: str) -> None:
    judged = load_case(tmp_path / "a", FULL, [*MORE, f"effects={effects}"])
    table = resolved_case(judged)
    assert "effects" not in table
    again = load_judged(case_folder(tmp_path / "b", tomli_w.dumps(table)))
    assert again.case == judged.case.model_copy(update={"default_level": ""})


MATERIALS = """
[materials.PU]
like = "polyurethane 85 Shore A"
[materials.coal]
like = "coal"
shape = "flaky"
[[contacts]]
between = ["coal", "PU"]
sliding_friction = 0.2
"""
"""The library has the loss of the panels and the contact of coal with itself."""


@pytest.mark.parametrize("by_name", [False, True])
@pytest.mark.parametrize("name", ["sliding-friction", "panel-damping"])
def test_what_the_library_gives_is_left_out_alone(tmp_path: Path, name: str, by_name: bool) -> None:
    """Materials and contacts are the library's, some with a number of their own or under another name."""
    head, _, rest = CASE.partition("[materials.PU]")
    text = head + ("" if by_name else MATERIALS) + rest[rest.index("[screen.frames.driving]") :]
    if by_name:
        text = text.replace('"PU"', '"polyurethane 85 Shore A"').replace('"coal"', '"moist limestone"')
    before = load_case(tmp_path, text)
    judged = load_case(tmp_path, text, [f"effects={sorted(has(before) - {name})}"])
    assert find_problems(judged) == []
    assert has(judged) == has(before) - {name}
    nothing = {"sliding-friction": {"sliding_friction": 0.0}}.get(name, {})
    assert judged.case.contacts == tuple(row.model_copy(update=nothing) for row in before.case.contacts)
    tables = {key.partition(".")[0] for key in judged.changed} - {"screen"}
    assert tables == {"contacts" if nothing else "materials"}
    assert find_problems(load_case(tmp_path, text, ["effects=[]"])) == []


def test_a_level_may_give_the_key_and_set_overrides_it(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, CASE, fine='effects = ["panel-deformation"]\n')
    assert load_judged(folder, "fine").case.frames.solver == "prescribed"
    assert load_judged(folder, "fine", ["effects=auto"]).case.frames.solver != "prescribed"
    with pytest.raises(CaseError) as caught:
        load_judged(case_folder(tmp_path, CASE, fine='effects = ["wind"]\nduration_s = true\n'), "fine")
    assert "levels/fine.toml effects: no effect 'wind'" in str(caught.value)


def test_explain_judges_what_the_case_describes_and_says_what_is_here(tmp_path: Path) -> None:
    """Openings that effects leave out are still asked about."""
    plain = load_case(tmp_path, FULL, MORE)
    before = judge_effects(plain)
    after = judge_effects(full(tmp_path))
    assert after["apertures"].verdict == before["apertures"].verdict
    assert (before["apertures"].present, after["apertures"].present) == (True, False)


@pytest.mark.parametrize("effects", ["auto", '["frame-dynamics", "panel-deformation"]', "[]"])
def test_what_a_case_leaves_out_already_does_not_come_back(tmp_path: Path, effects: str) -> None:
    """Flat panels do not become strips, and translating frames do not turn."""
    folder = case_folder(tmp_path, CASE, coarse=COARSE)
    judged = load_judged(folder, "coarse", [f"effects={effects}"])
    assert judged.case.panel.solver == "rigid"
    assert judged.case.frames.solver in ("two-mass", "prescribed")
