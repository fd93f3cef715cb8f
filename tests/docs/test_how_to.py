"""The Python of the how-to pages runs: all blocks of a page, in order, as one program."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"^```python\n(.*?)^```", re.M | re.S)
PAGES = {page.stem: page for page in sorted((ROOT / "docs/how-to").glob("*.md"))}
WITH_CODE = [name for name, page in PAGES.items() if BLOCK.search(page.read_text(encoding="utf-8"))]


@pytest.mark.process
@pytest.mark.parametrize("name", WITH_CODE)
def test_the_example_runs(name: str, tmp_path: Path) -> None:
    """The example runs in a process of its own, so that what it adds to the program is gone afterwards."""
    program = tmp_path / "example.py"
    program.write_text("\n".join(BLOCK.findall(PAGES[name].read_text(encoding="utf-8"))), encoding="utf-8")
    done = subprocess.run([sys.executable, program], capture_output=True, encoding="utf-8", cwd=ROOT)
    assert done.returncode == 0, done.stderr


def test_there_are_examples() -> None:
    assert {"add-a-key", "add-a-result", "add-a-study"} <= set(WITH_CODE)
