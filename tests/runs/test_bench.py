"""The benchmark: what it counts, and the table that it prints."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.case.solver_plans import particle_step_s
from orchestrator.ports.clock import Interval
from orchestrator.preflight.judge import load_judged
from tests.runs.outside import ROOT
from tools.bench.coupling import BLOCK, Runner, bench

CASE = ROOT / "cases/ball-on-panel"


@pytest.mark.solver
def test_what_was_before_the_clock_started_does_not_count(tmp_path: Path) -> None:
    loaded = load_judged(CASE, "draft")
    runner = Runner(loaded, tmp_path / "run")
    runner.block()
    runner.forget()
    assert (runner.wall_s, runner.particle_steps, runner.stopwatch.wall_s) == (0.0, 0, {})
    runner.block()
    runner.close()
    interval = Interval(0, loaded.case.coupling.sync_interval_s)
    assert runner.particle_steps == BLOCK * interval.steps(particle_step_s(loaded.case))
    assert 0.0 < sum(runner.stopwatch.wall_s.values()) < runner.wall_s


@pytest.mark.solver
def test_the_parts_are_shares_of_the_coupled_run() -> None:
    table = bench(load_judged(CASE, "draft"), BLOCK, settling=BLOCK)
    names, _, shares = (list(column.cells) for column in table.columns[:3])
    assert shares[0] == ""
    percent = [int(share.removesuffix(" %")) for share in shares[1:]]
    assert percent[names.index("coupled run, without output") - 1] == 100
    assert 50 < sum(percent[:-1]) <= 102
