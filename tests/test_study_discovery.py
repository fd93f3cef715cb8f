"""A study is found by its file, with the example of docs/how-to/add-a-study.md."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from orchestrator.cli import studies as commands
from orchestrator.cli.main import app
from tests.runs.outside import ROOT

PAGE = (ROOT / "docs/how-to/add-a-study.md").read_text(encoding="utf-8")


def test_a_file_beside_the_others_is_a_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0]
    (tmp_path / "random_seeds.py").write_text(example, encoding="utf-8")
    monkeypatch.setattr(commands, "__path__", [*commands.__path__, str(tmp_path)])
    listed = CliRunner().invoke(app, ["study", "--help"])
    assert "Run a case several times with other random numbers" in " ".join(listed.output.split())
    shown = CliRunner().invoke(app, ["study", "random-seeds", "--help"])
    assert shown.exit_code == 0, shown.output
    assert "--seeds" in shown.output


def test_an_installed_package_brings_a_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    example = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0]
    entry = re.search(r'entry-points\."(.*?)"\]\n(.*?) = "(.*?)\.(.*?)"\n```', PAGE)
    assert entry is not None
    group, name, package, module = entry.groups()
    about = tmp_path / "my_package-1.0.dist-info"
    for folder in (tmp_path / package, about):
        folder.mkdir()
    (tmp_path / package / f"{module}.py").write_text(example, encoding="utf-8")
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: my-package\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[{group}]\n{name} = {package}.{module}\n")
    monkeypatch.syspath_prepend(tmp_path)
    shown = CliRunner().invoke(app, ["study", name, "--help"])
    assert shown.exit_code == 0, shown.output
    assert "--seeds" in shown.output


def test_another_word_is_refused_with_the_nearest_study() -> None:
    refused = CliRunner().invoke(app, ["study", "sweeep"])
    assert refused.exit_code == 2
    assert "sweep" in refused.output
