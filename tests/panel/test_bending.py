"""Properties of a bending matrix, whatever processor assembles it."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_matrix

pytestmark = pytest.mark.solver


def test_a_translation_has_no_force_to_the_last_bit():
    """Springs between random nodes, with the noise that assembly leaves: both sums are zero exactly,
    and entries are changed by no more than the noise."""
    from adapters.panel.finite_element.bending import balanced

    random = np.random.default_rng(1)
    springs = 10.0 ** random.uniform(-6, 6, (40, 40))
    springs = (springs + springs.T) * (random.random((40, 40)) < 0.2)
    springs = np.maximum(springs, springs.T)
    exact = np.diag(springs.sum(axis=1)) - springs
    largest = np.abs(exact).max()
    assembled = exact + 2e-16 * largest * random.standard_normal(exact.shape)
    matrix = balanced(csr_matrix(assembled)).toarray()
    assert np.abs(assembled.sum(axis=0)).max() > 1e-16 * largest  # what it is for
    assert np.all(matrix.sum(axis=0) == 0.0)
    assert np.all(matrix == matrix.T)
    assert matrix == pytest.approx(exact, abs=2e-14 * largest)
