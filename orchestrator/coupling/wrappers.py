"""Wrappers: solvers that stand before another solver of the same port and pass every call on to it.

Each wrapper of this package (metered, mapped, with an exchange off) changes the calls that concern it.
Wrappers answer the optional calls of a port even if their solver does not.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Generic, TypeVar, cast

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
    Overlaps,
    Panel,
    PanelState,
    Particles,
    ParticleSnapshot,
    Pose,
    Predicting,
    Removed,
    Saved,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import (
    FrameLoads,
    find_driven_points,
    find_element_forces_N,
    find_frame_loads,
    find_shaft_angles_rad,
)
from orchestrator.ports.panel import surface_ahead, surface_inertia
from orchestrator.ports.state import Solver

Wrapped = TypeVar("Wrapped", bound=Solver)


class Wrapper(Generic[Wrapped]):
    """The wrapper of a solver of any port, with the calls that all ports share."""

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
    """A wrapper that passes every call on to its frames."""

    def initial(self) -> Motion:
        return self._solver.initial()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        return self._solver.advance(interval, reaction)

    def ahead(self, interval: Interval) -> Known | None:
        return find_driven_points(self._solver, interval)

    def pose(self) -> Pose:
        return self._solver.pose()

    def element_forces_N(self) -> Array | None:
        return find_element_forces_N(self._solver)

    def shaft_angles_rad(self) -> Mapping[str, float]:
        return find_shaft_angles_rad(self._solver)

    def loads(self) -> FrameLoads | None:
        return find_frame_loads(self._solver)


class PanelWrapper(Wrapper[Panel]):
    """A wrapper that passes every call on to its panel."""

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
    """A wrapper that passes every call on to its particles."""

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
