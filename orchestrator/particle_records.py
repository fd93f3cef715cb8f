"""Lists of particles that their solver hands out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from orchestrator.crossing import Array, Indices


@dataclass(frozen=True)
class ParticleSnapshot:
    """All particles at one instant, sorted by id.  Arrays of n rows; complete on rank 0 only."""

    id: Indices
    position_m: Array
    velocity_m_s: Array
    spin_rad_s: Array
    diameter_m: Array
    density_kg_m3: Array
    material: Indices


@dataclass(frozen=True)
class Removed:
    """Particles taken out, in the order of time, then id.  Arrays of n rows; complete on rank 0
    only.

    State of each when it was taken out; ``exit`` is the number of the exit that it was in, -1 of
    one that was lost: it left the domain.
    """

    id: Indices
    time_s: Array
    position_m: Array
    velocity_m_s: Array
    diameter_m: Array
    density_kg_m3: Array
    material: Indices
    exit: Indices


@dataclass(frozen=True)
class Overlaps:
    """How deep contacts are, 0 where nothing touches: the largest overlap between particles and
    with the surface, and the largest over the diameter of the (smaller) particle."""

    between_m: float
    between_per_diameter: float
    surface_m: float
    surface_per_diameter: float


Bed = tuple[ParticleSnapshot, Overlaps]


def in_order(parts: Sequence[Removed]) -> Removed:
    """All of several, none included, in the order of time, then id."""
    nothing, nobody = np.empty(0), np.empty(0, dtype=np.int64)
    places = np.empty((0, 3))
    none = Removed(nobody, nothing, places, places, nothing, nothing, nobody, nobody)
    names = [part.name for part in fields(Removed)]
    joined = {n: np.concatenate([getattr(one, n) for one in (none, *parts)]) for n in names}
    order = np.lexsort((joined["id"], joined["time_s"]))
    return Removed(**{name: values[order] for name, values in joined.items()})
