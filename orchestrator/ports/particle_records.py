"""Lists of particles that their solver hands out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from orchestrator.ports.grains import Grain, Grains, ShapeTable, upright
from orchestrator.ports.interface_records import Array, Indices
from orchestrator.ports.rows import Rows

LARGEST_CARRIED_OVERLAP = 0.5
"""A share of a radius, of contacts that are softer than their materials.  Contact laws are for contacts that
are small against the bodies; the area of one that is half a radius deep has 0.7 of the particle's own radius
(Hertz: sqrt(r overlap)), and at one radius the centre is through the surface."""
LARGEST_OWN_OVERLAP = 0.9
"""A share of a radius, of contacts as stiff as their materials, for which a deep contact is a fact: a lump
presses a fine grain into a mat of rubber.  Hertz's force is then 10 % above that of a rigid sphere in an
elastic half space (I. N. Sneddon, Int. J. Engng Sci. 3, 1965, 47, doi 10.1016/0020-7225(65)90019-4)."""


def largest_overlap(softened: bool) -> float:
    """Return the share of a radius beyond which a contact is not to be trusted."""
    return LARGEST_CARRIED_OVERLAP if softened else LARGEST_OWN_OVERLAP


@dataclass(frozen=True)
class ParticleSnapshot(Rows):
    """All particles at one instant, sorted by id; complete on rank 0 only.

    Parameters
    ----------
    id
        (n,) each particle's own number.
    position_m, velocity_m_per_s, spin_rad_per_s
        (n, 3) in the world frame, of the centres of mass.
    grains
        What they are, n of them.
    force_N
        (n, 3) the sum of all forces on each particle, gravity included, in the last evaluation of the forces;
        None if the solver does not tell it.
    contacts
        (n,) the number of other particles that each one touches; None if the solver does not tell it.
    orientation
        (n, 4) unit quaternions w, x, y, z, which turn the axes of the shapes to those of the world; upright,
        if they are not given.
    """

    id: Indices
    position_m: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array
    grains: Grains
    force_N: Array | None = None
    contacts: Indices | None = None
    orientation: Array = field(default_factory=lambda: upright(0))

    def __post_init__(self) -> None:
        if not len(self.orientation):
            object.__setattr__(self, "orientation", upright(len(self.id)))


@dataclass(frozen=True)
class Removed(Rows):
    """Particles that were taken out, in the order of time, then id; complete on rank 0 only.

    Parameters
    ----------
    id, time_s
        (n,) who was taken out, and when.
    position_m, velocity_m_per_s
        (n, 3) at that time.
    grains
        What they are, n of them.
    exit
        (n,) the number of the exit that the particle was in, -1 for one that left the domain.
    contacts
        (n, panels of the plan's deck) the number of its contacts with the perforated part of each panel, in
        the order of the deck; (n, 0) without one.  A contact is an episode: it begins with a touch, or
        without one when the particle is through the mat, and is over at a sync point at which the gap below
        the particle is a quarter of its size or more and nothing touched since the last one.
    over_s, within_reach_s
        (n, panels) the time over each panel, cross beam behind it included, from sync point to sync point,
        and the part of it within reach of the mat.
    last_panel
        (n,) the panel of its last contact, -1 without one.
    """

    id: Indices
    time_s: Array
    position_m: Array
    velocity_m_per_s: Array
    grains: Grains
    exit: Indices
    contacts: npt.NDArray[np.int32]
    over_s: npt.NDArray[np.float32]
    within_reach_s: npt.NDArray[np.float32]
    last_panel: Indices


@dataclass(frozen=True)
class Overlaps:
    """The deepest contacts of all steps in some time; 0 where nothing touched.

    Parameters
    ----------
    between_m, surface_m
        The largest overlap between particles, and with the surface.
    between_per_diameter, surface_per_diameter
        The largest overlap over the diameter of the (smaller) particle.
    """

    between_m: float = 0.0
    between_per_diameter: float = 0.0
    surface_m: float = 0.0
    surface_per_diameter: float = 0.0

    def figures(self) -> dict[str, float]:
        """Return the table in ``summary.json``."""
        return dict(vars(self))

    def deepest(self, other: Overlaps) -> Overlaps:
        """Return the deepest contacts of two records together."""
        pairs = zip(vars(self).values(), vars(other).values(), strict=True)
        return Overlaps(*(max(pair) for pair in pairs))


@dataclass(frozen=True)
class Crossings:
    """The number of times that a particle's centre went through one of the surface's triangles since t = 0.

    A contact pushes a centre back to its present side of a triangle, so a centre that comes to the other side
    was pushed through by contacts too soft or jumped through in steps too long.  A particle that goes through
    an opening, past a free edge or between two panels goes through no triangle.

    Parameters
    ----------
    number
        How often it happened.
    first_id, first_time_s, first_position_m
        Who was the first, when, and where it was (3,); zeros where there was none.
    """

    number: int
    first_id: int
    first_time_s: float
    first_position_m: Array

    @staticmethod
    def none() -> Crossings:
        """Return a record without crossings."""
        return Crossings(0, 0, 0.0, np.zeros(3))

    def first_in_words(self) -> str:
        """Return the first particle, its place and its time, in words for a message."""
        place = ", ".join(f"{x:.4g}" for x in self.first_position_m)
        return f"particle {self.first_id} at ({place}) m at t = {self.first_time_s:.6g} s"

    def figures(self) -> dict[str, Any]:
        """Return the entry of ``summary.json``; nulls where there was none."""
        some = self.number > 0
        return {
            "number": self.number,
            "first_id": self.first_id if some else None,
            "first_time_s": self.first_time_s if some else None,
            "first_position_m": self.first_position_m.tolist() if some else None,
        }

    def followed_by(self, later: Crossings) -> Crossings:
        """Return the record of these crossings and of ``later`` ones."""
        first = self if self.number else later
        return replace(first, number=self.number + later.number)


class BedSnapshot(NamedTuple):
    """The bed at an output time: its particles and their overlaps since the output time before."""

    particles: ParticleSnapshot
    overlaps: Overlaps


def sort_removed(parts: Sequence[Removed], shapes: ShapeTable, panels: int = 0) -> Removed:
    """Return the particles of several records (of none, too) in the order of time, then id.

    ``shapes`` are those of the plan, and ``panels`` is the number of panels whose contacts are counted.
    """
    nothing, nobody = np.empty(0), np.empty(0, dtype=np.int64)
    places, by_panel = np.empty((0, 3)), np.empty((0, panels))
    contacts, seconds = by_panel.astype(np.int32), by_panel.astype(np.float32)
    grains: Grains = Grain(nothing, nothing, nobody, nobody, shapes)
    none = Removed(
        nobody, nothing, places, places, grains, nobody, contacts, seconds, seconds, last_panel=nobody
    )
    joined = Removed.joined([none, *parts])
    return joined.part(np.lexsort((joined.id, joined.time_s)))
