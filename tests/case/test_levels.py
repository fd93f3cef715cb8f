"""Loading: levels and --set laid over the case, and every mistake in one message."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from orchestrator.case.file.errors import CaseError, CaseProblem, dotted_key
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, LEVEL, case_folder, keys_and_kinds, kinds, load_case, loaded, only_complaint

DEFAULT = 'default_level = "fine"\n'
FINE = "[panel]\ncells = [44, 16]\n"


def refused(folder: Path, level: str | None = None, *overrides: str) -> tuple[CaseProblem, ...]:
    with pytest.raises(CaseError) as caught:
        load_judged(folder, level, overrides)
    return caught.value.problems


@pytest.mark.smoke
def test_a_level_overlays_the_case_and_set_overlays_the_level(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, draft=LEVEL, fine=FINE)
    assert load_judged(folder, "draft").case.panel.solver == "strip"
    assert load_judged(folder, "draft", ["panel.solver=rigid"]).case.panel.solver == "rigid"
    assert load_judged(folder, "fine").case.panel.cells == (44, 16)
    assert load_judged(folder, "fine").case.panel.solver == "sheet"


def test_the_level_is_the_one_asked_for_or_the_default_or_the_only_one(tmp_path: Path) -> None:
    assert load_case(tmp_path).level == ""
    assert load_judged(case_folder(tmp_path, draft=LEVEL)).level == "draft"
    assert load_judged(case_folder(tmp_path, fine=FINE)).level == ""
    assert load_case(tmp_path, DEFAULT + CASE).level == "fine"
    assert load_judged(tmp_path / "case.toml", "draft").level == "draft"


def test_an_unknown_level_is_refused_with_the_nearest(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, draft=LEVEL, fine=FINE)
    for level, known in (("drafts", ["draft"]), ("../../etc/passwd", ["draft", "fine"])):
        (problem,) = refused(folder, level)
        assert (problem.file, problem.kind) == ("--level", "unknown-name")
        assert [name for name in ("draft", "fine") if name in problem.hint] == known


def test_a_level_must_name_what_it_leaves_out_and_nothing_else(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, draft=LEVEL.replace('"variation-across"', '"gravity"'))
    problems = refused(folder, "draft")
    assert {row.file for row in problems} == {"levels/draft.toml"}
    assert keys_and_kinds(problems) == ["without: conflict"] * 2
    assert sorted(row.what.split('"')[1] for row in problems) == ["gravity", "variation-across"]


def test_a_level_that_takes_the_particles_away_must_say_so(tmp_path: Path) -> None:
    empty = LEVEL.replace("[panel]", "bed.particles = 0\n[panel]")
    assert keys_and_kinds(refused(case_folder(tmp_path, draft=empty))) == ["bed.particles: wrong-type"]
    weightless = LEVEL.replace("[panel]", "gravity_m_per_s2 = [0.0, 0.0, 0.0]\n[panel]")
    (problem,) = refused(case_folder(tmp_path, draft=weightless))
    assert keys_and_kinds([problem]) == ["without: conflict"]
    assert '"gravity"' in problem.what


def test_what_a_run_leaves_out_and_what_physics_changed_is_known(tmp_path: Path) -> None:
    judged = loaded(tmp_path, ["exchange.particle_load=false", "screen.panels.deck.width_m=0.1"])
    assert set(judged.left_out) == {"grain-shape", "particle-load"}
    assert judged.changed == ("screen.panels.deck.width_m",)


def test_set_reaches_tables_and_elements_of_lists(tmp_path: Path) -> None:
    given = ["contacts.1.restitution=0.5", "gravity_m_per_s2=[0, 0, -1.6]", "title=plain words"]
    case = loaded(tmp_path, given).case
    assert case.contacts[1].restitution == 0.5
    assert case.contacts[1].between == ("coal", "coal")
    assert case.gravity_m_per_s2 == (0.0, 0.0, -1.6)
    assert case.title == "plain words"
    assert loaded(tmp_path, ["bed.particles.ball.position_m.2=0.07"]).case.bed.particles[
        "ball"
    ].position_m == (0.15, 0.1, 0.07)


@pytest.mark.parametrize(
    ("override", "text"),
    [
        ("panel.solver", "is not key=value"),
        ("=3", "is not key=value"),
        ("panel..solver=rigid", "is not key=value"),
        ("contacts.7.restitution=0.5", '"7" is not an element of this list'),
        ("contacts.coal.restitution=0.5", "numbered 0 to 1"),
        ("duration_s=0.1\ntitle=2", "must be a number"),
        ("duration_s.x=1", "duration_s: must be a number, not {'x': 1}"),
    ],
)
def test_a_wrong_set_is_a_mistake_of_the_user(tmp_path: Path, override: str, text: str) -> None:
    message = only_complaint(tmp_path, override)
    assert message.startswith("--set")
    assert text in message


@pytest.mark.smoke
def test_all_mistakes_come_in_one_message_with_file_key_value_and_suggestion(tmp_path: Path) -> None:
    case = CASE.replace("thickness_m", "thicknes_m").replace("sieve_size_m = 0.02", "sieve_size_m = -1")
    folder = case_folder(tmp_path, case, draft=LEVEL.replace("strip", "stripe"))
    problems = refused(folder, None, "coupling.sync_interval_s=fast")
    rows = {(row.file, dotted_key(row.key), row.kind): row for row in problems}
    for place, value, suggestion in (
        (("--set", "coupling.sync_interval_s", "wrong-type"), "'fast'", ""),
        (("case.toml", "bed.particles.ball.sieve_size_m", "out-of-range"), "-1", ""),
        (("case.toml", "screen.panels.deck.thicknes_m", "unknown-key"), "0.004", '"thickness_m"'),
        (("levels/draft.toml", "panel.solver", "unknown-name"), "'stripe'", '"strip"'),
    ):
        problem = rows.pop(place)
        assert value in problem.what
        assert suggestion in problem.hint
    assert not rows


def test_a_diameter_is_told_to_be_a_sieve_size(tmp_path: Path) -> None:
    """One problem, since the key that is missing is the one that was meant."""
    (problem,) = refused(case_folder(tmp_path, CASE.replace("sieve_size_m = 0.02", "diameter_m = 0.02")))
    assert (dotted_key(problem.key), problem.kind) == ("bed.particles.ball.diameter_m", "unknown-key")
    assert '"sieve_size_m"' in problem.hint


@pytest.mark.parametrize(
    ("override", "kind"),
    [
        ("duration_s=true", "duration_s: wrong-type"),
        ("duration_s=nan", "duration_s: out-of-range"),
        ("gravity_m_per_s2=[0, 1]", "gravity_m_per_s2: wrong-type"),
        ("gravity_m_per_s2=[0, 1, 2, 3]", "gravity_m_per_s2: wrong-type"),
        ("screen.panels.deck=3", "screen.panels.deck: wrong-type"),
        ("bed.feeds.chute.rate_kg_per_s=1", "bed.feeds.chute.material: missing"),
        ("probes.ab!.particle=1", "probes.ab!: wrong-type"),
        ("panel.cells=[1.5, 2]", "panel.cells.0: wrong-type"),
    ],
)
def test_wrong_types_are_said_in_plain_words(tmp_path: Path, override: str, kind: str) -> None:
    assert kind in kinds(tmp_path, override)


def test_particles_need_something_to_touch(tmp_path: Path) -> None:
    bare = CASE.partition("[screen.panels.deck]")[0]
    ball = "[bed.particles.ball]\nposition_m = [0, 0, 0]\nsieve_size_m = 0.02\nmaterial = 'coal'\n"
    assert find_problems(load_case(tmp_path, bare)) == []
    (complaint,) = find_problems(load_case(tmp_path, bare + ball))
    assert "screen.panels: missing: there is nothing for particles to touch" in str(complaint)


def test_files_that_are_no_case_are_mistakes_of_the_user(tmp_path: Path) -> None:
    assert keys_and_kinds(refused(tmp_path / "absent")) == [": file"]
    assert keys_and_kinds(refused(tmp_path)) == [": file"]
    for content in (
        b"title = ",
        b"\xff\xfe\x00binary",
        b"a = " + b"[" * 100_000,  # nested too deeply
        b"[materials.PU]\n[materials.PU]\n",
    ):
        (tmp_path / "case.toml").write_bytes(content)
        assert keys_and_kinds(refused(tmp_path)) == [": file"], content[:20]
    (tmp_path / "case.toml").write_text("default_level = 3")
    assert keys_and_kinds(refused(tmp_path)) == ["default_level: unknown-name"]


def test_an_error_of_a_case_is_the_same_in_another_process() -> None:
    """Ranks and workers hand errors on."""
    error = CaseError([CaseProblem(("duration_s",), "is wrong"), CaseProblem(("panel", "cells"), "too")])
    same = pickle.loads(pickle.dumps(error))
    assert (str(same), same.problems) == (str(error), error.problems)
    assert "2 problems" in str(same)
