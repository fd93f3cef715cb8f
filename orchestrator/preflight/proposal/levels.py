"""The levels of a proposed case: a cheap draft, and a study.

The draft computes a slice of the width with strips, without the finest particles, whose separation the
results complete (results.screening.whole_feed).  If its predicted cost is too high, it is shorter and leaves
out more of the fines; only then does it feed less than the throughput, and says so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from orchestrator.case.file.slice import ENOUGH_DIAMETERS
from orchestrator.case.tables.case import Case
from orchestrator.ports.clock import times_s
from orchestrator.preflight.cost import particles_at_start, predicted_parts_s
from orchestrator.preflight.proposal.layout import FINEST_COMPUTED, Layout

DRAFT_S = 300.0  # processor time that a draft may take as predicted
CROSSING_M_PER_S = 0.8  # along the deck, for planned durations and times; thrown beds are faster
BALANCED_TURNS = 30  # of the shaft, over which what leaves a draft's deck balances its feed
LONGEST_INTERVAL_S = 2e-4
DRAFT_PA, STUDY_PA = 4e7, 5e7  # In softer contacts, stones press grains half way into each other.
WITHIN = 0.97  # of the longest interval that is stable and accurate
COARSER = (
    (FINEST_COMPUTED, 1.0, 1.0),
    (0.5, 1.0, 1.0),
    (0.6, 1.0, 1.0),
    (0.7, 1.0, 1.0),
    (0.7, 1.0, 0.7),
    (0.8, 1.0, 0.7),
    (0.8, 1.0, 0.5),
    (0.8, 0.5, 0.5),
    (0.8, 0.25, 0.5),
    (0.8, 0.1, 0.5),
)
"""Finest diameter over the smaller side of the openings, share of the throughput, and share of the time
that a steady state takes, from the best draft down."""
COARSE_CELLS, FINE_CELLS = (24, 0.0125), (22, 0.018)
"""Cells along a panel: at least so many, and their largest length."""


@dataclass(frozen=True)
class Level:
    """The settings of a level.

    ``slice_m`` is None if the whole width is computed, and ``smallest_fed_m`` if all sizes are.
    """

    about: str
    duration_s: float
    slice_m: float | None
    interval_s: float
    youngs_modulus_Pa: float
    smallest_fed_m: float | None
    rate_share: float
    cycle_s: float
    output_s: float

    def with_interval(self, longest_s: float) -> Level:
        """Return the level with the longest sync interval up to ``longest_s`` that divides a quarter turn.

        It is rounded up to six digits, so that whole numbers of intervals can be written without rounding.
        """
        quarter_s = self.cycle_s / 4
        interval_s = quarter_s / math.ceil(quarter_s / longest_s - 1e-9)
        digits = 10 ** (5 - math.floor(math.log10(interval_s)))
        return replace(self, interval_s=math.ceil(interval_s * digits - 1e-6) / digits)

    @property
    def changes_feed(self) -> bool:
        """Whether the level feeds less or coarser material than the case."""
        return self.rate_share < 1 or self.smallest_fed_m is not None

    @property
    def feed_interval_s(self) -> float:
        """The time between two batches of the feed, a whole number of sync intervals."""
        return times_s(round(0.002 / self.interval_s), self.interval_s)

    @property
    def series_s(self) -> float:
        """The time between two rows of the time series, a whole number of sync intervals."""
        return times_s(max(1, int(4e-4 / self.interval_s + 1e-6)), self.interval_s)


def predicted_s(case: Case) -> float:
    """Return the processor time of a run of a proposed case whose bed moves as planned.

    ``flipflow check`` gives the range from a thin bed to a thick one.
    """
    return sum(predicted_parts_s(case, particles_at_start(case), CROSSING_M_PER_S).values())


def cells(layout: Layout, kind: tuple[int, float]) -> int:
    """Return the number of cells along a panel, more for a long one, so that none is too slender."""
    fewest, longest_m = kind
    return max(fewest, round(layout.panel_m / longest_m))


def drafts(layout: Layout) -> Iterator[Level]:
    """Yield drafts, from the best to the cheapest."""
    for finest, share, lasting in COARSER:
        turning = "frames that do not turn" if layout.wishes.is_free else "prescribed frames"
        about = f"strips, {turning}, a slice of the width, without particles below {finest:g} of the openings"
        if share < 1:
            about = f"{share:.0%} of the throughput, {about}"
        if lasting < 1:
            about += ", too short for a steady state"
        yield _level(
            layout,
            about=about,
            duration_s=lasting * (steady_s(layout) + BALANCED_TURNS * cycle_s(layout)),
            youngs_modulus_Pa=DRAFT_PA,
            smallest_fed_m=round(finest * layout.wishes.smaller_m, 9),
            rate_share=share,
        )


def study(layout: Layout) -> Level:
    """Return the level with finite elements, frames that turn and as fine a feed as is computed."""
    turning = "frames that turn" if layout.wishes.is_free else "prescribed frames"
    finest_m = round(FINEST_COMPUTED * layout.wishes.smaller_m, 9)
    is_whole = layout.wishes.feed_m[0][0] >= finest_m
    sizes = "the whole feed" if is_whole else f"particles from {FINEST_COMPUTED:g} of the openings up"
    about = f"sheets of finite elements, {turning}, {sizes} on a slice of the width"
    return _level(
        layout,
        about=about,
        duration_s=3 * steady_s(layout),
        youngs_modulus_Pa=STUDY_PA,
        smallest_fed_m=None if is_whole else finest_m,
        rate_share=1.0,
    )


def cycle_s(layout: Layout) -> float:
    """Return the time of a turn of the shaft."""
    return 2 * math.pi / layout.wishes.speed_rad_per_s


def steady_s(layout: Layout) -> float:
    """Return the time in which the feed crosses the deck, with a second for the start and the fall."""
    return (layout.length_m + layout.chute_length_m) / CROSSING_M_PER_S + 1.0


def _level(layout: Layout, duration_s: float, **settings: Any) -> Level:
    """Return a level that lasts ten turns longer than ``duration_s``, with outputs at four phases."""
    turn_s = cycle_s(layout)
    level = Level(
        duration_s=(math.ceil(duration_s / turn_s) + 10) * turn_s,
        slice_m=_slice_m(layout),
        interval_s=LONGEST_INTERVAL_S,
        cycle_s=turn_s,
        output_s=0.75 * turn_s,
        **settings,
    )
    return level.with_interval(LONGEST_INTERVAL_S)


def _slice_m(layout: Layout) -> float | None:
    """Return the width of ``ENOUGH_DIAMETERS`` of the largest particles, in whole pitches of the openings.

    Return None if this is not less than the deck's width between its margins.
    """
    openings, width_m = layout.openings, layout.wishes.width_m
    pitches = math.ceil(ENOUGH_DIAMETERS * layout.largest_m / openings.pitch_across_m + 1e-9)
    slice_m = pitches * openings.pitch_across_m
    return round(slice_m, 9) if slice_m < width_m - 2 * openings.margin_across_m else None
