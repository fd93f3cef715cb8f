"""A case that means harm: nothing of it is run, and nothing of it is obeyed by what shows it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tomllib
from html import unescape
from pathlib import Path

import pytest
import tomli_w

from orchestrator.output.report.page import Film, page
from orchestrator.output.results.compute import compute_results
from tests.cases import CASE, case_folder
from tests.results.synthetic import folder_of
from tests.runs.outside import HANG_S, left_usable

EVIL_NAME = "x$(touch owned)`touch owned`;\"'${y}\nshell touch owned"
# what libraries look for in the folder that a program is started in
PYTHON = "open('owned', 'a').close(); raise SystemExit(9)"
MODULES = ("orchestrator", "adapters", "numpy", "h5py", "matplotlib", "pyvista", "vtk", "sitecustomize")
FILES = {
    ".petscrc": "-log_view :owned",
    "petscrc": "-log_view :owned",
    "ffcx_parameters.json": '{"scalar_type": "float", "tabulate_tensor_void": true}',
    "dolfinx_jit_parameters.json": '{"cffi_extra_compile_args": ["-Downed", "-x", "none"]}',
    "ffcx_options.json": '{"scalar_type": "float32", "sum_factorization": true}',
    "dolfinx_jit_options.json": '{"cffi_extra_compile_args": ["-Downed", "-x", "none"]}',
    "matplotlibrc": "backend: module://owned",
    "in.liggghts": "shell touch owned",
    "gmshrc": "Syntax error;",
}
SOLVERS = """
[coupling]
scheme = "particles-first"
sync_interval_s = 2e-4
[frames]
solver = "two-mass"
[panel]
solver = "sheet"
cells = [6, 2]
surface_cells = [6, 2]
[particles]
solver = "liggghts"
[output]
interval_s = 1e-3
"""


def flipflow(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run flipflow as installed: what is in the folder that it is started in is not on Python's path."""
    return subprocess.run(
        [sys.executable, "-P", "-c", "from orchestrator.cli.main import main; main()", *words],
        cwd=cwd,
        env=os.environ | {"OMP_NUM_THREADS": "1"},
        capture_output=True,
        encoding="utf-8",
        timeout=HANG_S,
        check=False,
    )


def evil_case(folder: Path) -> Path:
    """A good case in a bad folder: its names are LIGGGHTS's commands, and files lie in wait."""
    text = CASE.replace("duration_s = 0.1", "duration_s = 0.004").replace("coal", "shell")
    text = text.replace("[screen.panels.deck]", "[screen.panels.jump]").replace('"deck"', '"jump"')
    case = case_folder(folder / EVIL_NAME.replace("/", "-"), text + SOLVERS)
    for module in MODULES:
        (case / f"{module}.py").write_text(PYTHON)
    for name, content in FILES.items():
        (case / name).write_text(content)
    return case


@pytest.mark.solver
def test_nothing_that_lies_in_a_case_is_run(tmp_path: Path) -> None:
    """Run from inside the case's own folder, with all real solvers and pictures."""
    case = evil_case(tmp_path)
    before = set(case.iterdir())
    done = flipflow("run", ".", cwd=case)
    assert done.returncode == 0, done.stderr
    (run,) = (case / "runs").iterdir()
    left_usable(run, "done")
    assert (run / "deck.png").stat().st_size > 1000
    assert set(case.iterdir()) - before == {case / "runs"}
    assert not list(tmp_path.rglob("owned"))
    words = (run / "in.liggghts").read_text()
    assert not re.search(r"^\s*(shell|jump|include|variable|python)\b", words, flags=re.M)
    assert "shell" not in words
    assert "jump" not in words


def test_words_of_a_case_are_only_words_in_a_report(tmp_path: Path) -> None:
    run = folder_of(tmp_path / "run", True)
    evil = "<script>alert(1)</script><img src=x onerror=alert(2)> {{ 7 * 7 }} '&amp;"
    table = tomllib.loads((run / "case.toml").read_text()) | {"title": evil, "description": evil}
    (run / "case.toml").write_text(tomli_w.dumps(table))
    with (run / "run.log").open("a") as log:
        log.write(f"2026-01-01 00:00:00,000 WARNING {evil}\n")
    shown = page(run, compute_results(run), lambda *_: Film(b"", reason=evil))
    assert "<script" not in shown
    assert "<img src=x" not in shown
    assert unescape(shown).count(evil) >= 3


def test_markup_of_the_console_is_text(tmp_path: Path) -> None:
    """``[/red]`` would be a mistake, ``[red]`` a colour."""
    folder = case_folder(tmp_path / "[red]x", CASE.replace("a test", "[/red] [link=x]y[/link]"))
    (folder / "levels/[bold].toml").write_text("[panel]\nsolver = 'rigid'\nsurface_cells = [2, 2]")
    level = folder / "levels/[bold].toml"
    level.write_text('without = ["panel-deformation"]\n' + level.read_text())
    for words in (["check"], ["explain"]):
        sets = ["--set", "particles.solver=spheres", "--set", "frames.solver=prescribed"]
        sets += ["--set", "screen.bushings={}", "--set", "screen.exciters={}"]
        done = flipflow(*words, str(folder), *sets, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "[red]x" in done.stdout
    done = flipflow("list", str(tmp_path), cwd=tmp_path)
    assert "[/red] [link=x]y[/link]" in done.stdout
    assert "levels: [bold]" in done.stdout
