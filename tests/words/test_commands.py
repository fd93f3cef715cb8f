"""The output of commands, word for word: one snapshot for each, in ``__snapshots__``.

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
from tests.accuracy.test_chance import run_folder as measured_run
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
OutputOf = Callable[..., str]


@pytest.fixture
def output_of(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> OutputOf:
    """A function that returns what a command says in an empty folder, with its exit code.

    Lists that grow, the regime of a mat, which is chaotic, and the rules of tables are left out.
    """
    monkeypatch.chdir(tmp_path)
    for each in (console.CONSOLE, console.ERRORS):
        monkeypatch.setattr(each, "width", 200)

    def call(*words: str) -> str:
        done = CALL.invoke(app, words)
        streams = ("stdout", done.stdout), ("stderr", done.stderr)
        texts = [f"{name}:\n{text}" for name, text in streams if text]
        text = "\n".join([f"flipflow {' '.join(words)}", f"exit code {done.exit_code}", *texts])
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
    messages = {" ".join(words): complaints(tmp_path, *words) for words in overrides()}
    assert messages == snapshot


@pytest.mark.smoke
def test_check(output_of: OutputOf, case: str, snapshot: SnapshotAssertion) -> None:
    two = ["--set", "panel.solver=rigd", "--set", "duration_s=-1"]
    assert output_of("check", case, *CHEAP, *DAMPED) == snapshot(name="a right case")
    assert output_of("check", case, *two) == snapshot(name="two mistakes")
    assert output_of("check", case, *two, "--json") == snapshot(name="two mistakes as JSON")
    assert output_of("check", "absent") == snapshot(name="no case")
    assert output_of("check", case, "--level", "drft") == snapshot(name="no level")
    assert output_of("check", case, "--set", "nonsense") == snapshot(name="no override")
    assert output_of("check", case, "--json", "--ranks", "2") == snapshot(
        name="two options that exclude each other"
    )


@pytest.mark.smoke
def test_list(output_of: OutputOf, case: str, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    case_folder(tmp_path / "wrong", "title = 3")
    assert output_of("list", ".") == snapshot(name="two cases")
    assert output_of("list", "absent") == snapshot(name="no folder")


def test_explain(output_of: OutputOf, case: str, snapshot: SnapshotAssertion) -> None:
    assert output_of("explain", case, *CHEAP, *DAMPED) == snapshot(name="a case")
    assert output_of("explain", case, "--for", "eficiency") == snapshot(name="no result")
    assert output_of("explain", case, "--set", "duration_s=2e4") == snapshot(name="a mistake")


def test_materials(output_of: OutputOf, snapshot: SnapshotAssertion) -> None:
    assert output_of("materials") == snapshot(name="all")
    assert output_of("materials", "limestone") == snapshot(name="one")
    assert output_of("materials", "limestne") == snapshot(name="none")


def test_new(output_of: OutputOf, case: str, snapshot: SnapshotAssertion) -> None:
    assert output_of("new", case) == snapshot(name="a folder that exists")
    assert output_of("new", "next", "--template", "flipflop") == snapshot(name="no template")
    wrong = ["--stroke", "90 mm", "--speed", "8000 rpm", "--material", "limestne"]
    assert output_of("new", "next", "--template", "flip-flow", *wrong) == snapshot(name="wrong wishes")


def test_run(output_of: OutputOf, case: str, snapshot: SnapshotAssertion) -> None:
    assert output_of("run", "absent") == snapshot(name="no case")
    assert output_of("run", case, "--set", "panel.solver=rigd") == snapshot(name="a mistake")
    assert output_of("run", case, *CHEAP, "--out", case) == snapshot(name="a folder that exists")


@pytest.mark.parametrize("command", ["resume", "report"])
def test_commands_of_a_run(output_of: OutputOf, case: str, command: str, snapshot: SnapshotAssertion) -> None:
    assert output_of(command, "absent") == snapshot(name="no folder")
    assert output_of(command, case) == snapshot(name="the folder of a case")


def test_results(output_of: OutputOf, runs: list[str], snapshot: SnapshotAssertion) -> None:
    assert output_of("results", *runs) == snapshot(name="two runs")
    assert output_of("results", "absent") == snapshot(name="no run")
    assert output_of("results", *runs, "--out", "table.txt") == snapshot(name="no format")


def test_compare(output_of: OutputOf, runs: list[str], snapshot: SnapshotAssertion) -> None:
    assert output_of("compare", *runs) == snapshot(name="two runs")
    assert output_of("compare", "one") == snapshot(name="one run")
    assert output_of("compare", "one", "one") == snapshot(name="one run twice")


def test_plan(output_of: OutputOf, case: str, snapshot: SnapshotAssertion) -> None:
    assert output_of("plan", case, "--tolerance", "5", "--budget", "1h") == snapshot(name="no share")
    assert output_of("plan", case, "--tolerance", "5%", "--budget", "1 week") == snapshot(name="no time")
    given = ["--tolerance", "5%", "--budget", "1h", "--study", "absent.json"]
    assert output_of("plan", case, *CHEAP, *given) == snapshot(name="no study")


def test_plan_for(output_of: OutputOf, tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    case, run = str(ROOT / "cases/near-mesh"), measured_run(tmp_path / "run")
    (run / "checkpoints/0001").mkdir(parents=True)
    asked = ["plan", case, "--for", "efficiency", "--jobs", "2", "--from", "run"]
    assert output_of(*asked, "--tolerance", "5%", "--budget", "1h") == snapshot(name="a way")
    assert output_of(*asked, "--tolerance", "0.2 points", "--budget", "2min") == snapshot(name="no time")
    assert output_of(*asked, "--tolerance", "5 mm", "--budget", "1h") == snapshot(name="no tolerance")
    assert output_of(*asked, "--tolerance", "5", "--budget", "1h", "--for", "stroke") == snapshot(
        name="stroke"
    )


def test_study(output_of: OutputOf, case: str, snapshot: SnapshotAssertion) -> None:
    assert output_of("study", "sweeep") == snapshot(name="no study")
    assert output_of("study", "sweep", case, "--vary", "duration_s=a:b:c") == snapshot(name="no range")
    assert output_of("study", "sweep", case, "--vary", "titel=1,2") == snapshot(name="no key")
    assert output_of("study", "accuracy", case, "--parameters", "panel-mash") == snapshot(name="no parameter")
    assert output_of("study", "paper", case) == snapshot(name="no criteria")
