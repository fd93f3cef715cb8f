"""What contacts remember of the instant before: springs, couples, and which contact each was."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from adapters.particles.sphere_search import continued
from adapters.particles.sphere_touch import Touching
from orchestrator.ports import Array, Indices

if TYPE_CHECKING:
    from adapters.particles.sphere_forces import Forces


@dataclass(frozen=True)
class History:
    """Springs and couples an instant ago, in the rows of now; zero where the contact is new.
    ``same``, ``parent``: see ``continued``."""

    same: Indices
    parent: Indices
    shear_m: Array
    tension_N: Array
    couple_N_m: Array
    tangential_J: float  # in all, contacts that have ended included


def history(now: Touching, before: Forces | None, spheres: int) -> History:
    """Of the contacts ``now``, of so many spheres."""
    shear_m, tension_N, couple_N_m = np.zeros((3, len(now.first), 3))
    if before is None:
        nothing = np.full(len(now.first), -1)
        return History(nothing, nothing, shear_m, tension_N, couple_N_m, 0.0)
    same, parent = continued(now, before.touching, spheres)
    heir, old = np.flatnonzero(parent >= 0), np.flatnonzero(same >= 0)
    shear_m[heir] = before.shear_m[parent[heir]]
    couple_N_m[heir] = before.couple_N_m[parent[heir]]
    tension_N[old] = before.tangential_N_m[same[old], None] * shear_m[old]
    stored_J = float(before.tangential_J.sum())
    return History(same, parent, shear_m, tension_N, couple_N_m, stored_J)
