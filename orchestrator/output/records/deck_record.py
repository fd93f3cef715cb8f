"""The records of the bed along the deck at output times: the groups ``profile`` and ``held``."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
import numpy.typing as npt
from scipy.spatial import KDTree

from orchestrator.case.deck.line import DeckLine, DeckPlaces, join_lines, locate
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.state import SavedAttributes

Mask = npt.NDArray[np.bool_]
BINS_PER_PANEL = 4
DEPTH_SHARE = 0.95  # share of a bin's mass that lies below the bed depth
HELD_CYCLES = 5
NEAR = 0.25  # diameters: largest gap between panel and particle that counts as lying on the panel
STAYS = 0.5  # diameters: largest motion along or across that counts as the same place
LOOSE = 0.1  # of the panel's largest speed along its normal: so fast, a retained particle goes against it
THROWS = 1.25  # times gravity: acceleration of the panel that tells retained particles from loose ones
SEATED = 0.75  # radii: a centre no farther above the upper side or below the lower one sits in an opening


def bins_m(deck: DeckLine) -> Array:
    """Return the edges (bins + 1,) of the bins along the deck, in m."""
    return np.linspace(0.0, deck.length_m, BINS_PER_PANEL * len(deck.panels) + 1)


def on_deck(particles: ParticleSnapshot, places: DeckPlaces) -> Mask:
    """Return whether each particle is over the deck, in an opening, or at most one radius below the deck."""
    return np.asarray(places.inside & (places.under_m > -particles.grains.bounding_radius_m))


def is_near(places: DeckPlaces, distance_m: Array) -> Mask:
    """Return whether places are nearer than ``distance_m`` (n,) above the upper and below the lower side."""
    return np.asarray((places.height_m < distance_m) & (places.under_m > -distance_m))


def compute_profile(deck: DeckLine, particles: ParticleSnapshot, places: DeckPlaces) -> dict[str, Array]:
    """Return the bins' middles ``along_m``, their ``mass_kg``, ``velocity_m_per_s`` and ``depth_m``.

    The velocity is the mean by mass along the deck's slope at t = 0.  The depth is the height over the
    surface below which 95 % of the mass lie, where the height of a particle is the height of its top.
    Velocity and depth are NaN in an empty bin.
    """
    edges = bins_m(deck)
    there = on_deck(particles, places)
    mass = particles.grains.mass_kg[there]
    number = np.clip(np.searchsorted(edges, places.station_m[there]) - 1, 0, len(edges) - 2)
    top = (places.height_m + particles.grains.bounding_radius_m)[there]
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
    """Return the speed of each particle along the slope of its bin at t = 0."""
    edges = bins_m(deck)
    run, climb = (np.diff(np.interp(edges, deck.station_m, place)) for place in (deck.over_m, deck.level_m))
    slope = np.column_stack([run, climb]) / np.hypot(run, climb)[:, None]
    along = np.column_stack([velocity_m_per_s @ deck.along, velocity_m_per_s[:, 2]])
    return np.asarray((along * slope[number]).sum(axis=1))


def _percentile(height_m: Array, mass_kg: Array, number: Array, bins: int) -> Array:
    """Return the height (bins,) below which ``DEPTH_SHARE`` of a bin's mass lies; NaN in an empty bin."""
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
    """A record of the retained particles, which follows every particle from one output time to the next.

    A particle is retained, by adhesion or wedged in an opening, if it has lain on the panel for
    ``HELD_CYCLES`` cycles, at the same place of its material, and has moved with it, while the panel's
    acceleration under it would throw a loose one.  The acceleration is the panel's largest speed along its
    normal times the cycle's angular speed.  At ``THROWS`` times gravity, a loose particle flies from a
    harmonic motion with up to a sixth of the panel's largest speed: whoever goes by more than ``LOOSE`` of it
    against the panel is hopping, however low.
    """

    STATE: ClassVar = ("_id", "_anchor_m", "_since_s", "_fastest_m_per_s")

    def __init__(self, cycle_s: float, across: Array, openings_m: Array) -> None:
        """Set the horizontal unit vector ``across`` (3,) the deck, and the ``openings_m`` (openings, 2).

        The latter hold the station and the place across the deck of every opening's centre.
        """
        self._cycle_s, self._across = cycle_s, across
        self._openings = KDTree(openings_m) if len(openings_m) else None
        self._id: Indices = np.empty(0, dtype=np.int64)
        self._anchor_m = np.empty((0, 2))
        self._since_s, self._fastest_m_per_s = np.empty(0), np.empty(0)

    def at(self, time_s: float, particles: ParticleSnapshot, places: DeckPlaces) -> dict[str, float]:
        """Return the number of ``stickers``, their ``mass_kg``, and the number of ``openings`` that hold one.

        ``pegged_kg`` is the mass of those of them that openings hold.  The particles must be sorted by id.
        """
        place = np.column_stack([places.station_m, particles.position_m @ self._across])
        radius = particles.grains.bounding_radius_m
        lies = places.inside & is_near(places, radius * (1 + 2 * NEAR))
        old, known = self._previous_rows(particles.id)
        moved = np.abs(place - self._anchor_m[old]).max(axis=1) if len(self._id) else radius
        fastest = self._previous_values(self._fastest_m_per_s, old)
        fastest = np.maximum(np.where(known, fastest, 0.0), np.abs(places.rise_m_per_s))
        gravity_m_per_s = STANDARD_GRAVITY_M_PER_S2 * self._cycle_s / (2 * np.pi)
        rises_m_per_s = np.einsum("ij,ij->i", particles.velocity_m_per_s, places.normal)
        against_m_per_s = np.abs(rises_m_per_s - places.rise_m_per_s)
        hops = against_m_per_s > LOOSE * np.maximum(fastest, gravity_m_per_s)
        stays = known & lies & ~hops & (moved < 2 * STAYS * radius)
        self._since_s = np.where(stays, self._previous_values(self._since_s, old), time_s)
        self._anchor_m = np.where(stays[:, None], self._previous_values(self._anchor_m, old), place)
        self._fastest_m_per_s = np.where(stays, fastest, np.abs(places.rise_m_per_s))
        self._id = particles.id
        retained = stays & (time_s - self._since_s >= HELD_CYCLES * self._cycle_s)
        retained &= self._fastest_m_per_s > THROWS * gravity_m_per_s
        mass = particles.grains.mass_kg
        seated = retained & is_near(places, SEATED * radius) & (self._openings is not None)
        blinded = self._openings.query(place[seated])[1] if self._openings is not None else []
        return {
            "stickers": float(retained.sum()),
            "mass_kg": float(mass[retained].sum()),
            "pegged_kg": float(mass[seated].sum()),
            "openings": float(len(np.unique(blinded))),
        }

    def _previous_rows(self, ids: Indices) -> tuple[Indices, Mask]:
        """Return the row of each particle at the previous time, and whether it was present then."""
        if not len(self._id):
            return np.zeros(len(ids), dtype=int), np.zeros(len(ids), dtype=bool)
        row = np.minimum(np.searchsorted(self._id, ids), len(self._id) - 1)
        return row, self._id[row] == ids

    def _previous_values(self, values: Array, row: Indices) -> Array:
        return values[row] if len(values) else np.zeros((len(row), *values.shape[1:]))


class DeckRecord:
    """A record of the bed in the coordinates of the moving deck; it exists on rank 0 only."""

    def __init__(
        self, deck: DeckLine, centre_lines: Sequence[Indices], cycle_s: float, openings_m: Array
    ) -> None:
        """Set the ``centre_lines``, point numbers of the surface by panel, and the ``openings_m`` (n, 3).

        The latter are the centres of the openings in the world at t = 0.
        """
        across = np.array([-deck.along[1], deck.along[0], 0.0])
        station_m = np.interp(openings_m @ deck.along, deck.over_m, deck.station_m)
        self._deck, self._points = deck, join_lines(deck.panels, centre_lines)
        self.retained = RetainedParticles(cycle_s, across, np.column_stack([station_m, openings_m @ across]))

    def at(
        self, time_s: float, surface: Motion, particles: ParticleSnapshot
    ) -> dict[str, dict[str, Array | float]]:
        """Return the values of the groups ``profile`` and ``held`` at a time."""
        line = surface.part(self._points)
        places = locate(self._deck, line.position_m, line.velocity_m_per_s, particles.position_m)
        return {
            "profile": dict(compute_profile(self._deck, particles, places)),
            "held": dict(self.retained.at(time_s, particles, places)),
        }
