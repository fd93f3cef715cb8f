"""Feeds: boxes apart and in the domain, times in order, and rates that find room."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations

import numpy as np

from orchestrator.case.bed.feed import RateFeed, apart
from orchestrator.case.bed.sources import batch_s, inlets
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.planning import material_numbers
from orchestrator.case.tables.case import Case

SLACK_M = 1e-9  # rounding when boxes are turned


def feeds(case: Case) -> Iterator[CaseProblem]:
    """All that is wrong with ``[bed.feeds]``."""
    low, high = np.array(case.domain_m)
    found = inlets(case, material_numbers(case))
    for name, inlet in found.items():
        key: Key = ("bed", "feeds", name)
        if inlet.start_s >= case.duration_s:
            what = f"{inlet.start_s:g} s is not before the end, duration_s = {case.duration_s:g} s"
            yield CaseProblem((*key, "start_s"), what)
        if inlet.stop_s <= inlet.start_s:
            what = f"{inlet.stop_s:g} s is not after start_s = {inlet.start_s:g} s"
            yield CaseProblem((*key, "stop_s"), what)
        if (inlet.corners_m < low - SLACK_M).any() or (inlet.corners_m > high + SLACK_M).any():
            yield CaseProblem((*key, "box_m"), "is not inside domain_m")
        if inlet.rate_kg_per_s > inlet.largest_rate_kg_per_s:
            what = f"{inlet.rate_kg_per_s:g} kg/s find no room in the box"
            hint = (
                f"the largest rate is {inlet.largest_rate_kg_per_s:.3g} kg/s; a larger box or "
                "velocity_m_per_s takes more"
            )
            yield CaseProblem((*key, "rate_kg_per_s"), what, hint)
    for (one, first), (two, second) in combinations(found.items(), 2):
        if not apart(first, second):
            yield CaseProblem(("bed", "feeds", two, "box_m"), f'overlaps the box of feed "{one}"')


ENOUGH = 0.8  # of what is due by the end
ROUNDED = 0.01  # of the time between batches


def feeds_that_hardly_feed(case: Case) -> Iterator[str]:
    """Feeds of which nothing, or clearly less than is due by the end, comes before it: particles
    come in batches, and the last batch may be long before the end."""
    for name, inlet in inlets(case, material_numbers(case)).items():
        batches = math.ceil(case.duration_s / inlet.batch_s - 1e-9)
        last_s = (batches - 1) * inlet.batch_s
        comes_kg, due_kg = inlet.due_kg(last_s), inlet.due_kg(case.duration_s)
        when = f"its batches come every {inlet.batch_s:g} s, the last at t = {last_s:g} s"
        first_kg = RateFeed(inlet).next_kg
        if comes_kg < first_kg / 2:
            yield (
                f'feed "{name}" feeds nothing in {case.duration_s:g} s: {when}, when '
                f"{comes_kg:.3g} kg are due and its first particle has {first_kg:.3g} kg; a longer "
                "run, a higher rate_kg_per_s, an earlier start_s or a shorter "
                "particles.feed_interval_s helps"
            )
        elif comes_kg < ENOUGH * due_kg:
            yield (
                f'feed "{name}" feeds {comes_kg:.3g} of the {due_kg:.3g} kg that are due in '
                f"{case.duration_s:g} s: {when}; shorten particles.feed_interval_s"
            )


def rounded_feed_interval(case: Case) -> Iterator[str]:
    """A time between batches that is no whole number of sync intervals."""
    wanted_s, taken_s = case.particles.feed_interval_s, batch_s(case)
    if case.bed.feeds and wanted_s > 0 and abs(taken_s - wanted_s) > ROUNDED * wanted_s:
        yield (
            f"particles.feed_interval_s = {wanted_s:g} s is taken as {taken_s:g} s, a whole number "
            f"of sync intervals of {case.coupling.sync_interval_s:g} s"
        )
