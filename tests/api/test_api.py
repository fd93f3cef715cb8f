"""The public package: what a script or a notebook does with a case and its run."""

from __future__ import annotations

import os
import shutil
import signal
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

import flipflow
import flipflow.run
from orchestrator.case.file.layers import Layers, parse_override
from orchestrator.output.records.summary import write_summary
from orchestrator.run.progress import ProgressReport, parse_report
from tests.cases import CASE, case_folder

ROOT = Path(__file__).parents[2]
EMPTY = ROOT / "cases/empty-machine"


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> flipflow.Run:
    case = flipflow.load(EMPTY, "draft").change({"duration_s": 0.24, "output.pictures": False})
    return case.run(tmp_path_factory.mktemp("api") / "run")


def test_a_case_knows_its_levels_and_values() -> None:
    case = flipflow.load(EMPTY / "case.toml")
    assert (case.level, case.levels) == ("default", ["default", "draft"])
    assert case["panel.solver"] == "sheet"
    assert case.at_level("draft")["panel.solver"] == "strip"
    with pytest.raises(KeyError, match=r"panel\.sulver"):
        case["panel.sulver"]


def test_a_level_may_be_a_path_and_overrides_a_line_or_a_list() -> None:
    """A path was an AttributeError, of one line each letter was an override, and a list could not grow."""
    case = flipflow.load(EMPTY, EMPTY / "levels/draft.toml", "duration_s=0.5")
    assert (case["panel.solver"], case["duration_s"]) == ("strip", 0.5)
    assert flipflow.load(EMPTY, "draft", ["duration_s=0.5"]).change({"duration_s": 2})["duration_s"] == 2.0


def test_a_case_over_another_one_has_the_default_level_and_the_levels_of_both() -> None:
    case = flipflow.load(ROOT / "cases/ffs0827-flowing")
    assert case.level == "draft"
    assert {"draft", "study", "reference"} <= set(case.levels)
    assert case["screen.frames.driven.mass_kg"] == 287.0


def test_changes_are_those_of_the_command_line() -> None:
    case = flipflow.load(EMPTY, "draft").change(
        {
            "screen.exciters.shaft": {"mass_moment_kg_m": np.float64(0.4)},
            "screen.inclination_deg": 12,
            "panel.solver": "rigid",
            "screen.frames.driven.center_of_mass_m": np.array([0.3, 0.1, 0.0]),
        }
    )
    assert case["screen.exciters.shaft.mass_moment_kg_m"] == 0.4
    assert case["screen.inclination_deg"] == 12.0
    assert case["panel.solver"] == "rigid"
    assert case["screen.frames.driven.center_of_mass_m"] == [0.3, 0.1, 0.0]
    assert flipflow.load(EMPTY, "draft")["panel.solver"] == "strip", "a change changed the case itself"


@pytest.mark.parametrize(
    ("value", "same"),
    [
        ('two  blanks\tand a \\ and an = and a "', None),
        ({"a": [1.0, {"b c": [True, "x  y"]}]}, None),
        ([np.float64(0.1), np.int64(2), np.bool_(True)], [0.1, 2, True]),
        ([{"between": ["PU", "coal"], "about": "a text that is longer than a line of TOML " * 4}], None),
        (Path("a  folder/bed.csv"), "a  folder/bed.csv"),
    ],
)
def test_values_arrive_as_they_are(value: object, same: object) -> None:
    """Blanks in texts, tables in lists, and numbers of NumPy in lists."""
    changed = flipflow.load(EMPTY).change({"top.key": value})  # type: ignore[dict-item]
    layers = Layers({}, "")
    for line in changed.overrides:
        layers.lay(parse_override(line), "--set")
    assert layers.merged == {"top": {"key": value if same is None else same}}


def test_another_file_is_not_taken_for_the_case_beside_it(tmp_path: Path) -> None:
    case_folder(tmp_path)
    (tmp_path / "other.toml").write_text(CASE.replace("a test", "another"))
    with pytest.raises(flipflow.CaseError, match=r"other\.toml:"):
        flipflow.load(tmp_path / "other.toml")


ITEM = "monitor.items.nosuch"


def test_problems_are_lines_and_nothing_is_run(tmp_path: Path) -> None:
    case = flipflow.load(EMPTY, "draft").change({"panel.sulver": "rigid", "duration_s": -1})
    problems = case.check()
    assert len(problems) == 2
    assert any("sulver" in line and "solver" in line for line in problems)
    with pytest.raises(flipflow.CaseError, match="sulver"):
        case.run(tmp_path / "run")
    assert not (tmp_path / "run").exists()
    unknown = flipflow.load(EMPTY, "draft").change({f"{ITEM}.limit": 1.0, f"{ITEM}.then": "warn"})
    assert any("nosuch" in line for line in unknown.check())
    with pytest.raises(flipflow.CaseError, match="nosuch"):
        unknown.run(tmp_path / "run")
    with pytest.raises(flipflow.CaseError, match="no such case"):
        flipflow.load(tmp_path)
    with pytest.raises(flipflow.CaseError, match="draft"):
        flipflow.load(EMPTY, "daft")


@pytest.mark.process
@pytest.mark.solver
def test_a_run_has_results_series_and_its_case(run: flipflow.Run) -> None:
    assert (run.status, run.is_trusted, run.doubts) == ("done", True, [])
    assert run.unsteady == ["averaged over 1 cycle; 4 are needed to see it settle"]
    assert run.unsteady[0] in run._repr_html_()
    assert run["stroke"].value == run.results.loc["stroke", "value"] > 1e-3
    assert flipflow.load(run.folder)["duration_s"] == 0.24
    driven = run.history("frames/driven")
    assert driven.index.name == "time_s"
    assert driven.index[-1] == pytest.approx(0.24)
    assert {"displacement_m.x", "velocity_m_per_s.z"} <= set(driven.columns)
    assert "frames/driven" in run.groups
    with pytest.raises(KeyError, match="frames/driven"):
        run.history("frames/drivn")
    with pytest.raises(KeyError, match="stroke"):
        run["strok"]
    with pytest.raises(KeyError, match="does not have"):
        run["efficiency"]
    assert "stroke" in run._repr_html_()
    again = flipflow.open_run(run.folder)
    assert again["stroke"] == run["stroke"]


@pytest.mark.process
@pytest.mark.solver
def test_runs_that_begin_together_have_folders_of_their_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two threads of a notebook; the folders are still theirs when the notebook goes elsewhere."""
    monkeypatch.chdir(tmp_path)
    case = flipflow.load(EMPTY, "draft").change({"duration_s": 0.1, "output.pictures": False})
    with ThreadPoolExecutor(2) as threads:
        made = [*threads.map(lambda _: case.run(), range(2))]
    assert {run.folder.name for run in made} == {"empty-machine-1", "empty-machine-2"}
    monkeypatch.chdir("/")
    assert all("frames/driven" in run.groups for run in made)


def test_a_run_has_one_process_or_more(tmp_path: Path) -> None:
    """``mpirun -n 0`` takes as many processes as there are cores."""
    with pytest.raises(ValueError, match="process"):
        flipflow.load(EMPTY, "draft").run(tmp_path / "run", ranks=0)


@pytest.mark.process
@pytest.mark.solver
def test_an_interrupted_run_can_be_resumed(tmp_path: Path) -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it
    case = flipflow.load(EMPTY, "draft").change({"duration_s": 20.0, "output.pictures": False})
    seen: list[ProgressReport] = []

    def interrupt_soon(report: ProgressReport) -> None:
        if not seen:
            threading.Timer(0.1, os.kill, (os.getpid(), signal.SIGINT)).start()
        seen.append(report)

    with pytest.raises(flipflow.RunInterrupted) as stopped:
        case.run(tmp_path / "run", interrupt_soon)
    run = stopped.value.run
    assert run is not None
    assert run.status == "interrupted"
    assert 0 < seen[0].share < 1
    end_s = run.summary["simulated_s"] + 0.01
    resumed = run.resume([f"duration_s={round(end_s, 2)}"])
    assert resumed.status == "done"
    assert resumed.summary["simulated_s"] > run.summary["simulated_s"]


def say(monkeypatch: pytest.MonkeyPatch, program: str) -> None:
    """Let a short program stand for the process of a run."""
    monkeypatch.setattr(flipflow.run, "MAIN", f"import os, sys, time; {program}")


def test_a_refused_run_does_not_hand_out_the_run_that_was_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_summary(tmp_path, {"status": "done"})
    say(monkeypatch, "sys.exit('exists already' and 2)")
    with pytest.raises(flipflow.RunFailed) as refused:
        flipflow.load(EMPTY, "draft").run(tmp_path)
    assert refused.value.run is None


def test_a_run_is_resumed_on_as_many_processes_as_it_had(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write_summary(tmp_path, {"status": "interrupted"})
    (tmp_path / "provenance.json").write_text('{"ranks": 4}')
    asked: list[int] = []
    monkeypatch.setattr(flipflow.run, "_launcher", lambda ranks: asked.append(ranks) or [])
    say(monkeypatch, "sys.exit(0)")
    flipflow.open_run(tmp_path).resume()
    assert asked == [4]


@pytest.mark.parametrize(("name", "kind"), [("SIGSEGV", "RunFailed"), ("SIGTERM", "RunInterrupted")])
def test_a_crash_is_no_interruption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, kind: str
) -> None:
    say(monkeypatch, f"import signal; os.kill(os.getpid(), signal.{name})")
    with pytest.raises(flipflow.RunFailed) as ended:
        flipflow.load(EMPTY, "draft").run(tmp_path / "run")
    assert type(ended.value).__name__ == kind
    assert kind == "RunInterrupted" or name in str(ended.value)


@pytest.mark.process
@pytest.mark.solver
def test_a_killed_run_says_what_goes_on_with_it(run: flipflow.Run, tmp_path: Path) -> None:
    """A killed run has no summary, so that there is no run to open and to resume from Python."""
    killed = Path(shutil.copytree(run.folder, tmp_path / "killed"))
    (killed / "summary.json").unlink()
    goes_on = rf"{killed}\b.*\b0\.24\b"
    with pytest.raises(flipflow.FolderUnusable, match=goes_on):
        flipflow.open_run(killed)
    with pytest.raises(flipflow.RunInterrupted, match=goes_on):
        flipflow.run._ended(-signal.SIGKILL, killed, ())


def test_a_message_of_many_lines_keeps_its_first(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The last five lines of mpirun on too many ranks do not say what is wrong."""
    words = "not enough slots\n" + "what to do\n" * 12
    say(monkeypatch, f"sys.stderr.write({words!r}); sys.exit(1)")
    with pytest.raises(flipflow.RunFailed, match="slots"):
        flipflow.load(EMPTY, "draft").run(tmp_path / "run")


def test_any_bytes_on_standard_error_are_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    say(monkeypatch, r"os.write(2, b'\xff is no UTF-8\n'); sys.exit(4)")
    with pytest.raises(flipflow.RunFailed, match="UTF-8"):
        flipflow.load(EMPTY, "draft").run(tmp_path / "run")


def test_a_folder_without_a_run_is_refused(tmp_path: Path) -> None:
    with pytest.raises(flipflow.FolderUnusable, match=str(tmp_path)):
        flipflow.open_run(tmp_path)


def test_a_report_of_progress_is_read_as_it_is_written() -> None:
    report = ProgressReport(0.125, 0.5, 12.0, 36.0)
    assert report.share == 0.25
    assert parse_report(report.line) == report
    assert parse_report("opening the solvers") is None
