"""Solvers with a meter: time spent, impulse handed over, and a name on every failure.

A metered solver is again a solver; the coupling does not know the difference.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import cast

import numpy as np

from orchestrator.coupling.altered_panel import AlteredPanel
from orchestrator.ports import (
    Account,
    Array,
    ContactTangent,
    Crossings,
    Frames,
    HermitePath,
    Inertia,
    Known,
    Load,
    Motion,
    Mount,
    Overlaps,
    Panel,
    PanelState,
    Particles,
    ParticleSnapshot,
    Predicting,
    Removed,
    Restorable,
    Saved,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.failures import solver_failure_context
from orchestrator.ports.frames import find_driven_points
from orchestrator.ports.panel import surface_ahead, surface_inertia
from orchestrator.ports.state import restore_attributes, save_attributes


class Stopwatch:
    """Measures exclusive wall time by part: entering a part pauses the one outside it, so the parts
    add up to the time inside any."""

    def __init__(self) -> None:
        self.wall_s: dict[str, float] = {}
        self._parts: list[str] = []
        self._since_s = 0.0

    @contextmanager
    def __call__(self, part: str) -> Iterator[None]:
        self._book()
        self._parts.append(part)
        try:
            yield
        finally:
            self._book()
            self._parts.pop()

    def _book(self) -> None:
        now = time.perf_counter()
        if self._parts:
            part = self._parts[-1]
            self.wall_s[part] = self.wall_s.get(part, 0.0) + now - self._since_s
        self._since_s = now


_OF_FRAMES = ("received_N_s", "through_N_s", "received_N_m_s", "_now")
_OF_PANELS = (
    "received_N_s",
    "given_N_s",
    "through_N_s",
    "received_N_m_s",
    "given_N_m_s",
    "_surface",
    "_clamps",
)


def impulse_N_s(load: Load, interval: Interval) -> Array:
    """Returns the impulse (3,) that a mean load hands over in the interval."""
    return np.asarray(interval.length_s * load.force_N.sum(axis=0))


def size_N_s(load: Load, interval: Interval) -> float:
    """Returns the sum of the sizes of all components of the impulse at all points, so that loads
    that cancel count."""
    return float(interval.length_s * np.abs(load.force_N).sum())


def moment_N_m_s(load: Load, start: Motion, end: Motion, interval: Interval) -> Array:
    """Returns the angular impulse (3,) about the world's origin that a mean load hands over.

    The points move smoothly (cubic Hermite) from ``start`` to ``end``; the mean of their places
    counts.
    """
    mean_m = (start.position_m + end.position_m) / 2.0
    mean_m += interval.length_s / 12.0 * (start.velocity_m_per_s - end.velocity_m_per_s)
    return np.asarray(interval.length_s * np.cross(mean_m, load.force_N).sum(axis=0))


class MeteredFrames:
    """Frames with a meter.

    ``received_N_s`` (3,): impulse of the panels on the frames since t = 0, ``through_N_s`` the
    sum of its sizes, ``received_N_m_s`` (3,) its moment about the world's origin; ``last`` what
    they felt last, and where that took them."""

    last: tuple[Load, Motion]

    def __init__(self, frames: Frames, name: str, stopwatch: Stopwatch) -> None:
        self._frames, self._name, self._stopwatch = frames, name, stopwatch
        self.received_N_s: Array = np.zeros(3)
        self.through_N_s = 0.0
        self.received_N_m_s: Array = np.zeros(3)

    def initial(self) -> Motion:
        with solver_failure_context(self._name, None):
            self._now = self._frames.initial()
        return self._now

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        self.received_N_s = self.received_N_s + impulse_N_s(reaction, interval)
        self.through_N_s += size_N_s(reaction, interval)
        with self._stopwatch("frames"), solver_failure_context(self._name, interval):
            motion = self._frames.advance(interval, reaction)
        moment_given_N_m_s = moment_N_m_s(reaction, self._now, motion, interval)
        self.received_N_m_s = self.received_N_m_s + moment_given_N_m_s
        self.last, self._now = (reaction, motion), motion
        return motion

    def ahead(self, interval: Interval) -> Known | None:
        with self._stopwatch("frames"), solver_failure_context(self._name, interval):
            return find_driven_points(self._frames, interval)

    def account(self) -> Account:
        return self._frames.account()

    def save(self) -> Saved:
        return save_attributes(self, *_OF_FRAMES) | {"inner": self._frames.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_OF_FRAMES)
        self._frames.restore(saved["inner"])

    def close(self) -> None:
        self._frames.close()


class MeteredPanel:
    """A panel with a meter.

    ``received_N_s`` (3,) from the particles, ``given_N_s`` (3,) to the frames, since t = 0, and
    ``through_N_s`` the sum of the sizes of both, ``received_N_m_s`` and ``given_N_m_s`` (3,) their
    moments about the world's origin; ``last`` where the clamps were told to go, under which load,
    and what came of it."""

    last: tuple[Motion, Load, PanelState]

    def __init__(self, panel: Panel, name: str, part: str, stopwatch: Stopwatch) -> None:
        self._panel = meter_panel(panel, name, part, stopwatch)
        self.mount: Mount = panel.mount
        self.received_N_s: Array = np.zeros(3)
        self.given_N_s: Array = np.zeros(3)
        self.through_N_s = 0.0
        self.received_N_m_s: Array = np.zeros(3)
        self.given_N_m_s: Array = np.zeros(3)
        self._clamps = Motion(panel.mount.position_m, np.zeros_like(panel.mount.position_m))

    def initial(self) -> PanelState:
        state = self._panel.initial()
        self._surface = state.surface
        return state

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        state = self._panel.advance(interval, clamps, load)
        received_N_m_s = moment_N_m_s(load, self._surface, state.surface, interval)
        given_N_m_s = moment_N_m_s(state.reaction, self._clamps, clamps, interval)
        self.received_N_m_s = self.received_N_m_s + received_N_m_s
        self.given_N_m_s = self.given_N_m_s + given_N_m_s
        self._surface, self._clamps = state.surface, clamps
        self.received_N_s = self.received_N_s + impulse_N_s(load, interval)
        self.given_N_s = self.given_N_s + impulse_N_s(state.reaction, interval)
        self.through_N_s += size_N_s(load, interval) + size_N_s(state.reaction, interval)
        self.last = clamps, load, state
        return state

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        return self._panel.ahead(interval, clamps)

    def inertia(self) -> Inertia:
        return surface_inertia(self._panel)

    def account(self) -> Account:
        return self._panel.account()

    def save(self) -> Saved:
        return save_attributes(self, *_OF_PANELS) | {"inner": self._panel.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_OF_PANELS)
        self._panel.restore(saved["inner"])

    def close(self) -> None:
        self._panel.close()


class MeteredParticles:
    """Particles with a meter.

    ``given_N_s`` (3,): impulse of the particles on the surface since t = 0, ``through_N_s`` the
    sum of its sizes; ``last`` the path that the surface took last, and the load on it.  Their
    ``feed`` is saved with them: particles that step back are fed again.  ``runs`` counts intervals
    run, those taken back, too."""

    last: tuple[HermitePath, Load]

    def __init__(self, particles: Particles, feed: Restorable, name: str, stopwatch: Stopwatch) -> None:
        self._particles, self._name, self._stopwatch = particles, name, stopwatch
        self._feed = feed
        self.runs = 0
        self.given_N_s: Array = np.zeros(3)
        self.through_N_s = 0.0

    def initial(self) -> Load:
        with solver_failure_context(self._name, None):
            return self._particles.initial()

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        with self._stopwatch("particles"), solver_failure_context(self._name, interval):
            load = self._particles.advance(interval, path)
        self.last = path, load
        self.given_N_s = self.given_N_s + impulse_N_s(load, interval)
        self.through_N_s += size_N_s(load, interval)
        self.runs += 1
        return load

    def contact_tangent(self, length_s: float) -> ContactTangent:
        with self._stopwatch("particles"):
            return cast(Predicting, self._particles).contact_tangent(length_s)

    def snapshot(self) -> ParticleSnapshot:
        return self._particles.snapshot()

    def removed(self) -> Removed:
        return self._particles.removed()

    def overlaps(self) -> Overlaps:
        return self._particles.overlaps()

    def crossings(self) -> Crossings:
        return self._particles.crossings()

    def account(self) -> Account:
        return self._particles.account()

    def save(self) -> Saved:
        inner = {"inner": self._particles.save(), "feed": self._feed.save()}
        return save_attributes(self, "given_N_s", "through_N_s") | inner

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "given_N_s", "through_N_s")
        self._particles.restore(saved["inner"])
        self._feed.restore(saved["feed"])

    def close(self) -> None:
        self._particles.close()


def meter_panel(panel: Panel, name: str, part: str, stopwatch: Stopwatch) -> AlteredPanel:
    """Returns the panel with a meter: it says its ``name`` when it fails, and its time is booked under
    ``part``."""
    follow = surface_ahead(panel)

    def initial() -> PanelState:
        with solver_failure_context(name, None):
            return panel.initial()

    def advance(interval: Interval, clamps: Motion, load: Load) -> PanelState:
        with stopwatch(part), solver_failure_context(name, interval):
            return panel.advance(interval, clamps, load)

    def ahead(interval: Interval, clamps: Known) -> Known:
        with stopwatch(part), solver_failure_context(name, interval):
            return follow(interval, clamps)

    return AlteredPanel(panel, advance, initial, ahead=ahead)


@dataclass(frozen=True)
class MeteredSolvers:
    """The metered members; ``particles`` is None where the case has none."""

    frames: MeteredFrames
    panel: MeteredPanel
    particles: MeteredParticles | None
