"""Feeds and exits: boxes apart and where particles can be, times in order, and rates that find room."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, product

import numpy as np

from orchestrator.case.bed.feed import RateFeed, apart
from orchestrator.case.bed.sources import batch_s, inlets
from orchestrator.case.deck.panels import single_panels, to_world
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.solver_plans import material_numbers
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array

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


SAME_PLACE_M = 1e-6  # neighbouring exits may share a face


def exits(case: Case) -> Iterator[CaseProblem]:
    """All that is wrong with ``[screen.exits]``."""
    boxes_m = {name: np.array(row.box_m) for name, row in case.screen.exits.items()}
    for name, box_m in boxes_m.items():
        key: Key = ("screen", "exits", name, "box_m")
        if not (box_m[0] < box_m[1]).all():
            yield CaseProblem(key, "is empty", "give the lowest corner, then the highest")
            return
        corners_m = to_world(case, np.array(list(product(*box_m.T))))
        low, high = np.array(case.domain_m)
        if ((corners_m < low).all(axis=0) | (corners_m > high).all(axis=0)).any():
            yield CaseProblem(key, "is outside domain_m: no particle gets there")
        for panel, part_m in _decks_m(case).items():
            if _overlap(box_m, part_m):
                yield CaseProblem(key, f"panel {panel} reaches into it")
    for (one, first_m), (two, second_m) in combinations(boxes_m.items(), 2):
        if _overlap(first_m, second_m):
            yield CaseProblem(("screen", "exits", two, "box_m"), f'overlaps exit "{one}"')


def _decks_m(case: Case) -> dict[str, Array]:
    """Bounds (2, 3) of each panel, straight between its clamps, in deck axes."""
    found = {}
    for panel in single_panels(case):
        r = panel.rectangle
        ends_m = np.array(list(product((0.0, r.length_m), (0.0, r.width_m))))
        corners_m = r.mounted(ends_m) @ to_world(case, np.eye(3)).T
        found[panel.name] = np.array([corners_m.min(axis=0), corners_m.max(axis=0)])
    return found


def _overlap(one_m: Array, two_m: Array) -> bool:
    low, high = one_m[0] + SAME_PLACE_M, one_m[1] - SAME_PLACE_M
    return bool((low <= two_m[1]).all() and (two_m[0] <= high).all())
