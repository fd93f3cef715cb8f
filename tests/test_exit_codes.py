"""The exit codes of commands, and the numbers that their options stand for."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.cli import plan
from orchestrator.cli import studies as commands
from orchestrator.cli.console import reported_errors
from orchestrator.cli.main import app
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.run.interruption import ImmediateStop
from tests.accuracy.test_plan import TIMING, study
from tests.runs.outside import ROOT

CALL = CliRunner()
STUDY = '''
def command():
    """End well, or not."""
    yield "a line"
    return {}
'''


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (CaseError([CaseProblem(("duration_s",), "missing")]), 2),
        (FolderUnusable("a folder"), 2),
        (FileNotFoundError(2, "No such file", "a"), 2),
        (MemoryError(), 2),
        (SolverMissing("exudyn"), 3),
        (SolverFailed("panels at 0.1 s"), 4),
        (KeyboardInterrupt(), 130),
        (ImmediateStop(signal.SIGTERM, "stopped"), 143),
        (ImmediateStop(signal.SIGHUP, "stopped"), 129),
    ],
)
def test_each_error_has_its_code(error: BaseException, code: int) -> None:
    with pytest.raises(typer.Exit) as ended, reported_errors():
        raise error
    assert ended.value.exit_code == code


@pytest.mark.parametrize("error", [ValueError("a bug"), BrokenPipeError()])
def test_an_internal_error_stays_as_it_is(error: Exception) -> None:
    with pytest.raises(type(error)), reported_errors():
        raise error


@pytest.mark.parametrize(("ends_well", "code"), [(True, 0), (False, 4)])
def test_a_study_that_does_not_succeed_ends_with_4(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ends_well: bool, code: int
) -> None:
    name = f"ends_{str(ends_well).lower()}"
    (tmp_path / f"{name}.py").write_text(STUDY.format(ends_well), encoding="utf-8")
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    done = CALL.invoke(app, ["study", name.replace("_", "-")])
    assert (done.exit_code, done.stdout) == (code, "a line\n")


@pytest.mark.parametrize(("budget", "code"), [("17s", 4), ("24s", 0), ("0.5min", 0)])
def test_a_plan_beyond_its_budget_ends_with_4(
    monkeypatch: pytest.MonkeyPatch, budget: str, code: int
) -> None:
    """24 s are wanted within 6 % (tests/accuracy/test_plan.py)."""
    monkeypatch.setattr(plan, "find_study", lambda loaded, given: study())
    monkeypatch.setattr(plan, "time_by_study", lambda measured, case, level: TIMING)
    words = ["--level", "draft", "--set", "duration_s=0.5", "--tolerance", "6%", "--budget", budget]
    done = CALL.invoke(app, ["plan", str(ROOT / "cases/quickstart"), *words])
    assert done.exit_code == code, done.output


@pytest.mark.parametrize(
    ("text", "time_s"),
    [("90", 90.0), ("90s", 90.0), ("30min", 1800.0), ("1h", 3600.0), ("2 d", 172800.0), ("0.5h", 1800.0)],
)
def test_a_budget_is_a_time(text: str, time_s: float) -> None:
    assert plan.parse_time_s(text) == pytest.approx(time_s)


@pytest.mark.parametrize(("text", "share"), [("5%", 0.05), ("0.05", 0.05), ("0.5%", 0.005)])
def test_a_tolerance_is_a_share(text: str, share: float) -> None:
    assert plan.parse_share(text) == pytest.approx(share)


@pytest.mark.parametrize("text", ["", "5", "0%", "-1%", "a"])
def test_what_is_no_share_ends_with_2(text: str) -> None:
    with pytest.raises(typer.Exit) as ended:
        plan.parse_share(text)
    assert ended.value.exit_code == 2


@pytest.mark.parametrize("text", ["", "h", "0s", "-1h", "5 weeks", "inf"])
def test_what_is_no_time_ends_with_2(text: str) -> None:
    with pytest.raises(typer.Exit) as ended:
        plan.parse_time_s(text)
    assert ended.value.exit_code == 2
