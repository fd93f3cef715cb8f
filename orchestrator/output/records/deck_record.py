"""What is recorded of the bed along the deck at output times: ``profile`` and ``held``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from orchestrator.case.deck.line import DeckLine, Over, join_lines, over
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2, sphere_mass_kg
from orchestrator.ports.state import SavedAttributes

Mask = npt.NDArray[np.bool_]
BINS_PER_PANEL = 4
DEPTH_SHARE = 0.95  # of a bin's mass lies below the bed depth
HELD_CYCLES = 5
NEAR = 0.25  # diameters between panel and particle that still count as lying on it
STAYS = 0.5  # diameters along and across that still count as the same place
SEATED = 0.75  # radii from centre to surface that only an opening allows


def bins_m(deck: DeckLine) -> Array:
    """Return (bins + 1,) edges along the deck."""
    return np.linspace(0.0, deck.length_m, BINS_PER_PANEL * len(deck.panels) + 1)


def on_deck(particles: ParticleSnapshot, places: Over) -> Mask:
    """Return whether each particle is over the deck, or not deeper in it than its own radius."""
    return np.asarray(places.inside & (places.height_m > -0.5 * particles.diameter_m))


def compute_profile(deck: DeckLine, particles: ParticleSnapshot, places: Over) -> dict[str, Array]:
    """Return, by bin, ``mass_kg``, the mass-weighted ``velocity_m_per_s`` along the deck (as it slopes at
    t = 0) and ``depth_m``, the height over the surface below which 95 % of the mass lie, each particle
    reaching to its top; velocity and depth are NaN in an empty bin.  ``along_m`` is the bins' middle."""
    edges = bins_m(deck)
    there = on_deck(particles, places)
    mass = sphere_mass_kg(particles.diameter_m, particles.density_kg_per_m3)[there]
    number = np.clip(np.searchsorted(edges, places.station_m[there]) - 1, 0, len(edges) - 2)
    top = (places.height_m + 0.5 * particles.diameter_m)[there]
    bins = len(edges) - 1
    total = np.bincount(number, mass, bins)
    momentum = np.bincount(number, mass * _speed(deck, particles.velocity_m_per_s[there], number), bins)
    empty = total == 0
    return {
        "along_m": (edges[1:] + edges[:-1]) / 2,
        "mass_kg": total,
        "velocity_m_per_s": np.where(empty, np.nan, momentum / np.where(empty, 1.0, total)),
        "depth_m": _percentile(top, mass, number, bins),
    }


def _speed(deck: DeckLine, velocity_m_per_s: Array, number: Array) -> Array:
    """Return the speed along the deck's slope at t = 0 in each particle's bin."""
    edges = bins_m(deck)
    run, climb = (np.diff(np.interp(edges, deck.station_m, place)) for place in (deck.over_m, deck.level_m))
    slope = np.column_stack([run, climb]) / np.hypot(run, climb)[:, None]
    along = np.column_stack([velocity_m_per_s @ deck.along, velocity_m_per_s[:, 2]])
    return np.asarray((along * slope[number]).sum(axis=1))


def _percentile(height_m: Array, mass_kg: Array, number: Array, bins: int) -> Array:
    """Return the (bins,) height below which ``DEPTH_SHARE`` of a bin's mass lie; NaN where it is empty."""
    depth_m = np.full(bins, np.nan)
    order = np.lexsort((height_m, number))
    starts = np.searchsorted(number[order], np.arange(bins + 1))
    for i in range(bins):
        mine = order[starts[i] : starts[i + 1]]
        if len(mine):
            share = np.cumsum(mass_kg[mine])
            depth_m[i] = height_m[mine[np.searchsorted(share, DEPTH_SHARE * share[-1] * (1 - 1e-12))]]
    return depth_m


class RetainedParticles(SavedAttributes):
    """Follows every particle from one output time to the next.

    A retained particle is one that for ``HELD_CYCLES`` cycles lay on the panel, at the same place of its
    material, while the panel under it was accelerated by more than gravity (its fastest speed
    along its normal times the cycle's angular speed).
    """

    STATE: ClassVar = ("_id", "_anchor_m", "_since_s", "_fastest_m_per_s")

    def __init__(self, cycle_s: float, across: Array, openings_m: Array) -> None:
        """Take ``across`` (3,), the horizontal unit vector across the deck, and ``openings_m``
        (openings, 2), station and place across of every opening's centre."""
        self._cycle_s, self._across = cycle_s, across
        self._openings = KDTree(openings_m) if len(openings_m) else None
        self._id: Indices = np.empty(0, dtype=np.int64)
        self._anchor_m = np.empty((0, 2))
        self._since_s, self._fastest_m_per_s = np.empty(0), np.empty(0)

    def at(self, time_s: float, particles: ParticleSnapshot, places: Over) -> dict[str, float]:
        """Return the number of ``stickers`` and their ``mass_kg``; ``openings`` that hold a particle.
        Particles are sorted by id."""
        place = np.column_stack([places.station_m, particles.position_m @ self._across])
        radius = particles.diameter_m / 2
        lies = places.inside & (np.abs(places.height_m) < radius * (1 + 2 * NEAR))
        old, known = self._row(particles.id)
        moved = np.abs(place - self._anchor_m[old]).max(axis=1) if len(self._id) else radius
        stays = known & lies & (moved < 2 * STAYS * radius)
        self._since_s = np.where(stays, self._then(self._since_s, old), time_s)
        self._anchor_m = np.where(stays[:, None], self._then(self._anchor_m, old), place)
        fastest = np.where(stays, self._then(self._fastest_m_per_s, old), 0.0)
        self._fastest_m_per_s = np.maximum(fastest, np.abs(places.rise_m_per_s))
        self._id = particles.id
        held = stays & (time_s - self._since_s >= HELD_CYCLES * self._cycle_s)
        held &= self._fastest_m_per_s * 2 * np.pi / self._cycle_s > STANDARD_GRAVITY_M_PER_S2
        mass = sphere_mass_kg(particles.diameter_m, particles.density_kg_per_m3)
        seated_m = place[held & (places.height_m < SEATED * radius)]
        blinded = self._openings.query(seated_m)[1] if self._openings is not None else []
        return {
            "stickers": float(held.sum()),
            "mass_kg": float(mass[held].sum()),
            "openings": float(len(np.unique(blinded))),
        }

    def _row(self, ids: Indices) -> tuple[Indices, Mask]:
        """Return the row of each particle at the last time, and whether it was there."""
        if not len(self._id):
            return np.zeros(len(ids), dtype=int), np.zeros(len(ids), dtype=bool)
        row = np.minimum(np.searchsorted(self._id, ids), len(self._id) - 1)
        return row, self._id[row] == ids

    def _then(self, values: Array, row: Indices) -> Array:
        return values[row] if len(values) else np.zeros((len(row), *values.shape[1:]))


class DeckRecord:
    """Looks at the particles from the deck as it is at that moment; rank 0 only."""

    def __init__(
        self, deck: DeckLine, centre_lines: Sequence[Indices], cycle_s: float, openings_m: Array
    ) -> None:
        """Take ``centre_lines``, the panels' points of the surface, and ``openings_m`` (n, 3), the
        openings' centres in the world at t = 0."""
        across = np.array([-deck.along[1], deck.along[0], 0.0])
        station_m = np.interp(openings_m @ deck.along, deck.over_m, deck.station_m)
        self._deck, self._points = deck, join_lines(deck.panels, centre_lines)
        self.held = RetainedParticles(cycle_s, across, np.column_stack([station_m, openings_m @ across]))

    def at(
        self, time_s: float, surface: Motion, particles: ParticleSnapshot
    ) -> dict[str, dict[str, Array | float]]:
        """Return values by group, to be recorded."""
        line = surface.part(self._points)
        places = over(self._deck, line.position_m, line.velocity_m_per_s, particles.position_m)
        return {
            "profile": dict(compute_profile(self._deck, particles, places)),
            "held": dict(self.held.at(time_s, particles, places)),
        }
