"""What is recorded of the bed along the deck at output times: ``profile`` and ``held``."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.case.deck.line import DeckLine, deck_line, joined, over
from orchestrator.output.records.deck_profile import profile
from orchestrator.output.records.held import Held
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot


class DeckRecord:
    """Looks at the particles from the deck as it is at that moment; rank 0 only."""

    def __init__(
        self, deck: DeckLine, centre_lines: Sequence[Indices], cycle_s: float, openings_m: Array
    ) -> None:
        """``centre_lines``: the panels' points of the surface; ``openings_m`` (n, 3): the
        openings' centres in the world at t = 0."""
        across = np.array([-deck.along[1], deck.along[0], 0.0])
        station_m = np.interp(openings_m @ deck.along, deck.over_m, deck.station_m)
        self._deck, self._points = deck, joined(deck.panels, centre_lines)
        self.held = Held(cycle_s, across, np.column_stack([station_m, openings_m @ across]))

    def at(
        self, time_s: float, surface: Motion, particles: ParticleSnapshot
    ) -> dict[str, dict[str, Array | float]]:
        """Values by group, to be recorded."""
        line = surface.part(self._points)
        seen = over(self._deck, line.position_m, line.velocity_m_per_s, particles.position_m)
        return {
            "profile": dict(profile(self._deck, particles, seen)),
            "held": dict(self.held.at(time_s, particles, seen)),
        }


def deck_record(
    surface: Motion, centre_lines: Sequence[Indices], cycle_s: float, openings_m: Array
) -> DeckRecord | None:
    """``surface`` at t = 0; None for panels that form no deck (see ``deck_line``)."""
    deck = deck_line([surface.position_m[points] for points in centre_lines])
    return DeckRecord(deck, centre_lines, cycle_s, openings_m) if deck else None
