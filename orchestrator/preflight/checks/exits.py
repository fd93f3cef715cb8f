"""Exits: apart from each other and from the deck at rest, and where particles can be."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations, product

import numpy as np

from orchestrator.case.deck.panels import single_panels, to_world
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array

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
