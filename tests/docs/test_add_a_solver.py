"""The page "Add a solver": its toy panel passes the contract and comes into a case by its name."""

from __future__ import annotations

import importlib
import inspect
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from orchestrator.case import solvers
from tests.docs.pages import code_on
from tests.panel import contract, test_contract

ROOT = Path(__file__).parents[2]
MOST_LINES = 60  # of code, as the page promises: without blank lines
CONTRACT = [
    (name, test)
    for name, test in vars(test_contract).items()
    if name.startswith("test_") and [*inspect.signature(test).parameters] == ["case"]
]


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with the toy as an installed package has it."""
    folder = tmp_path_factory.mktemp("site")
    (folder / "springs.py").write_text(code_on("how-to/add-a-solver.md")[0])
    (folder / "springs-1.0.dist-info").mkdir()
    (folder / "springs-1.0.dist-info/METADATA").write_text("Name: springs\nVersion: 1.0\n")
    entry = "[flipflow.panel]\nsprings = springs:ADAPTER\n"
    (folder / "springs-1.0.dist-info/entry_points.txt").write_text(entry)
    sys.path.insert(0, str(folder))
    forget()
    yield folder
    sys.path.remove(str(folder))
    sys.modules.pop("springs", None)
    forget()


def forget() -> None:
    importlib.invalidate_caches()
    solvers.names.cache_clear()
    solvers.adapter.cache_clear()


def flipflow(package: Path, *words: str) -> str:
    done = subprocess.run(
        [Path(sys.executable).with_name("flipflow"), *words],
        env={**os.environ, "PYTHONPATH": str(package)},
        cwd=ROOT,
        capture_output=True,
        encoding="utf-8",
        check=False,
        timeout=300,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.parametrize("test", [test for _, test in CONTRACT], ids=[name for name, _ in CONTRACT])
def test_it_passes_the_contract_of_panels(package: Path, test: object) -> None:
    assert callable(test)
    test(contract.Case("springs", contract.small("explicit"), 1e-9))


def test_the_contract_is_asked_whole() -> None:
    assert len(CONTRACT) >= 12


def test_an_installed_package_brings_it(package: Path) -> None:
    assert "springs" in solvers.names("panel")
    assert solvers.adapter("panel", "springs").about == "a mass on springs between its clamps"


@pytest.mark.process
def test_check_explain_and_run_know_it(package: Path, tmp_path: Path) -> None:
    case = ["cases/empty-machine", "--set", "panel.solver=springs", "--set", "duration_s=0.05"]
    checked = flipflow(package, "check", *case)
    assert "(springs)" in checked
    left_out = r"panel\.solver springs: .*across"
    assert re.search(left_out, checked)
    assert re.search(r"variation-across +no ", flipflow(package, "explain", *case))
    flipflow(package, "run", *case, "--out", str(tmp_path / "run"))
    flipflow(package, "report", str(tmp_path / "run"))
    assert re.search(left_out, (tmp_path / "run/report.html").read_text())


@pytest.mark.process
def test_a_study_of_accuracy_compares_it_with_the_other_models(package: Path, tmp_path: Path) -> None:
    """The case's key is all that changes: the model stands among the models of the panel, below the strip
    that the case has."""
    case = ["cases/empty-machine", "--set", "panel.solver=strip", "--set", "panel.cells=[8, 1]"]
    words = ["study", "accuracy", *case, "--parameters", "panel-mesh,panel-model=springs", "--quick"]
    flipflow(package, *words, "--duration", "0.05", "--out", str(tmp_path / "study"))
    stored = json.loads((tmp_path / "study/accuracy.json").read_text())
    (springs,) = (model for model in stored["models"] if model["variant"] == "springs")
    assert springs["reference"].startswith("strip, ")
    assert springs["error"]["deflection_m"] > 0
    assert "panel: springs" in (tmp_path / "study/accuracy.html").read_text()


def test_it_is_short() -> None:
    lines = [line for line in code_on("how-to/add-a-solver.md")[0].splitlines() if line.strip()]
    assert len(lines) <= MOST_LINES
