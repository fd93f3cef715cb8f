"""How long the oversize stays, and where along the deck the undersize passes."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.case.deck.line import DeckLine
from orchestrator.output.records.deck_profile import bins_m
from orchestrator.output.results import placement
from orchestrator.output.results.events import OVERSIZE, UNDERSIZE, per_cycle
from orchestrator.output.results.steady_events import Events
from orchestrator.output.results.transport import passing_kg_per_s_m, residence_s


def transport(events: Events, deck: DeckLine | None) -> dict[str, Any]:
    """Residence of the oversize, and where the undersize passes."""
    removed, counted = events.removed, events.counted
    over = counted & np.isin(removed.exit, events.exits.of(OVERSIZE))
    stay = residence_s(events.fed, removed)
    over &= np.isfinite(stay)
    sums = per_cycle(
        np.tile(removed.time_s[over], 2),
        np.concatenate([(removed.mass_kg * stay)[over], removed.mass_kg[over]]),
        events.edges_s,
        np.repeat([0, 1], int(over.sum())),
        2,
    )
    found: dict[str, Any] = {"residence_s": events.figure(lambda s: placement.share(s[0], s[1]), sums)}
    if deck is not None:
        length = deck.length_m
        found["residence_velocity_m_per_s"] = events.figure(
            lambda s: length * placement.share(s[1], s[0]), sums
        )
        edges = bins_m(deck)
        under = counted & np.isin(removed.exit, events.exits.of(UNDERSIZE))
        station = np.interp(removed.position_m[under] @ deck.along, deck.over_m, deck.station_m)
        found["passing"] = {
            "along_m": (edges[1:] + edges[:-1]) / 2,
            "rate_kg_per_s_m": passing_kg_per_s_m(station, removed.mass_kg[under], edges, events.lasting_s),
        }
    return found
