"""The words and files that a run which failed must leave."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import meshio

from tests.runs.outside import left_usable, said_plainly


def failed(folder: Path, done: subprocess.CompletedProcess[str], *wanted: str) -> None:
    assert done.returncode == 4, done.stderr
    said_plainly(done)
    lines = done.stderr.strip().splitlines()
    last = max(number for number, line in enumerate(lines) if line.startswith("logs: "))
    reason, logs = lines[last - 1 : last + 1]
    for text in wanted:
        assert text in reason, reason
    assert str(folder / "run.log") in logs
    assert reason in (folder / "run.log").read_text()
    assert left_usable(folder, "failed")["reason"] == reason
    pictures_open(folder)


def pictures_open(folder: Path) -> None:
    """Each ParaView series opens as far as it goes."""
    for series in folder.glob("*.pvd"):
        files = re.findall(r'file="([^"]*)"', series.read_text())
        assert files
        assert len(meshio.read(folder / files[-1]).points)
