"""The bed along the deck at one moment: mass, velocity and depth in bins."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from orchestrator.case.deck.line import DeckLine, Over
from orchestrator.ports import Array, ParticleSnapshot

BINS_PER_PANEL = 4
DEPTH_SHARE = 0.95  # of a bin's mass lies below the bed depth


def bins_m(deck: DeckLine) -> Array:
    """(bins + 1,) edges along the deck."""
    return np.linspace(0.0, deck.length_m, BINS_PER_PANEL * len(deck.panels) + 1)


def on_deck(particles: ParticleSnapshot, seen: Over) -> npt.NDArray[np.bool_]:
    """Whether each particle is over the deck, or not deeper in it than its own radius."""
    return np.asarray(seen.inside & (seen.height_m > -0.5 * particles.diameter_m))


def profile(deck: DeckLine, particles: ParticleSnapshot, seen: Over) -> dict[str, Array]:
    """By bin: ``mass_kg``, the mass-weighted ``velocity_m_per_s`` along the deck (as it slopes at
    t = 0) and ``depth_m``, the height over the surface below which 95 % of the mass lie, each
    particle reaching to its top; velocity and depth are NaN in an empty bin.  ``along_m`` is the
    bins' middle."""
    edges = bins_m(deck)
    there = on_deck(particles, seen)
    mass = np.pi / 6 * (particles.diameter_m**3 * particles.density_kg_per_m3)[there]
    number = np.clip(np.searchsorted(edges, seen.station_m[there]) - 1, 0, len(edges) - 2)
    top = (seen.height_m + 0.5 * particles.diameter_m)[there]
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
    """Speed along the deck's slope at t = 0 in each particle's bin."""
    edges = bins_m(deck)
    run, climb = (np.diff(np.interp(edges, deck.station_m, place)) for place in (deck.over_m, deck.level_m))
    slope = np.column_stack([run, climb]) / np.hypot(run, climb)[:, None]
    along = np.column_stack([velocity_m_per_s @ deck.along, velocity_m_per_s[:, 2]])
    return np.asarray((along * slope[number]).sum(axis=1))


def _percentile(height_m: Array, mass_kg: Array, number: Array, bins: int) -> Array:
    """(bins,) height below which ``DEPTH_SHARE`` of a bin's mass lie; NaN where it is empty."""
    found = np.full(bins, np.nan)
    order = np.lexsort((height_m, number))
    starts = np.searchsorted(number[order], np.arange(bins + 1))
    for i in range(bins):
        mine = order[starts[i] : starts[i + 1]]
        if len(mine):
            share = np.cumsum(mass_kg[mine])
            found[i] = height_m[mine[np.searchsorted(share, DEPTH_SHARE * share[-1] * (1 - 1e-12))]]
    return found
