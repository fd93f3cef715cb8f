"""Plans: Box-Behnken designs as published, full factorials and Latin hypercubes."""

from __future__ import annotations

from itertools import combinations
from math import comb

import numpy as np
import pytest

from orchestrator.studies.design.plans import box_behnken, factorial, latin_hypercube
from orchestrator.studies.design.quadratic import model_matrix, quadratic_terms
from orchestrator.studies.design.space import Space
from tests.design.table5 import table_5

FIVE = Space(-np.ones(5), np.ones(5), chains=((0, 2, 4),))


def test_a_box_behnken_design_of_three_factors_has_the_middles_of_the_edges() -> None:
    edges = [(-1, -1, 0), (-1, 1, 0), (1, -1, 0), (1, 1, 0)]
    edges += [(-1, 0, -1), (-1, 0, 1), (1, 0, -1), (1, 0, 1)]
    edges += [(0, -1, -1), (0, -1, 1), (0, 1, -1), (0, 1, 1)]
    np.testing.assert_array_equal(box_behnken(3), [*edges, *[(0, 0, 0)] * 3])


@pytest.mark.parametrize(("factors", "runs", "at_each_end"), [(3, 12, 4), (4, 24, 6), (5, 40, 8)])
def test_a_box_behnken_design_moves_each_pair_of_factors(factors: int, runs: int, at_each_end: int) -> None:
    x = box_behnken(factors, centres=0)
    assert x.shape == (runs, factors)
    assert len({tuple(row) for row in x}) == runs
    assert all((np.abs(row).sum()) == 2 for row in x)
    for column in x.T:
        assert [(column == value).sum() for value in (-1, 0, 1)] == [
            at_each_end,
            runs - 2 * at_each_end,
            at_each_end,
        ]
    np.testing.assert_array_equal(x.T @ x, 2 * at_each_end * np.eye(factors))
    for i, j in combinations(range(factors), 2):
        assert ((x[:, i] * x[:, j]) ** 2).sum() == 4


@pytest.mark.parametrize(
    ("factors", "runs", "moved_together"),
    [(6, 48, {(0, 3), (1, 4), (2, 5)}), (7, 56, set())],
    ids=["six", "seven"],
)
def test_a_box_behnken_design_of_more_factors_moves_triples(
    factors: int, runs: int, moved_together: set[tuple[int, int]]
) -> None:
    """The numbers are those of Box and Behnken, Technometrics 2 (1960) 455: 48 runs where three pairs of
    factors meet twice, and 56 where each pair meets once; moving pairs would take 60 and 84."""
    x = box_behnken(factors, centres=0)
    assert x.shape == (runs, factors)
    assert len({tuple(row) for row in x}) == runs
    assert all(np.abs(row).sum() == 3 for row in x)
    np.testing.assert_array_equal(x.T @ x, 24 * np.eye(factors))
    for pair in combinations(range(factors), 2):
        both = (x[:, pair] != 0).all(axis=1).sum()
        assert both == (16 if pair in moved_together else 8)


@pytest.mark.parametrize("factors", range(3, 8))
def test_a_box_behnken_design_tells_all_terms_of_a_quadratic(factors: int) -> None:
    terms = quadratic_terms(factors)
    matrix = model_matrix(box_behnken(factors, centres=1), terms)
    assert np.linalg.matrix_rank(matrix) == len(terms) == 1 + 2 * factors + comb(factors, 2)


def test_table_5_is_the_whole_box_behnken_design_of_five_factors() -> None:
    x, _ = table_5()
    planned = box_behnken(5)
    assert sorted(map(tuple, x.round(12))) == sorted(map(tuple, planned))
    matrix = model_matrix(planned, quadratic_terms(5))
    assert np.linalg.cond(matrix) == pytest.approx(7.521707, abs=1e-6)  # computed from Table 5 by NumPy


@pytest.mark.parametrize("factors", [1, 2, 8])
def test_there_is_no_box_behnken_design_of_other_numbers_of_factors(factors: int) -> None:
    with pytest.raises(ValueError, match=rf"\b3\b.*\b7\b.*\b{factors}\b"):
        box_behnken(factors)


def test_a_full_factorial_keeps_the_order_of_chained_factors() -> None:
    free = Space(-np.ones(2), np.ones(2))
    assert factorial(free, 3).shape == (9, 2)
    x = factorial(FIVE, 3)
    assert len(x) == comb(3 + 3 - 1, 3) * 9  # falling triples of three levels, and two free factors
    assert (np.diff(x[:, [0, 2, 4]]) <= 0).all()


def test_a_latin_hypercube_has_each_layer_once() -> None:
    space = Space(np.array([0.0, 10.0]), np.array([1.0, 30.0]))
    x = latin_hypercube(space, 12, seed=3)
    for column in x.T:
        assert sorted(np.floor((column + 1.0) / 2.0 * 12).astype(int)) == list(range(12))
    np.testing.assert_array_equal(x, latin_hypercube(space, 12, seed=3))
    assert (np.diff(latin_hypercube(FIVE, 12, seed=3)[:, [0, 2, 4]]) <= 0).all()
