"""Imports, types, and style: the rules of pyproject.toml hold."""

from __future__ import annotations

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

from orchestrator import workbench

BIN = Path(sys.executable).parent
ROOT = Path(__file__).parents[1]
MOST_WITH_DIAMETERS = 15
MOST_NAMES_OF_STUDIES = 15


@pytest.mark.parametrize(
    "command",
    [["lint-imports", "--no-cache"], ["ruff", "check", "."], ["ruff", "format", "--check", "."], ["mypy"]],
    ids=["imports", "ruff", "format", "mypy"],
)
def test_rules_hold(command: list[str]) -> None:
    done = subprocess.run([BIN / command[0], *command[1:]], capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stdout + done.stderr


def test_few_files_of_the_orchestrator_know_diameters() -> None:
    """The others ask a grain for its size, its mass and its radii (``ports/grains.py``)."""
    files = [file for file in ROOT.glob("orchestrator/**/*.py") if "diameter_m" in file.read_text()]
    assert len(files) <= MOST_WITH_DIAMETERS, files


def test_no_file_of_the_orchestrator_stands_in_an_import_circle() -> None:
    """Imports for types alone are counted, too, and imports within functions."""
    files = {
        ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): file
        for file in ROOT.glob("orchestrator/**/*.py")
    }
    imports: dict[str, set[str]] = {}
    for module, file in files.items():
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.ImportFrom) and node.module:
                inner = [f"{node.module}.{alias.name}" for alias in node.names]
                wanted = {name if name in files else node.module for name in inner}
                imports.setdefault(module, set()).update(wanted & files.keys())
    assert list(TopologicalSorter(imports).static_order())  # raises CycleError, which names the circle


def test_studies_know_few_names_of_the_rest() -> None:
    """Each is a class or function with a docstring, or the module of general words."""
    assert len(workbench.__all__) <= MOST_NAMES_OF_STUDIES
    assert all(getattr(workbench, name).__doc__ for name in workbench.__all__)


def test_names_in_tests_say_what_they_hold() -> None:
    """A variable is a problem, a message or a pressure; found, said, told and one could be anything."""
    vague = {"found", "said", "told", "one"}
    for file in ROOT.glob("tests/**/*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.arg):
                assert node.arg not in vague, f"{file}:{node.lineno}"
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                assert node.id not in vague, f"{file}:{node.lineno}"
