"""The size of a proposed deck: as many panels as its throughput wants by the factors of VSMA.

``preflight/sheet/area.py`` has the factors; they are a rule, and a run tells what the deck does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.materials.typical_feed import finer_share
from orchestrator.cli.proposal.layout import AROUND_M, openings_of, panel_length_m
from orchestrator.cli.proposal.wishes import QUESTIONS, Wishes, down, problem, up
from orchestrator.preflight.sheet.area import Openings, required_m2
from orchestrator.preflight.sheet.feed_shares import NEAR, FeedShares
from orchestrator.preflight.sheet.sheet import EFFICIENCY, PACKED, RULE

FAR = 3.0  # A deck whose area is smaller by this factor is refused.


def needed_m2_of(wishes: Wishes) -> float | None:
    """Return the area between the clamps that the throughput wants; None without material, and for openings
    of which the rule knows nothing."""
    if not wishes.has_material:
        return None
    pattern, aperture_m = openings_of(wishes), wishes.smaller_m
    half, near, fine, beyond = (
        finer_share(wishes.feed_m, share * aperture_m) for share in (0.5, NEAR[0], 1.0, NEAR[1])
    )
    return required_m2(
        wishes.throughput_kg_per_s,
        Openings(pattern.width_m, pattern.length_m, 1.0 - pattern.solid_share),
        FeedShares(1.0 - fine, half, beyond - near),
        PACKED * wishes.density_kg_per_m3,
        EFFICIENCY,
    )


def deck_m2_of(wishes: Wishes) -> float:
    """Return the area of the panels between their clamps."""
    return wishes.panels * panel_length_m(wishes) * wishes.width_m


def with_enough_panels(wishes: Wishes) -> Wishes:
    """Return wishes without a number of panels and a length with as many panels as the throughput wants.

    There are at least the template's fewest, and no more than a proposal can have.
    """
    needed_m2 = needed_m2_of(wishes)
    if needed_m2 is None or "panels" in wishes.answers or wishes.length_m is not None:
        return wishes
    panels = math.ceil(needed_m2 / (panel_length_m(wishes) * wishes.width_m))
    return replace(wishes, panels=max(wishes.panels, min(panels, _most_panels(wishes))))


def too_small_deck(wishes: Wishes) -> Iterator[CaseProblem]:
    """Yield a problem for a deck that is far too small for its throughput, with what would do."""
    needed_m2, deck_m2 = needed_m2_of(wishes), deck_m2_of(wishes)
    if needed_m2 is None or deck_m2 * FAR >= needed_m2:
        return
    panels = math.ceil(needed_m2 / deck_m2 * wishes.panels)
    if wishes.length_m is not None:
        hint = f"take a --length of {up(wishes.length_m * needed_m2 / deck_m2):g} m with more --panels"
    else:
        hint = f"take {panels} --panels"
    if panels > _most_panels(wishes):
        hint = "take several machines"
    enough = f"{down(3.6 * wishes.throughput_kg_per_s * deck_m2 / needed_m2):g} t/h"
    yield problem(
        "throughput",
        f"the deck of {deck_m2:.3g} m2 is far too small: {3.6 * wishes.throughput_kg_per_s:.4g} t/h need "
        f"{needed_m2:.3g} m2 for {EFFICIENCY:.0%} of the fines by the factors of VSMA ({RULE})",
        f"{hint}, a larger --width or at most {enough}",
    )


def _most_panels(wishes: Wishes) -> int:
    """Return how many panels a proposal can have one after the other."""
    longest_m = QUESTIONS["length"].limits[1]
    pitch_m = panel_length_m(wishes) + AROUND_M
    return min(int(QUESTIONS["panels"].limits[1]), int(longest_m / pitch_m))
