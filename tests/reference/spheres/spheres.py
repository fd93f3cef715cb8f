"""The spheres of which grains are made: one array per property, one row per sphere."""

from __future__ import annotations

from dataclasses import dataclass

from adapters.particles.liggghts.ledger import SolidSpheres
from orchestrator.ports import Array, Indices


@dataclass
class Spheres(SolidSpheres):
    """n spheres, those of one grain after those of the other.

    Masses and ids are those of the grains, whose row is ``body`` (n,); ``own_m`` (n, 3) is the place in the
    grain's principal axes.
    """

    id: Indices
    material: Indices
    body: Indices
    own_m: Array
