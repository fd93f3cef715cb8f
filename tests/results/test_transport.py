"""Residence and passing of particles whose ways are known; sums over cycles."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.bed import passing_kg_per_s_m, residence_s
from orchestrator.output.results.events import LOST, EventTable, per_cycle


def removed(ids: list[int], time_s: list[float]) -> EventTable:
    n = len(ids)
    sizes = np.full(n, 0.003), np.full(n, 1e-3)
    return EventTable(np.array(ids), np.array(time_s), *sizes, np.zeros((n, 3)), np.zeros(n, dtype=int))


def test_residence_goes_by_id() -> None:
    fed = EventTable(np.array([7, 2, 5]), np.array([0.5, 0.0, 0.1]), np.full(3, 0.003), np.full(3, 1e-3))
    found = residence_s(fed, removed([5, 7, 9, 2], [1.0, 2.0, 3.0, 4.0]))
    assert found[[0, 1, 3]] == pytest.approx([0.9, 1.5, 4.0])
    assert np.isnan(found[2])


def test_passing_per_metre_and_second() -> None:
    found = passing_kg_per_s_m(
        np.array([0.05, 0.15, 0.17, -0.3]), np.array([1.0, 2.0, 3.0, 4.0]), np.array([0, 0.1, 0.3]), 2.0
    )
    assert found == pytest.approx([(1 + 4) / 0.1 / 2, (2 + 3) / 0.2 / 2])


def test_sums_over_cycles_lose_nothing() -> None:
    """The edge belongs to the cycle that ends there, t = 0 to the first."""
    time = np.array([0.0, 0.1, 0.1000001, 0.2, 0.25, 0.31])
    group = np.array([0, 1, 0, 0, LOST, 0])
    table = per_cycle(time, np.arange(1.0, 7.0), np.array([0.0, 0.1, 0.2, 0.3]), group, 2)
    assert table.tolist() == [[1.0, 2.0], [3.0 + 4.0, 0.0], [0.0, 0.0]]
