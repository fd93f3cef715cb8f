"""What the particles' solver needs to know."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface


@dataclass(frozen=True)
class GrainMaterial:
    name: str
    youngs_modulus_Pa: float
    poisson_ratio: float


@dataclass(frozen=True)
class ParticleList:
    """Particles to create: positions (n, 3), velocities (n, 3), spins (n, 3) in rad/s,
    diameters (n,), densities (n,), materials (n,) as indices.  Ids are given in order."""

    position_m: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array
    diameter_m: Array
    density_kg_per_m3: Array
    material: Indices

    def __len__(self) -> int:
        return len(self.diameter_m)

    def part(self, rows: npt.NDArray[np.bool_]) -> ParticleList:
        return ParticleList(*(getattr(self, field.name)[rows] for field in fields(self)))


class ParticleFeed(Protocol):
    """New particles for each interval.  Deterministic: alike on every rank."""

    def due(self, interval: Interval) -> ParticleList:
        """Particles wanted at the interval's start; they do not overlap each other."""
        ...

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        """Which of those just offered (bool per particle) found room; the rest is tried again."""
        ...


@dataclass(frozen=True)
class ExitPlan:
    """A box that takes out every particle whose centre is in it.

    ``center_m`` (3,) in the world; the rows of ``axes`` (3, 3) are the unit vectors along its
    edges, ``half_m`` (3,) half their lengths.
    """

    name: str
    product: str
    center_m: Array
    axes: Array
    half_m: Array

    def holds(self, position_m: Array) -> npt.NDArray[np.bool_]:
        """Which of the positions (n, 3) are in it, (n,)."""
        along_edges_m = (position_m - self.center_m) @ self.axes.T
        return np.asarray(np.all(np.abs(along_edges_m) <= self.half_m, axis=1))


@dataclass(frozen=True)
class Jkr:
    """Adhesion after Johnson, Kendall and Roberts: ``work_J_per_m2`` (k, k) by material.

    ``largest_stretch``: how far a neck reaches before it snaps, at most, as a share of a radius.
    """

    work_J_per_m2: Array
    largest_stretch: float


@dataclass(frozen=True)
class Sjkr:
    """LIGGGHTS's ``sjkr``: attraction ``energy_density_J_per_m3`` (k, k) times the area of contact."""

    energy_density_J_per_m3: Array


@dataclass(frozen=True)
class ParticlesPlan:
    """Particles, the surface they touch, and the laws between them.

    ``restitution``, ``sliding_friction``, ``rolling_friction``: (k, k) symmetric, by material.
    ``wear_m3_per_N_m``: (k, k) too, volume that particles of one material wear off a surface of the
    other per force and distance slid; None where nothing wears.
    ``predicts_load``: whether the particles are to foretell their load (``ports.Predicting``).
    ``rolling``: the law of rolling resistance, where its coefficient is not zero.
    Particles in one of the ``exits``, or outside of ``domain_m`` (2, 3: lowest and highest
    corner), are removed; the first exit that holds one counts.  ``communicator`` is an mpi4py
    communicator or None.
    With ``periodic_y`` everything repeats itself along y with the domain's width, which the
    surface spans; nothing leaves there.
    """

    surface: TriangleSurface
    materials: tuple[GrainMaterial, ...]
    restitution: Array
    sliding_friction: Array
    rolling_friction: Array
    particles: ParticleList
    largest_diameter_m: float
    domain_m: Array
    gravity_m_per_s2: Array
    step_s: float
    sync_interval_s: float
    adhesion: Jkr | Sjkr | None = None
    rolling: Literal["epsd2", "cdt"] = "epsd2"
    wear_m3_per_N_m: Array | None = None
    predicts_load: bool = False
    feed: ParticleFeed | None = None
    exits: tuple[ExitPlan, ...] = ()
    periodic_y: bool = False
    communicator: Any = None
    folder: Path | None = None
