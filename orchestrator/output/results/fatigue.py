"""The strain cycles of panels by rainflow counting, and their rank by the user's own line.

Strain is that of the middle line as a whole, of which a run records the extremes of each cycle of the
machine; smaller cycles within one, and bending at the clamps, are not in it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import FatigueLine
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array

Cycles = list[tuple[float, float]]
"""Ranges and their counts, 1 or 0.5."""


def rainflow(values: Iterable[float]) -> Cycles:
    """Return the ranges of a series and their counts, in the order of counting (ASTM E1049-85, 5.4.4).

    Cycles within the series count 1, those of the starting point and of what is left over 0.5.
    """
    counted: Cycles = []
    points: list[float] = []
    for value in turning_points(values):
        points.append(value)
        while len(points) >= 3:
            newer, older = abs(points[-1] - points[-2]), abs(points[-2] - points[-3])
            if newer < older:
                break
            if len(points) == 3:
                counted.append((older, 0.5))
                del points[0]
            else:
                counted.append((older, 1.0))
                del points[-3:-1]
    counted += [(abs(b - a), 0.5) for a, b in pairwise(points)]
    return counted


def turning_points(values: Iterable[float]) -> list[float]:
    """Return the first value, the values at which a series turns, and the last one."""
    points: list[float] = []
    for value in values:
        if points and value == points[-1]:
            continue
        if len(points) >= 2 and (points[-1] - points[-2]) * (value - points[-1]) > 0:
            points[-1] = value
        else:
            points.append(value)
    return points


def damage(counted: Cycles, line: FatigueLine) -> float:
    """Return the sum of cycles over cycles to failure (Miner's rule)."""
    amplitudes = [(size / 2 / line.strain_amplitude, count) for size, count in counted]
    return float(sum(count / line.cycles * ratio**line.slope for ratio, count in amplitudes))


def strain_cycles(run: RunReader, name: str, least: Array, most: Array) -> tuple[float, float | None]:
    """Return the mean strain range of a panel in percent and its damage, from the extremes of each cycle
    (cycles,).  The damage is None where its material has no line.
    """
    counted = rainflow(np.column_stack([least, most]).ravel().tolist())
    total = sum(count for _, count in counted)
    material = next((p.table.material for p in single_panels(run.case) if p.name == name), "")
    line = run.case.materials[material].fatigue if material in run.case.materials else None
    range_percent = 100 * sum(size * count for size, count in counted) / total if total else 0.0
    return range_percent, None if line is None else damage(counted, line)


def ranked(damages: Mapping[str, float | None]) -> dict[str, float | None]:
    """Return the damage of each panel over that of the worst.

    A line and a strain that stand for a whole mat tell which mat suffers most, and not how long it lives.
    """
    worst = max((size for size in damages.values() if size is not None), default=0.0)
    return {name: None if size is None or worst == 0.0 else size / worst for name, size in damages.items()}
