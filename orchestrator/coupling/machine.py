"""The assembled machine: open solvers, and the places of all points."""

from __future__ import annotations

from contextlib import ExitStack
from dataclasses import dataclass, field

import numpy as np

from orchestrator.case.bed.material_book import MaterialBook
from orchestrator.coupling.bushing_forces import BushingForces
from orchestrator.coupling.metered import MeteredSolvers, Stopwatch
from orchestrator.coupling.schemes.scheme import Scheme, Solvers
from orchestrator.ports import Array, Indices, Wearing
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.penetration import Penetrations


@dataclass(frozen=True)
class PanelPoints:
    """The place of one panel in the concatenated surface and clamps.

    ``centre_line`` and ``shape`` (the points that show its shape) index the surface;
    ``first_clamp``, ``second_clamp`` and ``stops`` (points of beams below it) index the clamps. ``edges`` (n,
    2) of its triangles index the surface, too; ``edge_length_m`` (n,) is their stress-free length.
    """

    name: str
    surface: slice
    clamps: slice
    centre_line: Indices
    shape: Indices
    first_clamp: Indices
    second_clamp: Indices
    stops: Indices
    edges: Indices
    edge_length_m: Array


@dataclass(frozen=True)
class PlacedProbe:
    """A point whose time series is recorded.

    ``on`` is "frame", "surface" (a point of a panel) or "particle"; ``index`` is the number of the frame, the
    number of the point on the surface, or the id of the particle.  ``arm_m`` (3,) leads from the frame's
    centre of mass to the point, at t = 0.
    """

    name: str
    on: str
    index: int
    arm_m: Array = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class Machine:
    """The machine of a run: its open solvers, its scheme, and the places of its points.

    ``frames`` are the frames' names, in the order of their poses.
    ``panel_of_triangle`` (triangles,) are panel numbers in the order of ``panels``, or -1 for walls.
    ``material`` is None if the case has no particles, and ``wearing`` is None if nothing wears.
    """

    solvers: Solvers
    members: MeteredSolvers
    scheme: Scheme
    stopwatch: Stopwatch
    surface: TriangleSurface
    panel_of_triangle: Indices
    panels: tuple[PanelPoints, ...]
    penetrations: Penetrations
    frames: tuple[str, ...]
    probes: tuple[PlacedProbe, ...]
    bushings: BushingForces
    material: MaterialBook | None
    wearing: Wearing | None

    @property
    def particle_runs(self) -> int:
        """The number of times that this process has moved the particles over an interval."""
        return self.members.particles.runs if self.members.particles is not None else 0

    def close(self) -> None:
        """Close every solver, even if one cannot be closed."""
        with ExitStack() as closing:
            closing.callback(self.solvers.frames.close)
            closing.callback(self.solvers.panel.close)
            if self.solvers.particles is not None:
                closing.callback(self.solvers.particles.close)
