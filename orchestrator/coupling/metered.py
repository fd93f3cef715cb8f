"""Solvers with a meter, which measures their time and impulses and adds their name to every failure.

A metered solver is a solver, too, and the coupling treats both alike.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from orchestrator.coupling._kernel import add_handed_over
from orchestrator.coupling.wrappers import FramesWrapper, PanelWrapper, ParticlesWrapper, Wrapped, Wrapper
from orchestrator.ports import (
    Array,
    ContactTangent,
    Frames,
    HermitePath,
    Known,
    Load,
    Motion,
    Panel,
    PanelState,
    Particles,
    Restorable,
    Saved,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.failures import solver_failure_context
from orchestrator.ports.panel import Joinable, JointAdvance
from orchestrator.ports.state import restore_attributes, save_attributes


class Stopwatch:
    """A stopwatch of exclusive wall time by part.

    Entering a part pauses the part outside it, so the parts add up to the time inside any of them.
    ``repeated_s`` is the share of ``wall_s`` in which members ran an interval again.
    """

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}
        self.repeated_s: dict[str, float] = {}
        self.open: list[tuple[str, bool]] = []
        self._last: dict[int, Interval] = {}
        self._since_s = 0.0

    def __call__(self, part: str) -> TimedPart:
        """Return the context whose time counts as ``part``."""
        return TimedPart(self, part)

    def run(self, part: str, member: object, interval: Interval) -> TimedPart:
        """Return the context of a member's run over an interval, which is repeated if its last run was over
        the same one."""
        repeated = self._last.get(id(member)) is interval
        self._last[id(member)] = interval
        return TimedPart(self, part, repeated)

    def book(self) -> None:
        """Count the time since the last call for the innermost part that is open."""
        now = time.perf_counter()
        if self.open:
            part, repeated = self.open[-1]
            spent_s = now - self._since_s
            self.wall_s[part] = self.wall_s.get(part, 0.0) + spent_s
            if repeated:
                self.repeated_s[part] = self.repeated_s.get(part, 0.0) + spent_s
        self._since_s = now


class TimedPart:
    """The context of a part of a stopwatch; several are entered in each interval, so it is no generator."""

    __slots__ = ("_part", "_repeated", "_stopwatch")

    def __init__(self, stopwatch: Stopwatch, part: str, repeated: bool = False) -> None:
        self._stopwatch, self._part, self._repeated = stopwatch, part, repeated

    def __enter__(self) -> None:
        self._stopwatch.book()
        self._stopwatch.open.append((self._part, self._repeated))

    def __exit__(self, *_: object) -> None:
        self._stopwatch.book()
        self._stopwatch.open.pop()


@dataclass(frozen=True)
class Meter:
    """The impulse that loads have handed over since t = 0: ``sums`` (7,) of ``add_handed_over``."""

    sums: Array = field(default_factory=lambda: np.zeros(7))

    def add(self, load: Load, start: Motion, end: Motion, length_s: float) -> None:
        """Add a mean load over an interval in which its points moved from ``start`` to ``end``."""
        add_handed_over(self.sums, load, start, end, length_s)

    @property
    def impulse_N_s(self) -> Array:
        """The impulse (3,)."""
        return self.sums[:3].copy()

    @property
    def moment_N_m_s(self) -> Array:
        """The angular impulse (3,) about the world's origin."""
        return self.sums[3:6].copy()

    @property
    def through_N_s(self) -> float:
        """The sum of the sizes of all components at all points, in which loads that cancel each other
        count."""
        return float(self.sums[6])


class Booked(Wrapper[Wrapped]):
    """A wrapper that saves its own ``BOOKS`` beside the state of its solver."""

    BOOKS: ClassVar[tuple[str, ...]]

    def save(self) -> Saved:
        return save_attributes(self, *self.BOOKS) | {"inner": super().save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *self.BOOKS)
        super().restore(saved["inner"])


class MeteredFrames(Booked[Frames], FramesWrapper):
    """Frames with a meter.

    ``received`` meters the panels' load on the frames; ``last`` has the last load, and the motion to which it
    led.  A drive that moves its frame with a velocity v from t = 0 on ``seizes`` the panels there: it gives
    each mass m at rest the momentum m v at once, for which it does the work m v^2.  Half of it becomes
    kinetic energy; the other half is lost, as in a plastic impact, and is ``blow_J`` (``Ledger.book_blow``).
    """

    BOOKS = ("received", "_now", "blow_J")
    last: tuple[Load, Motion]

    def __init__(self, frames: Frames, name: str, stopwatch: Stopwatch) -> None:
        super().__init__(frames)
        self._name, self._stopwatch = name, stopwatch
        self.received, self.seizes, self.blow_J = Meter(), False, 0.0

    def initial(self) -> Motion:
        with solver_failure_context(self._name, None):
            self._now = super().initial()
        self.seizes = bool(self._now.velocity_m_per_s.any())
        return self._now

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        with self._stopwatch("frames"), solver_failure_context(self._name, interval):
            motion = super().advance(interval, reaction)
        self.received.add(reaction, self._now, motion, interval.length_s)
        self.last, self._now = (reaction, motion), motion
        return motion

    @property
    def through_N_s(self) -> float:
        """The sum of the sizes of the impulses that crossed."""
        return self.received.through_N_s

    def ahead(self, interval: Interval) -> Known | None:
        with self._stopwatch("frames"), solver_failure_context(self._name, interval):
            return super().ahead(interval)


class TimedPanel(PanelWrapper):
    """A panel whose failures have its ``name``, and whose time counts as the stopwatch's ``part``."""

    def __init__(self, panel: Panel, name: str, part: str, stopwatch: Stopwatch) -> None:
        super().__init__(panel)
        self._name, self._part, self._stopwatch = name, part, stopwatch

    def initial(self) -> PanelState:
        with solver_failure_context(self._name, None):
            return super().initial()

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        with self._stopwatch.run(self._part, self, interval), solver_failure_context(self._name, interval):
            return super().advance(interval, clamps, load)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        with self._stopwatch(self._part), solver_failure_context(self._name, interval):
            return super().ahead(interval, clamps)

    def join(self, panels: Sequence[Panel]) -> JointAdvance | None:
        """Return the call that advances the solvers of panels together; failures have the first one's name
        and the number of the others, and say themselves which panel failed if a solver knows it."""
        inner = [panel._solver for panel in panels if isinstance(panel, TimedPanel)]
        if len(inner) < len(panels) or not isinstance(self._solver, Joinable):
            return None
        together = self._solver.join(inner)
        if together is None:
            return None
        name = f"{self._name} and {len(inner) - 1} more" if len(inner) > 1 else self._name

        def advance(interval: Interval, clamps: Motion, load: Load) -> PanelState:
            with self._stopwatch.run(self._part, self, interval), solver_failure_context(name, interval):
                return together(interval, clamps, load)

        return advance


class MeteredPanel(Booked[Panel], TimedPanel):
    """A panel with a meter.

    ``received`` meters the particles' load, and ``given`` the load on the frames; ``last`` has the last
    motion of the clamps, the load under which it happened, and the resulting state.
    """

    BOOKS = ("received", "given", "_surface", "_clamps")
    last: tuple[Motion, Load, PanelState]

    def __init__(self, panel: Panel, name: str, part: str, stopwatch: Stopwatch) -> None:
        super().__init__(panel, name, part, stopwatch)
        self.received, self.given = Meter(), Meter()
        self._clamps = Motion(panel.mount.position_m, np.zeros_like(panel.mount.position_m))

    def initial(self) -> PanelState:
        state = super().initial()
        self._surface = state.surface
        return state

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        state = super().advance(interval, clamps, load)
        self.received.add(load, self._surface, state.surface, interval.length_s)
        self.given.add(state.reaction, self._clamps, clamps, interval.length_s)
        self._surface, self._clamps = state.surface, clamps
        self.last = clamps, load, state
        return state

    @property
    def through_N_s(self) -> float:
        """The sum of the sizes of the impulses that crossed, on both sides."""
        return self.received.through_N_s + self.given.through_N_s


class MeteredParticles(Booked[Particles], ParticlesWrapper):
    """Particles with a meter.

    ``given`` meters their load on the surface; ``last`` has the last path of the surface, and the load on it.
    Their ``feed`` is saved with them: particles that step back are fed again.  ``runs`` counts all intervals
    run, including those that were taken back.
    """

    BOOKS = ("given",)
    last: tuple[HermitePath, Load]

    def __init__(self, particles: Particles, feed: Restorable, name: str, stopwatch: Stopwatch) -> None:
        super().__init__(particles)
        self._feed, self._name, self._stopwatch = feed, name, stopwatch
        self.runs, self.given = 0, Meter()

    def initial(self) -> Load:
        with solver_failure_context(self._name, None):
            return super().initial()

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        with self._stopwatch.run("particles", self, interval), solver_failure_context(self._name, interval):
            load = super().advance(interval, path)
        self.last = path, load
        self.given.add(load, path.start, path.end, interval.length_s)
        self.runs += 1
        return load

    @property
    def through_N_s(self) -> float:
        """The sum of the sizes of the impulses that crossed."""
        return self.given.through_N_s

    def contact_tangent(self, length_s: float) -> ContactTangent:
        with self._stopwatch("particles"):
            return super().contact_tangent(length_s)

    def save(self) -> Saved:
        return super().save() | {"feed": self._feed.save()}

    def restore(self, saved: Saved) -> None:
        super().restore(saved)
        self._feed.restore(saved["feed"])


Member = MeteredFrames | MeteredPanel | MeteredParticles


@dataclass(frozen=True)
class MeteredSolvers:
    """The metered members; ``particles`` is None where the case has none."""

    frames: MeteredFrames
    panel: MeteredPanel
    particles: MeteredParticles | None

    def by_name(self) -> dict[str, Member]:
        """Return the members of the machine by name."""
        members: dict[str, Member | None] = {
            "frames": self.frames,
            "panel": self.panel,
            "particles": self.particles,
        }
        return {name: member for name, member in members.items() if member is not None}
