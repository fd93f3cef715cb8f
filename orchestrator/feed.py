"""Particles fed at a mass rate through an inlet box.  Theory: docs/theory/feed.md."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from orchestrator.clock import Interval
from orchestrator.packing import places
from orchestrator.particle_sizes import SizeClass, mass_kg, shares
from orchestrator.plans import ParticleList
from orchestrator.ports import Array

ROUNDS = 20  # of proposals for the particles of one interval
EASY_SHARE = 0.1  # of the box's volume that can be kept full by one try an interval


@dataclass(frozen=True)
class Inlet:
    """Where, what and how fast: world axes, ``box_m`` (2, 3) lowest and highest corner.

    ``velocity_m_s`` (3,) carries the particles out of the box; ``stop_s`` may be infinite.
    """

    sizes: tuple[SizeClass, ...]
    rate_kg_s: float
    box_m: Array
    velocity_m_s: Array
    density_kg_m3: float
    material: int
    start_s: float = 0.0
    stop_s: float = math.inf
    seed: int = 1

    def due_kg(self, time_s: float) -> float:
        """Mass to be fed by then."""
        return self.rate_kg_s * max(0.0, min(time_s, self.stop_s) - self.start_s)

    @property
    def largest_rate_kg_s(self) -> float:
        """Estimate of the rate that finds room: what leaves a box that is filled by 10 %."""
        length_m = self.box_m[1] - self.box_m[0]
        faces_m2 = np.prod(length_m) / length_m
        leaving_m3_s = float(np.abs(self.velocity_m_s) @ faces_m2)
        return EASY_SHARE * self.density_kg_m3 * leaving_m3_s


class RateFeed:
    """``Feed`` of one inlet.  Picklable; the same inlet gives the same particles everywhere.

    What is drawn stays within half a particle of ``due_kg``; the class of each particle is the
    one whose mass lags most behind its share.  What finds no room waits and is tried again.
    """

    def __init__(self, inlet: Inlet) -> None:
        self._inlet = inlet
        self._shares = shares(inlet.sizes)
        self._generator = np.random.default_rng(inlet.seed)
        self._drawn_kg = np.zeros(len(inlet.sizes))
        self._waiting_m = np.empty(0)
        self._offered = np.empty(0, dtype=np.int64)
        self._next_m = self._diameter_m()
        self._due_kg = 0.0
        self.fed_kg = 0.0

    @property
    def backlog_kg(self) -> float:
        """Mass that was due at the interval last asked for and is not fed: it grows without
        bound if the rate is larger than the inlet can take."""
        return self._due_kg - self.fed_kg

    def due(self, interval: Interval) -> ParticleList:
        self._due_kg = self._inlet.due_kg(interval.start_s)
        self._draw()
        self._waiting_m = np.sort(self._waiting_m)[::-1]
        center_m, placed = places(self._waiting_m / 2.0, self._inlet.box_m, self._generator, ROUNDS)
        self._offered = np.flatnonzero(placed)
        return self._list(center_m[placed], self._waiting_m[placed])

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        """Raises ValueError if ``accepted`` has not one entry for each particle offered."""
        if len(accepted) != len(self._offered):
            raise ValueError(f"{len(self._offered)} particles offered, {len(accepted)} answers")
        fed = self._offered[accepted]
        self.fed_kg += float(np.sum(mass_kg(self._waiting_m[fed], self._inlet.density_kg_m3)))
        self._waiting_m = np.delete(self._waiting_m, fed)
        self._offered = np.empty(0, dtype=np.int64)

    def _draw(self) -> None:
        drawn_m = []
        while True:
            next_kg = float(mass_kg(self._next_m, self._inlet.density_kg_m3))
            if self._drawn_kg.sum() + next_kg / 2.0 > self._due_kg:
                break
            drawn_m.append(float(self._next_m))
            self._drawn_kg[self._class] += next_kg
            self._next_m = self._diameter_m()
        self._waiting_m = np.append(self._waiting_m, drawn_m)

    def _diameter_m(self) -> Array:
        lag_kg = self._shares * self._drawn_kg.sum() - self._drawn_kg
        self._class = int(np.argmax(lag_kg))
        row = self._inlet.sizes[self._class]
        return np.asarray(self._generator.uniform(row.smallest_m, row.largest_m))

    def _list(self, center_m: Array, diameter_m: Array) -> ParticleList:
        n = len(diameter_m)
        return ParticleList(
            center_m,
            np.tile(np.asarray(self._inlet.velocity_m_s, dtype=float), (n, 1)),
            np.zeros((n, 3)),
            diameter_m.copy(),
            np.full(n, self._inlet.density_kg_m3),
            np.full(n, self._inlet.material, dtype=np.int64),
        )


class Feeds:
    """Several feeds as one."""

    def __init__(self, inlets: Sequence[Inlet]) -> None:
        """Raises ValueError for boxes that overlap: their particles could."""
        for k, first in enumerate(inlets):
            for second in inlets[:k]:
                apart = (first.box_m[1] <= second.box_m[0]) | (second.box_m[1] <= first.box_m[0])
                if not apart.any():
                    raise ValueError(
                        f"feed boxes overlap: {first.box_m.tolist()} and {second.box_m.tolist()}"
                    )
        self.feeds = [RateFeed(inlet) for inlet in inlets]
        self._offered: list[int] = []

    def due(self, interval: Interval) -> ParticleList:
        offers = [feed.due(interval) for feed in self.feeds]
        self._offered = [len(offer) for offer in offers]
        return joined(offers)

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        parts = np.split(accepted, np.cumsum(self._offered)[:-1])
        for feed, part in zip(self.feeds, parts, strict=True):
            feed.settle(part)


def joined(lists: Sequence[ParticleList]) -> ParticleList:
    """One list of at least one list, in order."""
    return ParticleList(
        np.concatenate([one.position_m for one in lists]),
        np.concatenate([one.velocity_m_s for one in lists]),
        np.concatenate([one.spin_rad_s for one in lists]),
        np.concatenate([one.diameter_m for one in lists]),
        np.concatenate([one.density_kg_m3 for one in lists]),
        np.concatenate([one.material for one in lists]),
    )
