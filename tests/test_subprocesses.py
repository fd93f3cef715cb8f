"""Processes that run parts of this program end with it, even where it is killed."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PROGRAM = """
from orchestrator.output.subprocesses import python
python("-c", "import os, time; print(os.getpid(), flush=True); time.sleep(60)")
"""
WORKER = """
import os, time
from orchestrator.views.worker import worker
with worker() as pool:
    print(pool.submit(os.getpid).result(), flush=True)
    pool.submit(time.sleep, 60).result()
"""


@pytest.mark.parametrize("code", [PROGRAM, WORKER], ids=["program", "worker"])
def test_nothing_outlives_a_killed_process(code: str) -> None:
    with subprocess.Popen(
        [sys.executable, "-c", code], cwd=ROOT, stdout=subprocess.PIPE, encoding="utf-8"
    ) as parent:
        assert parent.stdout is not None
        child = Path(f"/proc/{int(parent.stdout.readline())}")
        assert child.exists()
        os.kill(parent.pid, signal.SIGKILL)
        parent.wait()
    end_s = time.monotonic() + 5.0
    while child.exists() and time.monotonic() < end_s:
        time.sleep(0.02)
    assert not child.exists()


def test_the_workers_of_every_pool_end_with_their_process() -> None:
    pools = [
        ast.unparse(node)
        for room in ("orchestrator", "adapters", "flipflow")
        for file in (ROOT / room).rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text()))
        if isinstance(node, ast.Call) and ast.unparse(node.func) == "ProcessPoolExecutor"
    ]
    assert pools
    assert all("end_with_parent" in call for call in pools), pools
