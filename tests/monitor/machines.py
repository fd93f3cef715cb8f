"""The members on a line as a machine that the watch can look at."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console

from orchestrator.coupling import schemes
from orchestrator.coupling.bushing_forces import BushingForces
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.metered import (
    MeteredFrames,
    MeteredPanel,
    MeteredParticles,
    MeteredSolvers,
    Stopwatch,
)
from orchestrator.coupling.schemes.scheme import Solvers, State, initial_state
from orchestrator.ports import Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.penetration import Penetrations
from orchestrator.run.monitor.monitor import Monitor
from tests.cases import loaded
from tests.coupling.line import FreeFrame, HungPlate, Sphere

NOBODY = np.empty(0, dtype=np.int64)
NOWHERE = np.empty((0, 3))


class NoFeed:
    def save(self) -> Saved:
        return {}

    def restore(self, saved: Saved) -> None: ...


def metered(sphere: Sphere, plate: HungPlate, frame: FreeFrame, watch: Stopwatch) -> MeteredSolvers:
    return MeteredSolvers(
        MeteredFrames(frame, "frame", watch),
        MeteredPanel(plate, "plate", "panel", watch),
        MeteredParticles(sphere, NoFeed(), "sphere", watch),
    )


def on_a_line(sphere: Sphere, plate: HungPlate, frame: FreeFrame, scheme: str) -> Machine:
    stopwatch = Stopwatch()
    meters = metered(sphere, plate, frame, stopwatch)
    return Machine(
        solvers=Solvers(meters.frames, meters.panel, meters.particles),
        members=meters,
        scheme=schemes.create_scheme(scheme),
        stopwatch=stopwatch,
        surface=TriangleSurface(NOWHERE, np.empty((0, 3), dtype=np.int64), NOBODY),
        panel_of_triangle=NOBODY,
        panels=(),
        penetrations=Penetrations(NOWHERE, (), ()),
        frames=(),
        probes=(),
        bushings=BushingForces.of((), ()),
        material=None,
        wearing=None,
    )


def monitored(
    folder: Path,
    machine: Machine,
    interval_s: float,
    intervals: int,
    sets: Sequence[str] = (),
    each: Callable[[State], object] = lambda state: None,
) -> Monitor:
    """Runs so many intervals under the watch; ``each`` is shown what is recorded of them."""
    free = [f"coupling.sync_interval_s={interval_s}", *sets]
    state = initial_state(machine.solvers)
    monitor = Monitor(loaded(folder, free).case, machine, state, None, Console(quiet=True))
    for index in range(intervals):
        interval = Interval(index, interval_s)
        state, seen = monitor.advance(interval, state)
        each(seen)
        monitor.act(interval, state)
    return monitor
