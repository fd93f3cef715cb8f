"""Karra's model of a vibrating screen: its capacity, the size of which half passes, and what passes.

The undersize per area over the product of seven factors gives the cut size; the factors take apertures in
mm and shares in per cent.  V. K. Karra, CIM Bulletin 72, April 1979, 167-171; docs/designers-sheet.md says
from which copies the constants were read.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from orchestrator.case.tables.bed import SizeClass
from orchestrator.ports import Array
from orchestrator.preflight.sheet.area import Openings
from orchestrator.preflight.sheet.feed_shares import FeedShares, shares_at

STANDARD_KG_PER_M3 = 1602.0
SMALLEST_MM = 1.0  # throughfall aperture from which on the basic capacity is taken
PER_TH = 1.0 / 3.6  # kg/s
FAR = 50.8  # mm: from here on the basic capacity is another straight line
SHARPNESS = 5.846
PARTS = 100  # into which what is finer than the openings is cut


@dataclass(frozen=True)
class KarraScreen:
    """What the model says of a screen.

    ``capacity_kg_per_m2_s`` is the undersize per area with which d50 is the throughfall aperture, and
    ``d50_m`` the size of which half passes at the load that there is.  ``passing`` is the share of what is
    finer than the openings that passes.
    """

    throughfall_m: float
    capacity_kg_per_m2_s: float
    load_kg_per_m2_s: float
    d50_m: float
    passing: float


def karra_screen(
    fed_kg_per_m2_s: float,
    openings: Openings,
    thickness_m: float,
    slope_rad: float,
    rows: Sequence[SizeClass],
    bulk_kg_per_m3: float,
) -> KarraScreen | None:
    """Return what the model says about a top deck without sprays; None for openings below its range.

    ``rows`` are the size classes of the feed, whose mass fractions add up to 1.
    """
    throughfall_m = min(openings.across_m, throughfall(openings.along_m, thickness_m, slope_rad))
    if 1e3 * throughfall_m < SMALLEST_MM:
        return None
    shares = shares_at(rows, throughfall_m)
    capacity = capacity_kg_per_m2_s(throughfall_m, openings, shares, bulk_kg_per_m3)
    load = fed_kg_per_m2_s * shares.undersize
    d50_m = cut_size_m(throughfall_m, load / capacity)
    finest_m = min(row.smallest_m for row in rows)
    edges_m = np.geomspace(finest_m, max(finest_m, openings.smaller_m), PARTS + 1)
    fine = np.array([shares_at(rows, edge_m).undersize for edge_m in edges_m])
    middle_m = np.sqrt(edges_m[1:] * edges_m[:-1])
    passing = 1.0 - to_oversize(middle_m, d50_m)
    passed = float(np.diff(fine) @ passing / fine[-1]) if fine[-1] > 0 else math.nan
    return KarraScreen(throughfall_m, capacity, load, d50_m, passed)


def throughfall(opening_m: float, thickness_m: float, slope_rad: float) -> float:
    """Return an opening as grains that fall straight down see it, on a slope and in a sheet of a thickness.

    For a cloth of wires, Karra takes  (opening + wire) cos(slope) - wire.
    """
    return opening_m * math.cos(slope_rad) - thickness_m * math.sin(slope_rad)


def capacity_kg_per_m2_s(
    throughfall_m: float, openings: Openings, shares: FeedShares, bulk_kg_per_m3: float
) -> float:
    """Return the undersize per area with which d50 is the throughfall aperture."""
    mm = 1e3 * throughfall_m
    basic = 12.1286 * mm**0.3162 - 10.2991 if mm < FAR else 0.3388 * mm + 14.4122
    basic *= 100 * openings.open_share / (21.5 * math.log10(1e3 * openings.smaller_m) + 37.0)
    near_mesh = 0.844 * (1.0 - shares.near_mesh) ** 3.453
    factors = basic, _oversize(100 * shares.oversize), _half_size(100 * shares.half_size), near_mesh
    return math.prod(factors) * bulk_kg_per_m3 / STANDARD_KG_PER_M3 * PER_TH


def cut_size_m(throughfall_m: float, load_over_capacity: float) -> float:
    """Return the size of which half passes; infinite without a load."""
    return throughfall_m * load_over_capacity**-0.148 if load_over_capacity > 0 else math.inf


def to_oversize(size_m: Array, d50_m: float) -> Array:
    """Return the share of grains of each size (n,) that goes to the oversize."""
    return np.asarray(1.0 - np.exp(-math.log(2.0) * (size_m / d50_m) ** SHARPNESS))


def _oversize(percent: float) -> float:
    return 1.6 - 0.012 * percent if percent <= 87 else 4.275 - 0.0425 * percent


def _half_size(percent: float) -> float:
    if percent <= 30:
        return 0.7 + 0.012 * percent
    if percent < 55:
        return float(0.1528 * percent**0.564)
    return float(0.0061 * percent**1.37) if percent < 80 else 0.05 * percent - 1.5
