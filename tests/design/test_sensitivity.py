"""Sobol indices of what a surrogate predicts, against functions whose indices are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.gaussian_process import GaussianProcess
from orchestrator.studies.design.sensitivity import sobol_indices
from orchestrator.studies.design.space import Space
from tests.design.table5 import RESPONSES, fitted_quadratic, surface

# of the function with 7 and 0.1: T. Homma, A. Saltelli, Reliab. Eng. Syst. Saf. 52 (1996) 1,
# doi:10.1016/0951-8320(96)00002-6
ISHIGAMI_FIRST, ISHIGAMI_TOTAL = [0.313905, 0.442411, 0.0], [0.557589, 0.442411, 0.243684]


@dataclass(frozen=True)
class Known:
    """A surrogate that knows the responses, (m, p), of coded settings."""

    function: Callable[[Array], Array]

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict without error."""
        mean = self.function(x)
        return mean, np.zeros((len(mean), len(x), len(x)))

    def left_out(self) -> tuple[Array, Array]:
        """Refuse to leave points out: there are no data."""
        raise NotImplementedError


def ishigami(x: Array) -> Array:
    """Ishigami's function of coded settings, (1, p)."""
    a, b, c = np.pi * x.T
    return np.array([np.sin(a) + 7.0 * np.sin(b) ** 2 + 0.1 * c**4 * np.sin(a)])


def test_the_indices_of_ishigamis_function_are_known() -> None:
    (first, first_half, total, total_half) = sobol_indices(Known(ishigami), 3, samples=2**13)[0]
    assert first == pytest.approx(ISHIGAMI_FIRST, abs=0.02)
    assert total == pytest.approx(ISHIGAMI_TOTAL, abs=0.02)
    assert (first_half < 0.05).all()
    assert (total_half < 0.05).all()


def test_each_response_has_its_own_indices() -> None:
    def function(x: Array) -> Array:
        return np.array([x[:, 0], 5.0 + 2.0 * x[:, 1], x[:, 0] + x[:, 1]])

    indices = sobol_indices(Known(function), 2)
    assert indices.shape == (3, 4, 2)
    expected = np.array([[1, 0], [0, 1], [0.5, 0.5]])
    np.testing.assert_allclose(indices[:, 0], expected, atol=0.02)
    np.testing.assert_allclose(indices[:, 2], expected, atol=0.02)


@pytest.mark.parametrize("response", RESPONSES)
def test_sampled_indices_of_table_5_agree_with_the_closed_form(response: str) -> None:
    (first, _, total, _) = sobol_indices(fitted_quadratic(), 5)[RESPONSES.index(response)]
    _, closed_first, closed_total = surface(response).sobol_indices()
    assert first == pytest.approx(closed_first, abs=0.02)
    assert total == pytest.approx(closed_total, abs=0.02)


def test_indices_are_the_same_for_one_seed() -> None:
    first, again = (sobol_indices(Known(ishigami), 3, samples=64, seed=3) for _ in range(2))
    np.testing.assert_array_equal(first, again)


def test_a_gaussian_process_of_some_hundred_points_tells_the_indices_of_ishigamis_function() -> None:
    x = Space(-np.ones(3), np.ones(3)).sample(200, 1)
    y = ishigami(x).T
    fitted = GaussianProcess().fit(x, y, np.full_like(y, 1e-6), 1)
    (first, _, total, _) = sobol_indices(fitted, 3)[0]
    assert first == pytest.approx(ISHIGAMI_FIRST, abs=0.05)
    assert total == pytest.approx(ISHIGAMI_TOTAL, abs=0.05)


def test_no_factor_decides_a_constant_response() -> None:
    indices = sobol_indices(Known(lambda x: np.full((1, len(x)), 5.0)), 2)
    np.testing.assert_array_equal(indices, np.zeros((1, 4, 2)))
