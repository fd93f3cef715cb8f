"""The cost of the coupling: a case's run against its particles alone on a rigid, still surface.

Both machines advance in turn, block by block, in one process, so that a computer whose speed drifts slows
both.  The still bed comes to rest and has more contacts; the thrown bed does not and has more new neighbours.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path

from rich.table import Table

from orchestrator.case.solver_plans import particle_step_s
from orchestrator.coupling.build import build
from orchestrator.coupling.metered import Stopwatch
from orchestrator.coupling.schemes.scheme import initial_state
from orchestrator.ports.clock import Interval
from orchestrator.preflight.judge import JudgedCase

BLOCK = 100
STILL_ROW = "particles alone, rigid still surface"
STILL = {"frame_motion": False, "panel_motion": False, "particle_load": False}


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
        self.blocks_s.clear()
        self.wall_s, self.particle_steps = 0.0, 0

    def particles(self) -> int:
        """Return the present number of particles."""
        particles = self._machine.solvers.particles
        return len(particles.snapshot().id) if particles else 0

    def close(self) -> None:
        """Close the machine."""
        self._machine.close()


def still(loaded: JudgedCase) -> JudgedCase:
    """Return the case with rigid panels that nothing moves."""
    case = loaded.case
    return replace(
        loaded,
        case=case.model_copy(
            update={
                "panel": case.panel.model_copy(update={"solver": "rigid"}),
                "exchange": case.exchange.model_copy(update=STILL),
            }
        ),
    )


def bench(loaded: JudgedCase, intervals: int, settling: int = 0) -> Table:
    """Run the case and its still copy, and return the table of their times by part.

    Both run about ``intervals`` sync intervals, after ``settling`` intervals that do not count.
    """
    with tempfile.TemporaryDirectory(prefix="flipflow-bench-") as scratch:
        coupled = Runner(loaded, Path(scratch) / "coupled")
        alone = Runner(still(loaded), Path(scratch) / "still")
        for number in range(settling // BLOCK + max(1, intervals // BLOCK)):
            if number == settling // BLOCK:
                coupled.forget()
                alone.forget()
            coupled.block()
            alone.block()
        table = compare(loaded.name, coupled, alone)
        coupled.close()
        alone.close()
    return table


def compare(name: str, coupled: Runner, alone: Runner) -> Table:
    """Return the table of times, their ratio to the particles alone, and particle-steps per second."""
    still_s = alone.stopwatch.wall_s["particles"]
    parts_s = coupled.stopwatch.wall_s
    table = Table(title=f"{name}: {coupled.particles()} particles", title_justify="left")
    for column in ("", "wall / s", "share", "against still", "particle-steps / s"):
        table.add_column(column, justify="left" if column == "" else "right", no_wrap=True)

    def row(what: str, wall_s: float, particle_steps: int = 0) -> None:
        speed = f"{particle_steps / wall_s:.3g}" if particle_steps else ""
        share = "" if what == STILL_ROW else f"{100 * wall_s / coupled.wall_s:.0f} %"
        table.add_row(what, f"{wall_s:.2f}", share, f"{wall_s / still_s:.2f}", speed)

    row(STILL_ROW, still_s, alone.particle_steps)
    row("particles in the coupled run", parts_s["particles"], coupled.particle_steps)
    for part in ("panel", "frames", "mapping"):
        row(part, parts_s.get(part, 0.0))
    row("coupled run, without output", coupled.wall_s, coupled.particle_steps)
    return table
