"""Solvers that stand before another solver of the same port, to which every call goes on.

A wrapper in this room (metered, mapped, with a hand-over off) alters the calls that it is about.
Wrappers answer the optional calls, too, also for a solver that has none of them.
"""

from __future__ import annotations

from typing import Generic, TypeVar, cast

from orchestrator.ports import (
    Account,
    ContactTangent,
    Crossings,
    Frames,
    HermitePath,
    Inertia,
    Known,
    Load,
    Motion,
    Overlaps,
    Panel,
    PanelState,
    Particles,
    ParticleSnapshot,
    Predicting,
    Removed,
    Saved,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import find_driven_points
from orchestrator.ports.panel import surface_ahead, surface_inertia
from orchestrator.ports.state import Solver

Wrapped = TypeVar("Wrapped", bound=Solver)


class Wrapper(Generic[Wrapped]):
    """The calls that wrappers of all ports hand on."""

    def __init__(self, solver: Wrapped) -> None:
        self._solver = solver

    def account(self) -> Account:
        return self._solver.account()

    def save(self) -> Saved:
        return self._solver.save()

    def restore(self, saved: Saved) -> None:
        self._solver.restore(saved)

    def close(self) -> None:
        self._solver.close()


class FramesWrapper(Wrapper[Frames]):
    """Frames that hand every call on."""

    def initial(self) -> Motion:
        return self._solver.initial()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        return self._solver.advance(interval, reaction)

    def ahead(self, interval: Interval) -> Known | None:
        return find_driven_points(self._solver, interval)


class PanelWrapper(Wrapper[Panel]):
    """A panel that hands every call on."""

    def __init__(self, panel: Panel) -> None:
        super().__init__(panel)
        self.mount = panel.mount
        self._ahead = surface_ahead(panel)

    def initial(self) -> PanelState:
        return self._solver.initial()

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return self._solver.advance(interval, clamps, load)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        return self._ahead(interval, clamps)

    def inertia(self) -> Inertia:
        return surface_inertia(self._solver)


class ParticlesWrapper(Wrapper[Particles]):
    """Particles that hand every call on."""

    def initial(self) -> Load:
        return self._solver.initial()

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        return self._solver.advance(interval, path)

    def contact_tangent(self, length_s: float) -> ContactTangent:
        return cast(Predicting, self._solver).contact_tangent(length_s)

    def snapshot(self) -> ParticleSnapshot:
        return self._solver.snapshot()

    def removed(self) -> Removed:
        return self._solver.removed()

    def overlaps(self) -> Overlaps:
        return self._solver.overlaps()

    def crossings(self) -> Crossings:
        return self._solver.crossings()
