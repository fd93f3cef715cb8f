"""Partition (Tromp) curve: the share of each size class that goes to the oversize."""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array

CLASSES = 12
FEWEST_IN_CLASS = 10


def size_classes(diameter_m: Array, cut_m: float | None) -> Array:
    """(classes + 1,) edges: evenly spaced in the logarithm, one of them at the cut size, with at
    least ``FEWEST_IN_CLASS`` particles in each (neighbours are joined until they have)."""
    low, high = float(diameter_m.min()), float(diameter_m.max())
    if high <= low * (1 + 1e-9):
        return np.array([low * 0.999, high * 1.001])
    edges = np.geomspace(low * (1 - 1e-9), high * (1 + 1e-9), CLASSES + 1)
    if cut_m is not None and low < cut_m < high:
        edges[1 + np.abs(np.log(edges[1:-1] / cut_m)).argmin()] = cut_m
    counts = np.histogram(diameter_m, edges)[0]
    kept, inside = [edges[0]], 0
    for edge, count in zip(edges[1:], counts, strict=True):
        inside += count
        if inside >= FEWEST_IN_CLASS or edge == cut_m:
            kept.append(edge)
            inside = 0
    if kept[-1] < edges[-1]:
        kept[-1 if len(kept) > 1 and kept[-1] != cut_m else len(kept) :] = [edges[-1]]
    return np.array(kept)


def partition(under_kg: Array, over_kg: Array) -> Array:
    """Share (classes,) that goes to the oversize; NaN where a class is empty."""
    all_kg = under_kg + over_kg
    return np.divide(over_kg, all_kg, out=np.full(len(all_kg), np.nan), where=all_kg > 0)


def size_at(share: float, size_m: Array, partition_number: Array) -> float:
    """Size at which the curve first rises through ``share``, straight between the classes' mean
    sizes (classes,); NaN if it does not."""
    there = np.isfinite(partition_number)
    size, number = size_m[there], partition_number[there]
    rises = np.flatnonzero((number[:-1] < share) & (number[1:] >= share))
    if not len(rises):
        return float("nan")
    i = rises[0]
    part = (share - number[i]) / (number[i + 1] - number[i])
    return float(size[i] + part * (size[i + 1] - size[i]))


def cut_and_spread(size_m: Array, number: Array) -> tuple[float, float]:
    """d50 and the probable error Ep = (d75 - d25) / 2; NaN where the curve does not reach."""
    d25, d50, d75 = (size_at(share, size_m, number) for share in (0.25, 0.5, 0.75))
    return d50, (d75 - d25) / 2
