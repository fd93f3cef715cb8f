"""The record of particles that a case takes over from a run or from a table."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array
from orchestrator.ports.grains import Grains, upright

MOTION = ("position_m", "velocity_m_per_s", "spin_rad_per_s")
PLACED = (*MOTION, "orientation")


@dataclass(frozen=True, eq=False)
class CarriedBed:
    """Particles with which a case begins, as they were found; n is their number.

    Parameters
    ----------
    materials
        The names of the materials.
    position_m, velocity_m_per_s, spin_rad_per_s
        (n, 3) in world axes.
    grains
        What they are, n of them; the numbers of their materials are places in ``materials``, and a table
        without densities has NaN.
    time_s
        The time of the state in the run that it comes from; NaN for a table.
    coarse_graining
        The number of diameters of real particles for which one diameter stands; NaN for a table.
    source
        The file that the particles were read from.
    doubt
        Why the run that it comes from cannot be trusted, in words; empty if nothing speaks against it.
    unfit
        What does not fit the case, with what helps, besides the places: materials and coarse graining.  Their
        stand-ins in the record serve to check the places in the same round, and never run.
    note
        How a table was understood, where it says less than it might, in words.
    orientation
        (n, 4) how they are turned, as ``ParticleList`` has it; upright, if it is not given.
    """

    materials: tuple[str, ...]
    position_m: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array
    grains: Grains
    time_s: float
    coarse_graining: float
    source: str
    doubt: str = ""
    unfit: tuple[tuple[str, str], ...] = ()
    note: str = ""
    orientation: Array = field(default_factory=lambda: upright(0))

    def __post_init__(self) -> None:
        if not len(self.orientation):
            object.__setattr__(self, "orientation", upright(len(self)))

    def part(self, rows: npt.NDArray[np.bool_]) -> CarriedBed:
        """Return the particles of some rows."""
        motion = {name: getattr(self, name)[rows] for name in PLACED}
        return replace(self, **motion, grains=self.grains.part(rows))

    def of_material(self, material: str) -> Grains:
        """Return the grains of a material."""
        return self.grains.part(self.grains.material == self.materials.index(material))

    def __len__(self) -> int:
        return len(self.grains)
