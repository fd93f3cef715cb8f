"""The example of docs/how-to/add-a-monitor-item.md, from outside: a package beside flipflow."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

from tests.runs.outside import ROOT, command, run_words, summary

PAGE = (ROOT / "docs/how-to/add-a-monitor-item.md").read_text(encoding="utf-8")
LIMIT = ["monitor.items.fast_particles.then=warn", "monitor.items.fast_particles.limit=0.01"]


def installed(folder: Path) -> str:
    """Installs the page's item into a folder; returns what lets a process find it."""
    code = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    entry = re.search(r'entry-points\."(.*?)"\]\n(.*?)\n```', PAGE)
    assert len(code) == 1
    assert entry is not None
    (folder / "fast_particles.py").write_text(code[0])
    about = folder / "fast_particles-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text("Metadata-Version: 2.1\nName: fast-particles\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[{entry[1]}]\n{entry[2].replace(chr(34), '')}\n")
    return f"import sys; sys.path.insert(0, {str(folder)!r})"


def done_by(words: list[str], before: str = "") -> subprocess.CompletedProcess[str]:
    run = command(*words, before=before)
    return subprocess.run(run, cwd=ROOT, capture_output=True, text=True, timeout=240, check=False)


@pytest.mark.process
def test_the_item_is_found_and_warns_also_in_a_run_that_goes_on(tmp_path: Path) -> None:
    """The run began without the item."""
    run = tmp_path / "run"
    done = done_by(run_words("ball-on-panel", run, ["output.pictures=false", "duration_s=0.02"]))
    assert done.returncode == 0, done.stderr
    longer = [word for key in ("duration_s=0.03", *LIMIT) for word in ("--set", key)]
    done = done_by(["resume", str(run), *longer], installed(tmp_path))
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
