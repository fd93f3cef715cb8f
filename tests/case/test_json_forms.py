"""``--json`` of check, explain and list: JSON alone on standard output, with what the words say."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, get_args

import pytest
from typer.testing import CliRunner

from orchestrator.case.file.errors import Kind
from orchestrator.cli.main import app
from tests.case.test_cost import FEED as FED
from tests.cases import CASE, LEVEL, case_folder

CALL = CliRunner()
PAGE = (Path(__file__).parents[2] / "docs/json-output.md").read_text(encoding="utf-8")
SETS = ("--set", "panel.solver=rigid", "--set", "frames.solver=two-mass")


def documented(command: str) -> set[str]:
    """The keys that the page lists for a command."""
    section = PAGE.split(f"## `{command}", 1)[1].split("\n## ", 1)[0]
    names = re.findall(r"^\| (`[a-z_`, ]+`) \|", section, flags=re.M)
    return set(re.findall("[a-z_]+", " ".join(names)))


def printed(*words: str) -> dict[str, Any]:
    done = CALL.invoke(app, [*words, "--json"])
    assert done.exit_code == 0, done.output
    table: dict[str, Any] = json.loads(done.stdout)
    assert table.pop("format_version") == 1
    return table


@pytest.mark.smoke
def test_check(tmp_path: Path) -> None:
    table = printed("check", str(case_folder(tmp_path)), *SETS)
    assert set(table) == documented("flipflow check")
    assert table["solvers"] == {"frames": "two-mass", "panel": "rigid", "particles": "liggghts"}
    assert table["panels"] == ["deck"]
    assert table["particles_at_start"] == 1
    assert table["sync_intervals"] == round(table["duration_s"] / table["sync_interval_s"])
    assert "panel-deformation" in table["left_out"]


def test_all_warnings_of_the_words_are_there(tmp_path: Path) -> None:
    """The interval is too long to be stable, and to be accurate."""
    words = ["check", str(case_folder(tmp_path)), "--set", "coupling.sync_interval_s=2e-4"]
    words += ["--set", "panel.solver=strip", "--set", "frames.solver=two-mass"]
    words += ["--set", "coupling.scheme=particles-first"]
    table = printed(*words)
    assert table["stability"]["safe_interval_s"] < 2e-4
    begin = "warning: "
    lines = CALL.invoke(app, words).stdout.splitlines()
    assert table["warnings"] == [line.removeprefix(begin) for line in lines if line.startswith(begin)]
    assert len(table["warnings"]) > 2


def test_a_thick_bed_takes_longer_than_a_thin_one(tmp_path: Path) -> None:
    """A thick bed stays longer on the deck, so that more particles move."""
    words = ["check", str(case_folder(tmp_path, CASE + FED)), *SETS, "--set", "duration_s=4"]
    times_s = printed(*words)["predicted_processor_s"]
    assert 0.0 < times_s["thin_bed"] < times_s["thick_bed"]


def test_explain(tmp_path: Path) -> None:
    table = printed("explain", str(case_folder(tmp_path)), *SETS)
    assert set(table) == documented("flipflow explain")
    judged = table["effects"]["panel-deformation"]
    assert judged["part"] == "panels"
    assert not judged["present"]
    assert judged["verdict"]["matters"] in (True, False, None)


def test_list(tmp_path: Path) -> None:
    case_folder(tmp_path / "good", draft=LEVEL)
    (tmp_path / "bad").mkdir()
    (tmp_path / "bad" / "case.toml").write_text("title = ")
    table = printed("list", str(tmp_path))
    assert set(table) == documented("flipflow list")
    bad, good = table["cases"]
    assert bad["title"] is None
    assert good == {
        "folder": str(tmp_path / "good"),
        "title": "a test",
        "base": None,
        "levels": ["draft"],
        "default_level": "draft",
    }


def test_the_problems_of_a_wrong_case_are_told(tmp_path: Path) -> None:
    wrong = ["--set", "panel.solver=rigd", "--set", "duration_s=-1", "--set", "titel=x"]
    done = CALL.invoke(app, ["check", str(case_folder(tmp_path)), "--json", *wrong])
    assert done.exit_code == 2
    table = json.loads(done.stdout)
    assert set(table) == {"format_version", "problems"}
    places = {(each["file"], each["key"], each["kind"]) for each in table["problems"]}
    assert places == {
        ("--set", "panel.solver", "unknown-name"),
        ("--set", "duration_s", "out-of-range"),
        ("--set", "titel", "unknown-key"),
    }
    lines = done.stderr.splitlines()
    for each in table["problems"]:
        assert any(each["what"] in line and each["hint"] in line for line in lines)


def test_every_kind_of_problem_is_documented() -> None:
    rows = re.findall(r'^- "([a-z-]+)"', PAGE, flags=re.M)
    assert rows == [*get_args(Kind)]


@pytest.mark.parametrize("command", ["explain", "list"])
def test_standard_output_of_a_wrong_call_is_empty(tmp_path: Path, command: str) -> None:
    done = CALL.invoke(app, [command, str(tmp_path / "absent"), "--json"])
    assert (done.exit_code, done.stdout) == (2, "")
