"""The feed of particles at a mass rate through an inlet box.  Theory: docs/theory/feed.md."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.case.bed.packing import equal_particles, find_places, no_particles, random_orientations
from orchestrator.case.bed.size_distribution import shares, size_m
from orchestrator.case.tables.bed import SizeClass
from orchestrator.ports import Array, Indices, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.grains import Grain, Grains, upright
from orchestrator.ports.plans import ParticleList
from orchestrator.ports.rows import Rows
from orchestrator.ports.state import as_arrays, like, restore_attributes, save_attributes

SAME_PLACE_M = 1e-9
ROUNDS = 20  # The particles of one batch get so many rounds of proposals.
FULL_SHARE = 0.2  # This share of the box's volume can be kept full at a steady flow through it.


@dataclass(frozen=True)
class Inlet:
    """The place, the particles and the rate of a feed: particles like one ``grain``, of the ``sizes``.

    ``box_m`` (2, 3) has the lowest and the highest corner, and ``velocity_m_per_s`` (3,) carries the
    particles out of the box.  Both are in the inlet's own axes, which are the columns of ``axes``
    (3, 3) in the world.  Particles come in batches, ``batch_s`` apart; ``stop_s`` may be infinite.
    """

    sizes: tuple[SizeClass, ...]
    rate_kg_per_s: float
    box_m: Array
    velocity_m_per_s: Array
    grain: Grain[float]
    start_s: float = 0.0
    stop_s: float = math.inf
    seed: int = 1
    name: str = ""
    axes: Array = field(default_factory=lambda: np.eye(3))
    batch_s: float = 0.0

    def due_kg(self, time_s: float) -> float:
        """Return the mass that should have been fed at a time."""
        return self.rate_kg_per_s * max(0.0, min(time_s, self.stop_s) - self.start_s)

    @property
    def largest_rate_kg_per_s(self) -> float:
        """An estimate of the largest rate for which the box has room.

        It is the lower of two rates: the flow out of a box that is filled by 20 %, and the rate at
        which batches fill an empty box by 20 %.
        """
        length_m = self.box_m[1] - self.box_m[0]
        box_m3 = float(np.prod(length_m))
        leaving_m3_per_s = float(np.abs(self.velocity_m_per_s) @ (box_m3 / length_m))
        if self.batch_s > 0:
            leaving_m3_per_s = min(leaving_m3_per_s, box_m3 / self.batch_s)
        return FULL_SHARE * self.grain.density_kg_per_m3 * leaving_m3_per_s

    @property
    def largest_kg(self) -> float:
        """The mass of the largest particle."""
        return self.grain.resized(max(row.largest_m for row in self.sizes)).mass_kg

    @property
    def corners_m(self) -> Array:
        """The corners of the box in the world, (8, 3)."""
        corners = np.array(list(product(*self.box_m.T)))
        return np.asarray(corners @ self.axes.T)


_STATE = ("_drawn_kg", "_waiting_m", "_offered", "_next_m", "due_kg", "fed_kg")


class RateFeed:
    """A ``Feed`` of one inlet; it is picklable, and the same inlet gives the same particles everywhere.

    The mass drawn of each size class stays within half a particle of its share of ``due_kg``.  Particles
    that find no room wait for the next batch.
    """

    def __init__(self, inlet: Inlet) -> None:
        self.inlet = inlet
        self._shares = shares(inlet.sizes)
        self._generator = np.random.default_rng(inlet.seed)
        self._drawn_kg = np.zeros(len(inlet.sizes))
        self._waiting_m = np.empty(0)
        self._offered = np.empty(0, dtype=np.int64)
        self._next_m = np.array([self._draw_size_m(number) for number in range(len(inlet.sizes))])
        self.due_kg = self.fed_kg = 0.0

    @property
    def next_due_kg(self) -> Array:
        """The mass due of all classes at which the next particle of each is drawn, (classes,).

        Half of the particle is then due of its class.
        """
        half_kg = self.inlet.grain.of_sizes(self._next_m).mass_kg / 2.0
        return np.asarray((self._drawn_kg + half_kg) / self._shares)

    def due(self, interval: Interval) -> ParticleList:
        """Return the particles offered at the start of an interval, in world axes."""
        self.due_kg = self.inlet.due_kg(interval.start_s)
        self._draw()
        self._waiting_m = np.sort(self._waiting_m)[::-1]
        inlet = self.inlet
        grains = inlet.grain.of_sizes(self._waiting_m)
        center_m, placed = find_places(grains.bounding_radius_m, inlet.box_m, self._generator, ROUNDS)
        self._offered = np.flatnonzero(placed)
        velocity_m_per_s = inlet.axes @ inlet.velocity_m_per_s
        count = int(placed.sum())
        anyhow = inlet.grain.sphere_count > 1
        turns = random_orientations(count, self._generator) if anyhow else upright(count)
        return equal_particles(center_m[placed] @ inlet.axes.T, velocity_m_per_s, grains.part(placed), turns)

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        """Count the offered particles that the solver ``accepted`` (n,) as fed; the others wait.

        Raises ValueError unless ``accepted`` has one entry for each particle offered.
        """
        if len(accepted) != len(self._offered):
            raise ValueError(f"{len(self._offered)} particles offered, {len(accepted)} answers")
        fed = self._offered[accepted]
        self.fed_kg += float(np.sum(self.inlet.grain.of_sizes(self._waiting_m[fed]).mass_kg))
        self._waiting_m = np.delete(self._waiting_m, fed)
        self._offered = np.empty(0, dtype=np.int64)

    def save(self) -> Saved:
        """Return the state of the feed for a checkpoint."""
        return save_attributes(self, *_STATE) | {"generator": _generator_state(self._generator)}

    def restore(self, saved: Saved) -> None:
        """Restore the state of the feed from a checkpoint."""
        restore_attributes(self, saved, *_STATE)
        _set_generator_state(self._generator, saved["generator"])

    def _draw(self) -> None:
        """Draw the particles of which half is due by now, in the order in which they became due."""
        drawn_m = []
        while (next_due_kg := self.next_due_kg).min() <= self.due_kg:
            number = int(np.argmin(next_due_kg))
            drawn_m.append(float(self._next_m[number]))
            self._drawn_kg[number] += self.inlet.grain.resized(self._next_m[number]).mass_kg
            self._next_m[number] = self._draw_size_m(number)
        self._waiting_m = np.append(self._waiting_m, drawn_m)

    def _draw_size_m(self, number: int) -> float:
        """Draw the sieve size of a particle of a size class."""
        return float(size_m(self.inlet.sizes[number], np.asarray(self._generator.random())))


@dataclass(frozen=True)
class Fed(Rows):
    """The particles that came in, in the order of their ids, as arrays of n rows."""

    id: Indices
    time_s: Array
    grains: Grains


class Feeds:
    """A ``Feed`` of several inlets, which records the particles that came in and their times.

    The ``first`` particles are there at t = 0 and count as having come in then.  Solvers give ids in
    order, and so no ids need to cross the port.
    """

    def __init__(self, inlets: Sequence[Inlet], every: int = 1, first: ParticleList | None = None) -> None:
        """Prepare the feeds of the inlets, with a batch in every ``every``-th sync interval.

        Raises ValueError for overlapping boxes, because their particles could overlap, too.
        """
        for one, other in combinations(inlets, 2):
            if not are_apart(one, other):
                raise ValueError(f"feed boxes overlap: {one.box_m.tolist()} and {other.box_m.tolist()}")
        self._every = every
        self.feeds = [RateFeed(inlet) for inlet in inlets]
        self._count = 0
        self._since: list[Fed] = []
        self._offers: list[ParticleList] = []
        self._note(first or no_particles(), 0.0)

    def due(self, interval: Interval) -> ParticleList:
        """Return the particles that all feeds offer at the start of an interval."""
        self._time_s = interval.start_s
        if interval.index % (self._every * interval.parts):
            self._offers = []
            return no_particles()
        self._offers = [feed.due(interval) for feed in self.feeds]
        return ParticleList.joined(self._offers)

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        """Tell the feeds which of the offered particles the solver ``accepted`` (n,), and record these."""
        if not len(accepted):
            return
        sizes = [len(offer) for offer in self._offers]
        for feed, part in zip(self.feeds, np.split(accepted, np.cumsum(sizes)[:-1]), strict=True):
            feed.settle(part)
        self._note(ParticleList.joined(self._offers).part(accepted), self._time_s)

    def take_fed(self) -> Fed:
        """Return the particles that came in since the last call."""
        since, self._since = Fed.joined(self._since), []
        self._note(no_particles(), 0.0)
        return since

    def save(self) -> Saved:
        """Return the state of all feeds for a checkpoint."""
        feeds = {str(number): feed.save() for number, feed in enumerate(self.feeds)}
        return save_attributes(self, "_count") | {"since": as_arrays(Fed.joined(self._since)), "feeds": feeds}

    def restore(self, saved: Saved) -> None:
        """Restore the state of all feeds from a checkpoint."""
        restore_attributes(self, saved, "_count")
        self._since = [like(self._since[0], saved["since"])]
        for number, feed in enumerate(self.feeds):
            feed.restore(saved["feeds"][str(number)])

    def _note(self, accepted: ParticleList, time_s: float) -> None:
        """Record particles that came in at a time."""
        first_id, count = self._count + 1, len(accepted)
        ids, times_s = first_id + np.arange(count), np.full(count, time_s)
        self._since.append(Fed(ids, times_s, accepted.grains))
        self._count += count


def are_apart(one: Inlet, two: Inlet) -> bool:
    """Return whether the bounds of two boxes, along the axes of either, show that they do not overlap."""
    for axes in (one.axes, two.axes):
        first, second = one.corners_m @ axes, two.corners_m @ axes
        if (first.max(axis=0) <= second.min(axis=0) + SAME_PLACE_M).any():
            return True
        if (second.max(axis=0) <= first.min(axis=0) + SAME_PLACE_M).any():
            return True
    return False


def _generator_state(generator: np.random.Generator) -> npt.NDArray[np.uint64]:
    """Return the state of a PCG64 generator, (6,).

    The first four numbers are the halves of its two 128-bit numbers; the other two are the unused
    part of its last 64 bits.
    """
    state: Any = generator.bit_generator.state
    halves = [half for key in ("state", "inc") for half in divmod(state["state"][key], 2**64)]
    return np.array([*halves, state["has_uint32"], state["uinteger"]], dtype=np.uint64)


def _set_generator_state(generator: np.random.Generator, words: npt.NDArray[np.uint64]) -> None:
    """Set the state of a PCG64 generator from the numbers of ``_generator_state``."""
    high, low, inc_high, inc_low, has_more, more = map(int, words)
    numbers = {"state": high * 2**64 + low, "inc": inc_high * 2**64 + inc_low}
    generator.bit_generator.state = {
        "bit_generator": "PCG64",
        "state": numbers,
        "has_uint32": has_more,
        "uinteger": more,
    }
