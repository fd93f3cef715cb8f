"""Loading: levels and --set laid over the case, and every mistake in one message."""

from __future__ import annotations

import pickle
from pathlib import Path

import pytest

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, LEVEL, case_folder, complaints, load_case, loaded, only_complaint

DEFAULT = 'default_level = "fine"\n'
FINE = "[panel]\ncells = [44, 16]\n"


def refused(folder: Path, level: str | None = None, *overrides: str) -> str:
    with pytest.raises(CaseError) as caught:
        load_judged(folder, level, overrides)
    return str(caught.value)


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
    assert 'did you mean "draft"?' in refused(folder, "drafts")
    assert "levels: draft, fine" in refused(folder, "../../etc/passwd")


def test_a_level_must_name_what_it_leaves_out_and_nothing_else(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, draft=LEVEL.replace('"variation-across"', '"gravity"'))
    message = refused(folder, "draft")
    assert 'levels/draft.toml without: "variation-across" must be named' in message
    assert '"gravity" is not left out' in message


def test_a_level_that_takes_the_particles_away_must_say_so(tmp_path: Path) -> None:
    empty = LEVEL.replace("[panel]", "bed.particles = 0\n[panel]")
    assert "0 is wrong" in refused(case_folder(tmp_path, draft=empty))
    weightless = LEVEL.replace("[panel]", "gravity_m_per_s2 = [0.0, 0.0, 0.0]\n[panel]")
    assert '"gravity" must be named' in refused(case_folder(tmp_path, draft=weightless))


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
        ("contacts.7.restitution=0.5", '"7" is no element of this list'),
        ("contacts.coal.restitution=0.5", "numbered 0 to 1"),
        ("duration_s=0.1\ntitle=2", "a valid number is wanted"),
        ("duration_s.x=1", "duration_s: {'x': 1} is wrong"),
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
    lines = refused(folder, None, "coupling.sync_interval_s=fast").splitlines()
    assert lines[0] == "4 problems in the case:"
    assert sorted(lines[1:]) == [
        "  --set coupling.sync_interval_s: 'fast' is wrong, a valid number is wanted",
        "  case.toml bed.particles.ball.sieve_size_m: -1 is wrong, greater than 0 is wanted",
        "  case.toml screen.panels.deck.thicknes_m: unknown key (its value: 0.004); "
        'did you mean "thickness_m"?',
        "  levels/draft.toml panel.solver: 'stripe' is not one of 'rigid', 'sheet', "
        "'solid' or 'strip'; did you mean \"strip\"?",
    ]


@pytest.mark.parametrize(
    ("override", "message"),
    [
        ("duration_s=true", "duration_s: true is wrong, a valid number is wanted"),
        ("duration_s=nan", "finite"),
        ("gravity_m_per_s2=[0, 1]", "gravity_m_per_s2: [0, 1] has too few values"),
        ("gravity_m_per_s2=[0, 1, 2, 3]", "[0, 1, 2, 3] has more than 3 values"),
        ("screen.panels.deck=3", "screen.panels.deck: 3 is wrong, a table is wanted"),
        ("bed.feeds.chute.rate_kg_per_s=1", "bed.feeds.chute.material: missing"),
        ("probes.a b.particle=1", "a name is made of letters"),
        ("panel.cells=[1.5, 2]", "panel.cells.0: 1.5 is wrong, a valid integer is wanted"),
    ],
)
def test_wrong_types_are_said_in_plain_words(tmp_path: Path, override: str, message: str) -> None:
    assert any(message in complaint for complaint in complaints(tmp_path, override))


def test_particles_need_something_to_touch(tmp_path: Path) -> None:
    bare = CASE.partition("[screen.panels.deck]")[0]
    ball = "[bed.particles.ball]\nposition_m = [0, 0, 0]\nsieve_size_m = 0.02\nmaterial = 'coal'\n"
    assert find_problems(load_case(tmp_path, bare)) == []
    (complaint,) = find_problems(load_case(tmp_path, bare + ball))
    assert "screen.panels: missing: there is nothing for particles to touch" in str(complaint)


def test_files_that_are_no_case_are_mistakes_of_the_user(tmp_path: Path) -> None:
    assert "no such case" in refused(tmp_path / "absent")
    assert "no such case" in refused(tmp_path)
    (tmp_path / "case.toml").write_text("title = ")
    assert "is not TOML" in refused(tmp_path)
    (tmp_path / "case.toml").write_bytes(b"\xff\xfe\x00binary")
    assert "is no text file" in refused(tmp_path)
    (tmp_path / "case.toml").write_text("a = " + "[" * 100_000)
    assert "nested too deeply" in refused(tmp_path)
    (tmp_path / "case.toml").write_text("[materials.PU]\n[materials.PU]\n")
    assert "twice" in refused(tmp_path)
    (tmp_path / "case.toml").write_text("default_level = 3")
    assert "no level 3" in refused(tmp_path)


def test_an_error_of_a_case_is_the_same_in_another_process() -> None:
    """Ranks and workers hand errors on."""
    error = CaseError([CaseProblem(("duration_s",), "is wrong"), CaseProblem(("panel", "cells"), "too")])
    same = pickle.loads(pickle.dumps(error))
    assert (str(same), same.problems) == (str(error), error.problems)
    assert "2 problems" in str(same)
