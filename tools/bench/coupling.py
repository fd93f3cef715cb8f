"""The cost of the coupling: a case's run against LIGGGHTS alone with the same bed on rigid triangles.

After an untimed beginning, the bed and the surface of the coupled run are given to LIGGGHTS alone twice: on
walls that stand still, and on walls that move as one (``tools/bench/stock.py``).  The three then advance in
turn, block by block, so that a computer whose speed drifts slows all of them.  A still bed comes to rest and
has more contacts; a thrown bed does not and has more new neighbours.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from rich.table import Table

from orchestrator.case.solver_plans import particle_step_s
from orchestrator.coupling.build import build
from orchestrator.coupling.metered import Stopwatch
from orchestrator.coupling.schemes.scheme import initial_state
from orchestrator.output.cycles import cycle_s
from orchestrator.ports import Array, ParticleSnapshot
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.preflight.judge import JudgedCase
from tools.bench.stock import StockRunner, Wiggle

BLOCK = 100
PARTS = ("particles", "panel", "frames", "mapping", "rest")
QUARTILES = (25, 50, 75)


class Runner:
    """A case that advances block by block, with its stopwatch."""

    def __init__(self, loaded: JudgedCase, folder: Path) -> None:
        folder.mkdir()
        self.stopwatch = Stopwatch()
        self._machine = build(loaded, folder, None, self.stopwatch)
        self._state = initial_state(self._machine.solvers)
        self._interval_s = loaded.case.coupling.sync_interval_s
        self._done = 0
        self.wall_s = 0.0
        self.blocks_s: list[float] = []  # CPU time of each block
        self._steps = Interval(0, self._interval_s).steps(particle_step_s(loaded.case))
        self.particle_steps = 0

    def block(self, intervals: int = BLOCK) -> None:
        """Advance by a block of sync intervals, and add its times."""
        started, cpu_s = time.perf_counter(), time.process_time()
        runs = self._machine.particle_runs
        for index in range(self._done, self._done + intervals):
            interval = Interval(index, self._interval_s)
            self._state = self._machine.scheme.advance(self._machine.solvers, interval, self._state)
        self._done += intervals
        self.blocks_s.append(time.process_time() - cpu_s)
        self.wall_s += time.perf_counter() - started
        runs = self._machine.particle_runs - runs
        self.particle_steps += runs * self._steps * self.particles()

    def forget(self) -> None:
        """Discard the times so far."""
        self.stopwatch.wall_s.clear()
        self.stopwatch.repeated_s.clear()
        self.blocks_s.clear()
        self.wall_s, self.particle_steps = 0.0, 0

    def particles(self) -> int:
        """Return the present number of particles."""
        return len(self.bed().id) if self._machine.solvers.particles else 0

    def bed(self) -> ParticleSnapshot:
        """Return the particles as they are now."""
        particles = self._machine.solvers.particles
        assert particles is not None, "asked of a case without particles"
        return particles.snapshot()

    def surface(self) -> TriangleSurface:
        """Return the surface as it is now."""
        return replace(self._machine.surface, position_m=self._state.panel.surface.position_m)

    def surface_velocity_m_per_s(self) -> Array:
        """Return the velocity (points, 3) of the points that particles touch, now."""
        surface = self._machine.surface
        return surface.rigid.at(self._state.panel.surface.velocity_m_per_s, np.unique(surface.triangles))

    def close(self) -> None:
        """Close the machine."""
        self._machine.close()


def bench(loaded: JudgedCase, intervals: int, settling: int = BLOCK) -> Table:
    """Run a case and LIGGGHTS alone with its bed, and return the table of their times.

    All run about ``intervals`` sync intervals; before them the case runs ``settling`` intervals that do not
    count, one block at least.  The moving walls have the root mean square of the surface's velocity in the
    last cycle of these.
    """
    case = loaded.case
    with tempfile.TemporaryDirectory(prefix="flipflow-bench-") as scratch:
        coupled = Runner(loaded, Path(scratch) / "coupled")
        velocities_m_per_s = []
        for _ in range(max(1, settling // BLOCK)):
            coupled.block()
            velocities_m_per_s.append(coupled.surface_velocity_m_per_s())
        period_s = cycle_s(case)
        cycle = max(1, round(period_s / (BLOCK * case.coupling.sync_interval_s)))
        wiggle = Wiggle.like(velocities_m_per_s[-cycle:], period_s)
        surface, bed = coupled.surface(), coupled.bed()
        still = StockRunner(case, surface, bed, None, Path(scratch) / "still")
        moving = StockRunner(case, surface, bed, wiggle, Path(scratch) / "moving")
        coupled.forget()
        for _ in range(max(1, intervals // BLOCK)):
            for runner in (coupled, still, moving):
                runner.block(BLOCK)
        table = compare(loaded.name, coupled, still, moving)
        for runner in (coupled, still, moving):
            runner.close()
    return table


def compare(name: str, coupled: Runner, still: StockRunner, moving: StockRunner) -> Table:
    """Return the table of times, and of their ratios to LIGGGHTS alone on still and on moving walls.

    The coupled run's ratios are those of the blocks' CPU times, as median and quartiles; those of its parts
    are ratios of sums of wall time, empty where the whole is shorter than a tick of the computer's clock.
    """
    intervals = BLOCK * len(coupled.blocks_s)
    table = Table(
        title=f"{name}: {coupled.particles()} particles, {intervals} intervals", title_justify="left"
    )
    heads = (
        "",
        "wall / s",
        "µs an interval",
        "share",
        "against still",
        "against moving",
        "particle-steps / s",
    )
    for head in heads:
        table.add_column(head, justify="right" if head else "left", no_wrap=True)

    def row(what: str, wall_s: float, share: str, ratios: Sequence[str], particle_steps: int = 0) -> None:
        speed = f"{particle_steps / wall_s:.3g}" if particle_steps and wall_s else ""
        table.add_row(what, f"{wall_s:.2f}", f"{1e6 * wall_s / intervals:.0f}", share, *ratios, speed)

    row("LIGGGHTS alone, rigid still walls", still.wall_s, "", ("", ""), still.particle_steps)
    row("LIGGGHTS alone, rigid moving walls", moving.wall_s, "", ("", ""), moving.particle_steps)
    parts_s = coupled.stopwatch.wall_s
    parts_s["rest"] = coupled.wall_s - sum(parts_s.values())
    for part in PARTS:
        wall_s = parts_s.get(part, 0.0)
        share, *ratios = (
            format(wall_s / whole.wall_s, form) if whole.wall_s else ""
            for whole, form in ((coupled, ".0%"), (still, ".2f"), (moving, ".2f"))
        )
        steps = coupled.particle_steps if part == "particles" else 0
        row(f"coupled run: {part}", wall_s, share.replace("%", " %"), ratios, steps)
    ratios = [median_ratio(coupled.blocks_s, alone.blocks_s) for alone in (still, moving)]
    row("coupled run, without output", coupled.wall_s, "100 %", ratios, coupled.particle_steps)
    return table


def median_ratio(some_s: Sequence[float], others_s: Sequence[float]) -> str:
    """Return the median and the quartiles of the blocks' ratios of CPU time, in words.

    Blocks in which the other took less than a tick of the computer's clock are left out; without any other
    block there is nothing to say.
    """
    ratios = [some / other for some, other in zip(some_s, others_s, strict=True) if other]
    if not ratios:
        return ""
    low, middle, high = np.percentile(ratios, QUARTILES)
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"
