"""What commands say, word for word: one snapshot for each, in ``__snapshots__``.

A change of words is reviewed there: ``pytest -n 0 tests/words --snapshot-update`` writes what they say now.
All other tests ask for exit codes, keys, kinds and numbers.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable
from pathlib import Path

import pytest
from syrupy.assertion import SnapshotAssertion
from typer.testing import CliRunner

from orchestrator.cli import console
from orchestrator.cli.main import app
from tests.case import test_apertures, test_checks, test_slice, test_units
from tests.case.test_apertures import KEY, SLOTTED
from tests.cases import CASE, LEVEL, case_folder, complaints
from tests.results.test_comparison import estimate, run_folder
from tests.runs.outside import ROOT

CALL = CliRunner(env={"COLUMNS": "200", "TERM": "dumb"})
CHEAP = (
    "--set",
    "frames.solver=two-mass",
    "--set",
    "panel.solver=rigid",
    "--set",
    "particles.solver=spheres",
)
DAMPED = ("--set", "screen.bushings.isolation.damping_N_s_per_m=[100, 100, 100]")
QUICKSTART = str(ROOT / "cases/quickstart")
Said = Callable[..., str]


@pytest.fixture
def said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Said:
    """A function that returns what a command says in an empty folder, with its exit code.

    Lists that grow, the regime of a mat, which is chaotic, and the rules of tables are left out.
    """
    monkeypatch.chdir(tmp_path)
    for each in (console.CONSOLE, console.ERRORS):
        monkeypatch.setattr(each, "width", 200)

    def call(*words: str) -> str:
        done = CALL.invoke(app, words)
        streams = ("stdout", done.stdout), ("stderr", done.stderr)
        told = [f"{name}:\n{text}" for name, text in streams if text]
        text = "\n".join([f"flipflow {' '.join(words)}", f"exit code {done.exit_code}", *told])
        text = text.replace(str(ROOT), "PROGRAM").replace(str(tmp_path), "HERE")
        text = re.sub(r"(shipped cases: |There are: |mat deck, empty: |move with it: ).*", r"\1...", text)
        text = re.sub(
            r"^[\s\u2500-\u257f+=|-]*[\u2500-\u257f+=-]{3}[\s\u2500-\u257f+=|-]*\n", "", text, flags=re.M
        )
        return re.sub(r" +$", "", re.sub(r"[\u2500-\u257f]", "|", text), flags=re.M)

    return call


@pytest.fixture
def case(tmp_path: Path) -> str:
    """The folder "mine" with the test case and a level."""
    return case_folder(tmp_path / "mine", CASE, draft=LEVEL).name


@pytest.fixture
def runs(tmp_path: Path) -> list[str]:
    """Two runs, of which the second is doubtful and longer."""
    run_folder(tmp_path / "one", estimate(0.30, 0.03))
    longer = CASE.replace("duration_s = 0.1", "duration_s = 0.2")
    run_folder(tmp_path / "two", estimate(0.39, 0.03), longer, status="doubtful", doubts=["It leaks."])
    return ["one", "two"]


def rows(test: Callable[..., None]) -> Iterable[str | list[str]]:
    """Return the first parameters of a test with many rows."""
    marks: list[pytest.Mark] = vars(test)["pytestmark"]
    return [row[0] for row in marks[0].args[1]]


def overrides() -> list[list[str]]:
    """Return the overrides of the mistakes in a case that the tests of the room ``case`` know."""
    single = [
        *rows(test_checks.test_one_mistake_is_found_at_its_key),
        *rows(test_checks.test_slips_of_units_and_what_is_out_of_all_proportion_are_refused),
        *(
            str(row).replace("'", '"')
            for row in rows(test_units.test_wrong_units_are_refused_with_file_and_key)
        ),
    ]
    several = [[*row] for row in rows(test_slice.test_a_slice_that_makes_no_sense_is_refused)]
    openings = [[SLOTTED, f"{KEY}{row}"] for row in rows(test_apertures.test_patterns_that_cannot_be)]
    table = tomllib.loads((Path(__file__).parent / "mistakes.toml").read_text(encoding="utf-8"))
    listed = [row["sets"] for row in table["mistakes"]]
    return [*([str(row)] for row in single), *several, *openings, *listed]


@pytest.mark.slow
def test_mistakes_in_a_case(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    said = {" ".join(words): complaints(tmp_path, *words) for words in overrides()}
    assert said == snapshot


@pytest.mark.smoke
def test_check(said: Said, case: str, snapshot: SnapshotAssertion) -> None:
    two = ["--set", "panel.solver=rigd", "--set", "duration_s=-1"]
    assert said("check", case, *CHEAP, *DAMPED) == snapshot(name="a right case")
    assert said("check", case, *two) == snapshot(name="two mistakes")
    assert said("check", case, *two, "--json") == snapshot(name="two mistakes as JSON")
    assert said("check", "absent") == snapshot(name="no case")
    assert said("check", case, "--level", "drft") == snapshot(name="no level")
    assert said("check", case, "--set", "nonsense") == snapshot(name="no override")
    assert said("check", case, "--json", "--ranks", "2") == snapshot(
        name="two options that exclude each other"
    )


@pytest.mark.smoke
def test_list(said: Said, case: str, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    case_folder(tmp_path / "wrong", "title = 3")
    assert said("list", ".") == snapshot(name="two cases")
    assert said("list", "absent") == snapshot(name="no folder")


def test_explain(said: Said, case: str, snapshot: SnapshotAssertion) -> None:
    assert said("explain", case, *CHEAP, *DAMPED) == snapshot(name="a case")
    assert said("explain", case, "--for", "eficiency") == snapshot(name="no result")
    assert said("explain", case, "--set", "duration_s=2e4") == snapshot(name="a mistake")


def test_materials(said: Said, snapshot: SnapshotAssertion) -> None:
    assert said("materials") == snapshot(name="all")
    assert said("materials", "limestone") == snapshot(name="one")
    assert said("materials", "limestne") == snapshot(name="none")


def test_new(said: Said, case: str, snapshot: SnapshotAssertion) -> None:
    assert said("new", case) == snapshot(name="a folder that exists")
    assert said("new", "next", "--template", "flipflop") == snapshot(name="no template")
    wrong = ["--stroke", "90 mm", "--speed", "8000 rpm", "--material", "limestne"]
    assert said("new", "next", "--template", "flip-flow", *wrong) == snapshot(name="wrong wishes")


def test_run(said: Said, case: str, snapshot: SnapshotAssertion) -> None:
    assert said("run", "absent") == snapshot(name="no case")
    assert said("run", case, "--set", "panel.solver=rigd") == snapshot(name="a mistake")
    assert said("run", case, *CHEAP, "--out", case) == snapshot(name="a folder that exists")


@pytest.mark.parametrize("command", ["resume", "report"])
def test_commands_of_a_run(said: Said, case: str, command: str, snapshot: SnapshotAssertion) -> None:
    assert said(command, "absent") == snapshot(name="no folder")
    assert said(command, case) == snapshot(name="the folder of a case")


def test_results(said: Said, runs: list[str], snapshot: SnapshotAssertion) -> None:
    assert said("results", *runs) == snapshot(name="two runs")
    assert said("results", "absent") == snapshot(name="no run")
    assert said("results", *runs, "--out", "table.txt") == snapshot(name="no format")


def test_compare(said: Said, runs: list[str], snapshot: SnapshotAssertion) -> None:
    assert said("compare", *runs) == snapshot(name="two runs")
    assert said("compare", "one") == snapshot(name="one run")
    assert said("compare", "one", "one") == snapshot(name="one run twice")


def test_plan(said: Said, case: str, snapshot: SnapshotAssertion) -> None:
    assert said("plan", case, "--tolerance", "5", "--budget", "1h") == snapshot(name="no share")
    assert said("plan", case, "--tolerance", "5%", "--budget", "1 week") == snapshot(name="no time")
    given = ["--tolerance", "5%", "--budget", "1h", "--study", "absent.json"]
    assert said("plan", case, *CHEAP, *given) == snapshot(name="no study")


def test_study(said: Said, case: str, snapshot: SnapshotAssertion) -> None:
    assert said("study", "sweeep") == snapshot(name="no study")
    assert said("study", "sweep", case, "--vary", "duration_s=a:b:c") == snapshot(name="no range")
    assert said("study", "sweep", case, "--vary", "titel=1,2") == snapshot(name="no key")
    assert said("study", "accuracy", case, "--parameters", "panel-mash") == snapshot(name="no parameter")
    assert said("study", "paper", case) == snapshot(name="no criteria")
