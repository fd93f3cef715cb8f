"""The effect of docs/how-to/add-an-effect.md, from outside: a package beside flipflow brings it."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.docs.pages import installed
from tests.runs.outside import ROOT, command

CASE = ("cases/quickstart", "--level", "draft")
WEIGH = """
from pathlib import Path
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.weighing import weigh_effects
judged = weigh_effects(load_judged(Path("cases/quickstart"), "draft").described)["buoyancy"]
assert judged.part == "particles" and not judged.present and not judged.can_go
assert judged.verdict.number == "lift / weight" and judged.verdict.matters is False
"""


def done_by(words: list[str]) -> str:
    done = subprocess.run(words, cwd=ROOT, capture_output=True, encoding="utf-8", timeout=240, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr


@pytest.mark.process
def test_it_is_weighed_and_explained(tmp_path: Path) -> None:
    before = installed(tmp_path, "how-to/add-an-effect.md", "buoyancy")
    done_by([sys.executable, "-c", before + WEIGH])
    output = done_by(command("explain", *CASE, before=before))
    assert re.search(r"buoyancy +no +lift / weight +\S+ +0\.1 \(of the weight\).*may be left out", output)


@pytest.mark.process
def test_the_case_says_that_it_is_left_out(tmp_path: Path) -> None:
    before = installed(tmp_path, "how-to/add-an-effect.md", "buoyancy")
    table = json.loads(done_by(command("check", *CASE, "--json", before=before)))
    assert "buoyancy" in table["left_out"]


@pytest.mark.process
def test_one_that_no_run_can_check_is_refused(tmp_path: Path) -> None:
    """An author hears of a wrong name in ``checked_by`` before any case is judged."""
    before = installed(tmp_path, "how-to/add-an-effect.md", "buoyancy")
    module = tmp_path / "buoyancy.py"
    module.write_text(module.read_text().replace('about=("particles",)', 'checked_by="lift"'))
    done = subprocess.run(
        [sys.executable, "-c", before + WEIGH], cwd=ROOT, capture_output=True, encoding="utf-8", check=False
    )
    assert done.returncode != 0
    assert "buoyancy:" in done.stderr.splitlines()[-1]
