"""The levels of a proposed case: a cheap draft, and a study.

The draft computes a slice of the width with strips.  Of the fines, it computes a sample, and leaves out the
finest, whose separation the results complete (results.screening.whole_feed).  If its predicted cost is too
high, it computes less of the fines and is shorter; only then does it feed less than the throughput, and says
so.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.file.slice import ENOUGH_DIAMETERS
from orchestrator.case.materials.typical_feed import finer_share
from orchestrator.case.tables.case import Case
from orchestrator.cli.proposal.layout import FINEST_COMPUTED, Layout
from orchestrator.ports.clock import times_s
from orchestrator.preflight.cost import particles_at_start, predicted_parts_s

DRAFT_S = 500.0  # processor time that a draft may take as predicted, which is some 1.7 times what it takes
CROSSING_M_PER_S = 0.8  # along the deck, for planned durations and times; thrown beds are faster
BALANCED_TURNS = 30  # of the shaft, over which what leaves a draft's deck balances its feed
LONGEST_INTERVAL_S = 2e-4
DRAFT_PA, STUDY_PA = 6e7, 6e7  # In softer contacts, stones press grains half way into each other or the mat.
WITHIN = 0.97  # of the longest interval that is stable and accurate
COARSER = (
    (FINEST_COMPUTED, 0.5, 1.0, 1.0),
    (FINEST_COMPUTED, 0.6, 1.0, 1.0),
    (FINEST_COMPUTED, 0.7, 1.0, 1.0),
    (0.35, 0.7, 1.0, 1.0),
    (0.5, 0.7, 1.0, 1.0),
    (0.7, 0.7, 1.0, 1.0),
    (0.7, 0.7, 1.0, 0.7),
    (0.8, 0.8, 1.0, 0.7),
    (0.8, 0.8, 1.0, 0.5),
    (0.8, 0.8, 0.5, 0.5),
    (0.8, 0.8, 0.25, 0.5),
    (0.8, 0.8, 0.1, 0.5),
)
"""Finest diameter that is computed, and that from which on all particles are, over the smaller side of the
openings; share of the throughput, and of the time that a steady state takes, from the best draft down."""
STUDY_WHOLE = 0.4
"""The diameter from which on a study computes all particles, over the smaller side of the openings."""
SAMPLE_CLASS, SAMPLE_GRAINS = 1.2, 100
"""Of a size class with limits of this ratio, so many sampled particles come in the time over which a draft is
balanced: a share of them has a standard error of 5 points or less."""
COARSE_CELLS, FINE_CELLS = (24, 0.0125), (22, 0.018)
"""Cells along a panel: at least so many, and their largest length."""


@dataclass(frozen=True)
class Level:
    """The settings of a level.

    ``slice_m`` is None if the whole width is computed, and ``smallest_fed_m`` if all sizes are.
    ``sampled_below_m`` is None if no particles are sampled, else there are as many as if all of them had the
    diameter ``sampled_as_m``.
    """

    about: str
    duration_s: float
    slice_m: float | None
    interval_s: float
    youngs_modulus_Pa: float
    smallest_fed_m: float | None
    sampled_below_m: float | None
    sampled_as_m: float | None
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
        return self.rate_share < 1 or self.smallest_fed_m is not None or self.sampled_below_m is not None

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
    for finest, whole, share, lasting in COARSER:
        turning = "frames that do not turn" if layout.wishes.is_free else "prescribed frames"
        about = f"strips, {turning}, a slice of the width, {_sizes_in_words(layout, finest, whole)}"
        if share < 1:
            about = f"{share:.0%} of the throughput, {about}"
        if lasting < 1:
            about += ", too short for a steady state"
        yield _level(
            layout,
            about=about,
            duration_s=lasting * (steady_s(layout) + BALANCED_TURNS * cycle_s(layout)),
            youngs_modulus_Pa=DRAFT_PA,
            rate_share=share,
            sizes=(finest, whole),
        )


def study(layout: Layout) -> Level:
    """Return the level with finite elements, frames that turn and as fine a feed as is computed."""
    turning = "frames that turn" if layout.wishes.is_free else "prescribed frames"
    sizes = FINEST_COMPUTED, STUDY_WHOLE
    about = f"sheets of finite elements, {turning}, a slice of the width, {_sizes_in_words(layout, *sizes)}"
    return _level(
        layout,
        about=about,
        duration_s=3 * steady_s(layout),
        youngs_modulus_Pa=STUDY_PA,
        rate_share=1.0,
        sizes=sizes,
    )


def _sizes_in_words(layout: Layout, finest: float, whole: float) -> str:
    """Return which sizes are computed, by their ends over the smaller side of the openings."""
    finest_m = layout.wishes.feed_m[0][0]
    if finest_m >= whole * layout.wishes.smaller_m:
        return "the whole feed"
    if whole == finest:
        return f"without particles below {finest:g} of the openings"
    if finest_m >= finest * layout.wishes.smaller_m:
        return f"a sample of the particles below {whole:g} of the openings"
    return f"a sample of the particles from {finest:g} to {whole:g} of the openings, without finer ones"


def sampled_as_m(layout: Layout, finest_m: float, below_m: float) -> float:
    """Return the diameter of particles of which there would be as many as are sampled (``SAMPLE_GRAINS``).

    It is that of which the class with the least mass has so many, and at least ``below_m``.
    """
    wishes = layout.wishes
    classes = math.ceil(math.log(below_m / finest_m) / math.log(SAMPLE_CLASS) - 1e-9)
    passing = [finer_share(wishes.feed_m, float(m)) for m in np.geomspace(finest_m, below_m, classes + 1)]
    shares = [share for share in np.diff(passing) if share > 0]
    part = (_slice_m(layout) or wishes.width_m) / wishes.width_m
    balanced_kg = wishes.throughput_kg_per_s * part * BALANCED_TURNS * cycle_s(layout)
    each_kg = balanced_kg * min(shares, default=0.0) / SAMPLE_GRAINS
    size_m = (each_kg / wishes.density_kg_per_m3 / solvers.shape("sphere").volume) ** (1 / 3)
    return max(below_m, round(float(size_m), 4))


def cycle_s(layout: Layout) -> float:
    """Return the time of a turn of the shaft."""
    return 2 * math.pi / layout.wishes.speed_rad_per_s


def steady_s(layout: Layout) -> float:
    """Return the time in which the feed crosses the deck, with a second for the start and the fall."""
    return (layout.length_m + layout.chute_length_m) / CROSSING_M_PER_S + 1.0


def _level(layout: Layout, duration_s: float, sizes: tuple[float, float], **settings: Any) -> Level:
    """Return a level that lasts ten turns longer than ``duration_s``, with outputs at four phases.

    ``sizes`` are the finest diameter that is computed, and that from which on all particles are, over the
    smaller side of the openings.
    """
    turn_s, feed_m = cycle_s(layout), layout.wishes.feed_m
    finest_m, whole_m = (round(size * layout.wishes.smaller_m, 9) for size in sizes)
    starts_m = max(finest_m, feed_m[0][0])
    is_sampled = starts_m < whole_m <= feed_m[-1][0]
    level = Level(
        duration_s=(math.ceil(duration_s / turn_s) + 10) * turn_s,
        slice_m=_slice_m(layout),
        interval_s=LONGEST_INTERVAL_S,
        cycle_s=turn_s,
        output_s=0.75 * turn_s,
        smallest_fed_m=finest_m if feed_m[0][0] < finest_m else None,
        sampled_below_m=whole_m if is_sampled else None,
        sampled_as_m=sampled_as_m(layout, starts_m, whole_m) if is_sampled else None,
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
