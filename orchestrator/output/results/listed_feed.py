"""The feed as it is listed, beside what is computed of it: for how much a grain stands.

A run may compute one in many grains of a size (``sampled_below_m`` of a feed), or give the mass of finer ones
to a class (``finer``).  The mass of a size that the feed lists, over what is computed of it, is the weight of
its grains in all shares of the separation.  docs/theory/screening.md has the definitions.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from orchestrator.case.bed.size_distribution import classes, given_classes, share_between, share_left_out
from orchestrator.case.tables.bed import Feed, SizeClass
from orchestrator.ports import Array

SAME_SIZE = 1e-9  # relative: half the width of a class of one size
ROUNDING = 1e-9  # of weights

Rows = tuple[tuple[SizeClass, float], ...]
"""Size classes, each with its share of the mass of all feeds."""


@dataclass(frozen=True)
class ListedFeed:
    """The classes that the feeds list, ``given``, and those that are computed, ``computed``."""

    given: Rows
    computed: Rows

    def weight(self, size_m: Array) -> Array:
        """Return the mass for which grains of these sizes (n,) stand, over their own."""
        edges_m, weights = self._weights
        place = np.searchsorted(edges_m, size_m, side="right") - 1
        return np.asarray(weights[np.clip(place, 0, len(weights) - 1)])

    @cached_property
    def _weights(self) -> tuple[Array, Array]:
        """The limits of all classes (n + 1,), and the weight between two of them (n,).

        It is 1 where nothing is computed, and where it differs from 1 by rounding only.
        """
        limits_m = {limit_m for row, _ in (*self.given, *self.computed) for limit_m in _limits_m(row)}
        edges_m = np.array(sorted(limits_m))
        given, computed = (
            np.array([mass_between(rows, *edges) for edges in pairwise(edges_m)])
            for rows in (self.given, self.computed)
        )
        weights = np.divide(given, computed, out=np.ones(len(given)), where=computed > 0)
        return edges_m, np.where(np.abs(weights - 1.0) < ROUNDING, 1.0, weights)


def _limits_m(row: SizeClass) -> tuple[float, float]:
    """Return the limits of a class; those of a single size are a little apart."""
    if row.smallest_m < row.largest_m:
        return row.smallest_m, row.largest_m
    return (1 - SAME_SIZE) * row.smallest_m, (1 + SAME_SIZE) * row.smallest_m


def mass_between(rows: Rows, low_m: float, high_m: float) -> float:
    """Return the share of the mass of classes that lies between two sizes."""
    inside = (row for row in rows if row[0].largest_m >= low_m and row[0].smallest_m <= high_m)
    return sum(part * share_between(row, low_m, high_m) for row, part in inside)


def feed_parts(feeds: Sequence[Feed], window_s: tuple[float, float] = (0.0, math.inf)) -> list[float]:
    """Return the share of each feed in what all of them feed in a window of time.

    If they feed nothing then, it is that of what they fed before; if the window has no end, or none has begun
    by then, of their rates.
    """
    start_s, end_s = window_s
    parts = [feed.rate_kg_per_s for feed in feeds]
    for since_s in (0.0, start_s):
        fed_kg = [_fed_kg(feed, since_s, end_s) for feed in feeds]
        parts = fed_kg if 0.0 < sum(fed_kg) < math.inf else parts
    return [part / sum(parts) for part in parts]


def listed_feed(feeds: Sequence[Feed], window_s: tuple[float, float] = (0.0, math.inf)) -> ListedFeed:
    """Return feeds that are mixed by what they feed in a window of time (``feed_parts``)."""
    given: list[tuple[SizeClass, float]] = []
    computed: list[tuple[SizeClass, float]] = []
    for feed, part in zip(feeds, feed_parts(feeds, window_s), strict=True):
        if part:
            comes = part * (1.0 - share_left_out(feed))
            given += [(row, part * row.mass_fraction) for row in given_classes(feed)]
            computed += [(row, comes * row.mass_fraction) for row in classes(feed)]
    return ListedFeed(tuple(given), tuple(computed))


def _fed_kg(feed: Feed, start_s: float, end_s: float) -> float:
    """Return the mass that is due of a feed from one time to another."""
    stop_s = end_s if feed.stop_s is None else min(feed.stop_s, end_s)
    return feed.rate_kg_per_s * max(0.0, stop_s - max(feed.start_s, start_s))
