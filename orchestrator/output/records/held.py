"""Particles that do not leave the panel although it shakes: stickers, and pegs in openings."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from orchestrator.case.deck.line import Over
from orchestrator.ports import Array, Indices, ParticleSnapshot, Saved
from orchestrator.ports.state import put_back, taken

Mask = npt.NDArray[np.bool_]
HELD_CYCLES = 5
NEAR = 0.25  # diameters between panel and particle that still count as lying on it
STAYS = 0.5  # diameters along and across that still count as the same place
SEATED = 0.75  # radii from centre to surface that only an opening allows
GRAVITY_M_PER_S2 = 9.81
_STATE = ("_id", "_anchor_m", "_since_s", "_fastest_m_per_s")


class Held:
    """Follows every particle from one output time to the next.

    Held is a particle that for ``HELD_CYCLES`` cycles lay on the panel, at the same place of its
    material, while the panel under it was accelerated by more than gravity (its fastest speed
    along its normal times the cycle's angular speed).
    """

    def __init__(self, cycle_s: float, across: Array, openings_m: Array) -> None:
        """``across`` (3,): horizontal unit vector across the deck; ``openings_m`` (openings, 2):
        station and place across of every opening's centre."""
        self._cycle_s, self._across = cycle_s, across
        self._openings = KDTree(openings_m) if len(openings_m) else None
        self._id: Indices = np.empty(0, dtype=np.int64)
        self._anchor_m = np.empty((0, 2))
        self._since_s, self._fastest_m_per_s = np.empty(0), np.empty(0)

    def at(self, time_s: float, particles: ParticleSnapshot, seen: Over) -> dict[str, float]:
        """``stickers`` and their ``mass_kg``; ``openings`` that hold a particle.  Particles are
        sorted by id."""
        place = np.column_stack([seen.station_m, particles.position_m @ self._across])
        radius = particles.diameter_m / 2
        lies = seen.inside & (np.abs(seen.height_m) < radius * (1 + 2 * NEAR))
        old, known = self._row(particles.id)
        moved = np.abs(place - self._anchor_m[old]).max(axis=1) if len(self._id) else radius
        stays = known & lies & (moved < 2 * STAYS * radius)
        self._since_s = np.where(stays, self._then(self._since_s, old), time_s)
        self._anchor_m = np.where(stays[:, None], self._then(self._anchor_m, old), place)
        fastest = np.where(stays, self._then(self._fastest_m_per_s, old), 0.0)
        self._fastest_m_per_s = np.maximum(fastest, np.abs(seen.rise_m_per_s))
        self._id = particles.id
        held = stays & (time_s - self._since_s >= HELD_CYCLES * self._cycle_s)
        held &= self._fastest_m_per_s * 2 * np.pi / self._cycle_s > GRAVITY_M_PER_S2
        mass = np.pi / 6 * particles.density_kg_per_m3 * particles.diameter_m**3
        return {
            "stickers": float(held.sum()),
            "mass_kg": float(mass[held].sum()),
            "openings": float(self._blinded(place[held & (seen.height_m < SEATED * radius)])),
        }

    def save(self) -> Saved:
        return taken(self, *_STATE)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_STATE)

    def _row(self, ids: Indices) -> tuple[Indices, Mask]:
        """Row of each particle at the last time, and whether it was there."""
        if not len(self._id):
            return np.zeros(len(ids), dtype=int), np.zeros(len(ids), dtype=bool)
        row = np.minimum(np.searchsorted(self._id, ids), len(self._id) - 1)
        return row, self._id[row] == ids

    def _then(self, values: Array, row: Indices) -> Array:
        return values[row] if len(values) else np.zeros((len(row), *values.shape[1:]))

    def _blinded(self, place_m: Array) -> int:
        if self._openings is None or not len(place_m):
            return 0
        return len(np.unique(self._openings.query(place_m)[1]))
