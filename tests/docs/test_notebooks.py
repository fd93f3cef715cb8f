"""The notebooks run from their first cell to their last, and keep the outputs of a run."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

EXECUTE = """
import sys
from pathlib import Path
import nbclient, nbformat

notebook = Path(sys.argv[1])
place = {"metadata": {"path": notebook.parent}}
nbclient.NotebookClient(nbformat.read(notebook, 4), resources=place).execute()
"""
NOTEBOOKS = sorted((Path(__file__).parents[2] / "docs/notebooks").glob("*.ipynb"))


@pytest.mark.process
@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[file.stem for file in NOTEBOOKS])
def test_a_notebook_runs(notebook: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-c", EXECUTE, str(notebook)], capture_output=True, encoding="utf-8"
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=[file.stem for file in NOTEBOOKS])
def test_a_notebook_is_stored_with_its_outputs(notebook: Path) -> None:
    cells = [cell for cell in json.loads(notebook.read_text())["cells"] if cell["cell_type"] == "code"]
    assert all(cell["execution_count"] for cell in cells)
    kinds = {kind for cell in cells for output in cell["outputs"] for kind in output.get("data", {})}
    assert {"text/html", "image/png"} <= kinds
    assert "/tmp/" not in notebook.read_text(), "a path of the machine that executed it"


def test_there_is_a_notebook() -> None:
    assert NOTEBOOKS
