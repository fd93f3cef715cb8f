"""The command line: exit codes, messages without traceback, help that teaches."""

from __future__ import annotations

from pathlib import Path

import numpy
import pytest
from typer.testing import CliRunner

import flipflow
from orchestrator.case import shipped
from orchestrator.case.file.base import level_names
from orchestrator.cli import launch
from orchestrator.cli.main import app
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, case_folder

CASES = Path(__file__).parents[2] / "cases"
CALL = CliRunner()


def test_check_describes_no_panels_where_there_are_none(tmp_path: Path) -> None:
    done = CALL.invoke(app, ["check", str(CASES / "shear-spring")])
    assert done.exit_code == 0, done.output
    lines = done.output.splitlines()
    assert "  panels     none" in lines
    assert not [line for line in lines if "triangles" in line or "cells each" in line]
    done = CALL.invoke(app, ["check", str(case_folder(tmp_path))])
    assert any(
        line.startswith("  triangles  ") and " on each panel, " in line for line in done.output.splitlines()
    )


def test_mistakes_may_hold_brackets_that_are_no_markup(tmp_path: Path) -> None:
    done = CALL.invoke(app, ["check", str(case_folder(tmp_path)), "--set", "title=['[/bold]']"])
    assert done.exit_code == 2
    assert "title: must be a text, not ['[/bold]']" in done.stderr


@pytest.mark.parametrize(
    "words", [["check", "absent"], ["check"], ["check", "a", "--bad"], ["nonsense"], ["list", "absent"]]
)
def test_a_wrong_command_exits_with_2_and_says_why(words: list[str]) -> None:
    done = CALL.invoke(app, words)
    assert done.exit_code == 2
    assert done.stderr
    assert "Traceback" not in done.output


def test_run_hands_everything_over_and_exits_with_its_code(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls = []

    def fake_run(*given: object) -> int:
        calls.append(given)
        return 4

    monkeypatch.setattr(launch, "run", fake_run)
    words = ["run", "cases/x", "--level", "draft", "--out", "runs/y", "--set", "a=1", "--set", "b=2"]
    assert CALL.invoke(app, words).exit_code == 4
    assert calls == [(Path("cases/x"), "draft", Path("runs/y"), ["a=1", "b=2"], 60.0)]


def test_cases_that_come_with_the_program_have_names_everywhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Names of shipped cases work outside of the clone, where a user's own cases are; one's own case of the
    same name comes first."""
    monkeypatch.chdir(tmp_path)
    listed = CALL.invoke(app, ["list"])
    assert listed.exit_code == 0
    assert "\nquickstart  Two panels between" in listed.output
    for name in ("ball-on-panel", "cases/ball-on-panel", "ball-on-panel/case.toml"):
        done = CALL.invoke(app, ["check", name, "--level", "draft"])
        assert done.exit_code == 0, done.output
        assert done.output.startswith("ball-on-panel, level draft: ")
    assert flipflow.load("ball-on-panel").folder == shipped.SHIPPED / "ball-on-panel"
    done = CALL.invoke(app, ["check", "qickstart"])
    assert done.exit_code == 2
    assert 'did you mean "quickstart"?' in done.stderr
    case_folder(tmp_path / "cases/mine", CASE)
    case_folder(tmp_path / "ball-on-panel", CASE)
    assert CALL.invoke(app, ["check", "ball-on-panel"]).output.startswith("ball-on-panel, no level: a test")
    names = [line.split()[0] for line in CALL.invoke(app, ["list"]).output.splitlines() if line[0] != " "]
    assert names[0] == "cases/mine"
    assert "quickstart" in names


LEVELS = [
    (case.parent.name, level)
    for case in sorted(CASES.glob("*/case.toml"))
    for level in level_names(case.parent)
]
UNDER_COAL = ("banana", *(name for name, _ in LEVELS if name.startswith("ffs0827")))
MARGINS = "the slice has openings from side to side"
SMALL = "the deck is too small"  # for its feed, by handbooks
ROLLING = "lone spheres "  # never reach a steady speed with the paper's rolling friction
FLOWING = (  # coarse coal on a narrow slice
    "coal: ",
    SMALL,
    MARGINS,
    ROLLING,  # at the levels of its base, whose bed is thin
    "the openings of panel deck-1 and 7 more are smaller than all particles",
    "slice.width_m = 0.048 m is ",
)
PAIR = ("the openings of panel deck-1 and 1 more are smaller than all particles", MARGINS)
ACCEPTED = {
    "ffs0827": (
        "coal: ",
        ROLLING,
        SMALL,
        "the openings of panel deck-1 and 7 more are smaller than all particles",
    ),
    "motor-start": (ROLLING,),
    "near-mesh": (MARGINS, ROLLING, SMALL),
    "wedged-grains": (
        "the openings of panel mat are smaller than all particles",
        "no wall ",
        "no back wall ",
    ),
    "quickstart": (ROLLING,),
    "ffs0827-effects": ("coal: ", MARGINS, ROLLING, SMALL, "slice.width_m = 0.03 m is "),
    "ffs0827-flowing": FLOWING,
    "ffs0827-flowing-twelve-springs": FLOWING,
    "iron-ore": (MARGINS, SMALL, "slice.width_m = 0.048 m is "),
    "ffs0827-panelpair": PAIR,
    "ffs0827-panelpair-twelve-springs": PAIR,
}
"""Beginnings of the warnings that the READMEs of these cases explain, by case."""
MATS = "mat deck"  # published machines do not say how their mats are mounted: flat ones arch up
FINES = ("coal: ", MARGINS, ROLLING, SMALL)  # accepted in all cases under coal


@pytest.mark.parametrize(("case", "level"), LEVELS)
def test_every_case_is_without_mistakes_at_every_level(case: str, level: str) -> None:
    judged = load_judged(CASES / case, level)
    assert find_problems(judged) == []
    accepted = ACCEPTED.get(case, FINES if case in UNDER_COAL else ())
    assert [line for line in warnings(judged) if not line.startswith((MATS, *accepted))] == []
    assert (CASES / case / "README.md").is_file()


def test_version_names_what_the_program_stands_on() -> None:
    done = CALL.invoke(app, ["--version"])
    assert done.exit_code == 0
    versions = dict(line.split(maxsplit=1) for line in done.output.splitlines())
    assert versions["numpy"] == numpy.__version__
    assert {"flipflow", "exudyn", "liggghts", "commit"} <= set(versions)
