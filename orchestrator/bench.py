"""What the coupling costs: a case's run against its particles alone on a rigid, still surface.

Both machines advance in turn, block by block, in one process, so that a machine whose speed
drifts slows both.  The still bed comes to rest, the thrown one does not: the still one has more
contacts, the thrown one more new neighbours.
"""

from __future__ import annotations

import tempfile
import time
from dataclasses import replace
from pathlib import Path

from rich.table import Table

from orchestrator.build import build
from orchestrator.clock import Interval
from orchestrator.contact_times import particle_step_s
from orchestrator.coupling import initial
from orchestrator.levels import LoadedCase
from orchestrator.stopwatch import Stopwatch

BLOCK = 100
STILL = {"frame_motion": False, "panel_motion": False, "particle_load": False}


class Runner:
    """A case that advances block by block, with its stopwatch."""

    def __init__(self, loaded: LoadedCase, folder: Path) -> None:
        folder.mkdir()
        self.stopwatch = Stopwatch()
        self._machine = build(loaded, folder, None, self.stopwatch)
        self._state = initial(self._machine.solvers)
        self._interval_s = loaded.case.coupling.sync_interval_s
        self._done = 0
        self.wall_s = 0.0
        particles = self._machine.solvers.particles
        self.particles = len(particles.snapshot().id) if particles else 0

    def block(self) -> None:
        started = time.perf_counter()
        for index in range(self._done, self._done + BLOCK):
            interval = Interval(index, self._interval_s)
            self._state = self._machine.scheme.advance(self._machine.solvers, interval, self._state)
        self._done += BLOCK
        self.wall_s += time.perf_counter() - started

    def close(self) -> None:
        self._machine.close()


def still(loaded: LoadedCase) -> LoadedCase:
    """The same case with rigid panels that nothing moves."""
    case = loaded.case
    return replace(
        loaded,
        case=case.model_copy(
            update={
                "panel": case.panel.model_copy(update={"solver": "rigid"}),
                "hand_over": case.hand_over.model_copy(update=STILL),
            }
        ),
    )


def bench(loaded: LoadedCase, intervals: int) -> Table:
    """Runs about ``intervals`` sync intervals of both; the table says what each part took."""
    with tempfile.TemporaryDirectory(prefix="flipflow-bench-") as scratch:
        coupled = Runner(loaded, Path(scratch) / "coupled")
        alone = Runner(still(loaded), Path(scratch) / "still")
        for _ in range(max(1, intervals // BLOCK)):
            coupled.block()
            alone.block()
        coupled.close()
        alone.close()
    case = loaded.case
    steps = Interval(0, case.coupling.sync_interval_s).steps(particle_step_s(case))
    particle_steps = coupled.particles * steps * max(1, intervals // BLOCK) * BLOCK
    still_s = alone.stopwatch.wall_s["particles"]
    table = Table(title=f"{loaded.name}: {coupled.particles} particles", title_justify="left")
    for column in ("", "wall / s", "against still", "particle-steps / s"):
        table.add_column(column, justify="left" if column == "" else "right")

    def row(name: str, wall_s: float, rate: bool) -> None:
        speed = f"{particle_steps / wall_s:.3g}" if rate else ""
        table.add_row(name, f"{wall_s:.2f}", f"{wall_s / still_s:.2f}", speed)

    row("particles alone, rigid still surface", still_s, True)
    row("particles in the coupled run", coupled.stopwatch.wall_s["particles"], True)
    for part in ("panel", "frames", "mapping"):
        row(part, coupled.stopwatch.wall_s.get(part, 0.0), False)
    row("coupled run, without output", coupled.wall_s, True)
    return table
