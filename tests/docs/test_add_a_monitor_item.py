"""The example of docs/how-to/add-a-monitor-item.md, from outside: a package beside flipflow."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from tests.docs.pages import installed
from tests.runs.outside import ROOT, command, run_words, summary

LIMIT = ["monitor.items.fast_particles.then=warn", "monitor.items.fast_particles.limit=0.01"]


def done_by(words: list[str], before: str = "") -> subprocess.CompletedProcess[str]:
    run = command(*words, before=before)
    return subprocess.run(run, cwd=ROOT, capture_output=True, encoding="utf-8", timeout=240, check=False)


@pytest.mark.process
def test_the_item_is_found_and_warns_also_in_a_run_that_goes_on(tmp_path: Path) -> None:
    """The run began without the item."""
    run = tmp_path / "run"
    done = done_by(run_words("ball-on-panel", run, ["output.pictures=false", "duration_s=0.02"]))
    assert done.returncode == 0, done.stderr
    longer = [word for key in ("duration_s=0.03", *LIMIT) for word in ("--set", key)]
    done = done_by(
        ["resume", str(run), *longer], installed(tmp_path, "how-to/add-a-monitor-item.md", "fast_particles")
    )
    assert done.returncode == 0, done.stderr
    warned = r"particle \d+ moves at .* m/s \(monitor.items.fast_particles.limit = 0.01\)"
    assert re.search(warned, done.stderr)
    figure = summary(run)["monitor"]["figures"]["fast_particles"]
    assert figure["worst"] > figure["limit"] == 0.01
    assert figure["times"] > 0


@pytest.mark.process
def test_an_item_that_nobody_brings_is_refused(tmp_path: Path) -> None:
    sets = [word for key in LIMIT for word in ("--set", key)]
    for words in (["check"], ["run", "--out", str(tmp_path / "run")]):
        done = done_by([words[0], "cases/ball-on-panel", "--level", "draft", *words[1:], *sets])
        assert done.returncode == 2, done.stderr
        assert 'monitor.items.fast_particles: there is no item "fast_particles"' in done.stderr
    assert not (tmp_path / "run").exists()
