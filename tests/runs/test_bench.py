"""The benchmark: what it counts, and the table that it prints."""

from __future__ import annotations

import itertools
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.solver_plans import particle_step_s, particles_plan
from orchestrator.ports import Array
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import Jkr, ParticlesPlan
from orchestrator.preflight.judge import load_judged
from tests.runs.outside import ROOT
from tools.bench.coupling import BLOCK, PARTS, Runner, bench
from tools.bench.stock import SPAWN, Wiggle, stock_engine, stock_input

CASE = ROOT / "cases/ball-on-panel"


@pytest.mark.solver
def test_what_was_before_the_clock_started_does_not_count(tmp_path: Path) -> None:
    loaded = load_judged(CASE, "draft")
    runner = Runner(loaded, tmp_path / "run")
    runner.block()
    runner.forget()
    assert (runner.wall_s, runner.particle_steps, runner.stopwatch.wall_s) == (0.0, 0, {})
    blocks = 0
    while not sum(runner.stopwatch.wall_s.values()):  # a virtual computer's clock may tick every 50 ms
        runner.block()
        blocks += 1
    runner.close()
    interval = Interval(0, loaded.case.coupling.sync_interval_s)
    assert runner.particle_steps == blocks * BLOCK * interval.steps(particle_step_s(loaded.case))
    assert 0.0 < sum(runner.stopwatch.wall_s.values()) <= runner.wall_s


@pytest.mark.solver
def test_the_parts_are_shares_of_the_coupled_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock ticks whenever it is read, so that each part that is measured at all has time."""
    monkeypatch.setattr(time, "perf_counter", itertools.count().__next__)
    table = bench(load_judged(CASE, "draft"), BLOCK, settling=BLOCK)
    columns = {str(column.header): list(column.cells) for column in table.columns}
    shares = columns["share"]
    assert shares[:2] == ["", ""]
    percent = [int(share.removesuffix(" %")) for share in shares[2:]]
    assert percent[-1] == 100
    assert sum(percent[:-1]) == pytest.approx(100, abs=3)
    assert min(percent) > 0


@pytest.mark.solver
def test_times_shorter_than_a_tick_of_the_clock_have_no_shares(monkeypatch: pytest.MonkeyPatch) -> None:
    """A virtual computer's clock may tick every 50 ms."""
    monkeypatch.setattr(time, "perf_counter", lambda: 1.0)
    table = bench(load_judged(CASE, "draft"), BLOCK, settling=BLOCK)
    columns = {str(column.header): list(column.cells) for column in table.columns}
    assert columns["share"][2:-1] == [""] * len(PARTS)
    assert set(columns["against moving"][:-1]) == {""}


def fallen(plan: ParticlesPlan, folder: Path, as_packaged: bool) -> tuple[Array, int]:
    """The places of particles that fell onto LIGGGHTS's own walls, and how many touch something."""
    folder.mkdir()
    engine = stock_engine(plan, None, folder, as_packaged)
    engine.command("run 3200 pre no post no")
    now = engine.particles()
    weight_N = now["rmass"][:, None] * plan.gravity_m_per_s2
    pushed = np.abs(now["f"] - weight_N).max(axis=1) > 1e-2 * np.abs(weight_N).max(axis=1)
    return np.array(now["x"][np.argsort(now["tag"])]), int(pushed.sum())


@pytest.mark.solver
@pytest.mark.parametrize("sticky", [False, True])
def test_packaged_laws_move_a_bed_as_ours_do(tmp_path: Path, sticky: bool) -> None:
    """The bed has neither rolling friction nor dampers, whose packaged laws are not ours (dampers half a step
    late); without ours the process has no `jkr`."""
    overrides = ["particles.rolling=none", "bed.blocks.coal.count=300"]
    overrides += [f"contacts.{k}.restitution=1.0" for k in range(3)]
    if sticky:
        overrides += [f"contacts.{k}.work_of_adhesion_J_per_m2=0.05" for k in range(3)]
    loaded = load_judged(ROOT / "cases/quickstart", "draft", overrides)
    runner = Runner(loaded, tmp_path / "coupled")
    plan = particles_plan(loaded.case, runner.surface())
    runner.close()
    assert plan is not None
    assert isinstance(plan.adhesion, Jkr) is sticky
    ours_m, touching = fallen(plan, tmp_path / "ours", False)
    with ProcessPoolExecutor(1, SPAWN) as other:
        packaged_m, _ = other.submit(fallen, plan, tmp_path / "packaged", True).result()
    assert touching > 10  # without dampers nobody stays
    np.testing.assert_allclose(packaged_m, ours_m, rtol=0.0, atol=1e-12)


@pytest.mark.solver
def test_stock_walls_are_made_of_the_triangles_of_each_material_and_move_as_one(tmp_path: Path) -> None:
    loaded = load_judged(CASE, "draft")
    runner = Runner(loaded, tmp_path / "coupled")
    plan = particles_plan(loaded.case, runner.surface())
    runner.close()
    assert plan is not None
    lines = list(stock_input(plan, Wiggle(np.array([0.0, 0.0, 0.003]), 0.08), tmp_path))
    stl = (tmp_path / "mesh0.stl").read_text().splitlines()
    corners_m = [line.split()[1:] for line in stl if line.startswith("vertex")]
    expected_m = plan.surface.position_m[plan.surface.triangles].reshape(-1, 3)
    assert np.array_equal(np.array(corners_m, dtype=float), expected_m)
    text = "\n".join(lines)
    assert "/flipflow " not in text
    assert "wall/gran model hertz" in text
    assert "mesh n_meshes 1 meshes mesh0" in text
    assert "fix move_mesh0 all move/mesh mesh mesh0 wiggle amplitude 0.0 0.0 0.003 period 0.08" in text


def test_the_wiggle_has_the_root_mean_square_of_the_velocities() -> None:
    phase = np.linspace(0.0, 2 * np.pi, 100, endpoint=False)
    velocities = [np.array([[0.0, 0.2 * np.cos(angle), 0.0]]) for angle in phase]
    wiggle = Wiggle.like(velocities, period_s=0.5)
    assert wiggle.amplitude_m == pytest.approx([0.0, 0.2 * 0.5 / (2 * np.pi), 0.0])
