"""Feeds: boxes apart and in the domain, times in order, and rates that find room."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from orchestrator.bed.feed import apart
from orchestrator.bed.sources import inlets
from orchestrator.casefile.case import Case
from orchestrator.casefile.errors import Key, Mistake
from orchestrator.planning import material_numbers

SLACK_M = 1e-9  # rounding when boxes are turned


def feeds(case: Case) -> Iterator[Mistake]:
    """All that is wrong with ``[bed.feeds]``."""
    low, high = np.array(case.domain_m)
    found = inlets(case, material_numbers(case))
    for name, inlet in found.items():
        key: Key = ("bed", "feeds", name)
        if inlet.start_s >= case.duration_s:
            what = f"{inlet.start_s:g} s is not before the end, duration_s = {case.duration_s:g} s"
            yield Mistake((*key, "start_s"), what)
        if inlet.stop_s <= inlet.start_s:
            what = f"{inlet.stop_s:g} s is not after start_s = {inlet.start_s:g} s"
            yield Mistake((*key, "stop_s"), what)
        if (inlet.corners_m < low - SLACK_M).any() or (inlet.corners_m > high + SLACK_M).any():
            yield Mistake((*key, "box_m"), "is not inside domain_m")
        if inlet.rate_kg_s > inlet.largest_rate_kg_s:
            what = f"{inlet.rate_kg_s:g} kg/s find no room in the box"
            hint = (
                f"the largest rate is {inlet.largest_rate_kg_s:.3g} kg/s; a larger box or "
                "velocity_m_s takes more"
            )
            yield Mistake((*key, "rate_kg_s"), what, hint)
    for (one, first), (two, second) in combinations(found.items(), 2):
        if not apart(first, second):
            yield Mistake(("bed", "feeds", two, "box_m"), f'overlaps the box of feed "{one}"')
