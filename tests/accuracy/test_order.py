"""Orders that are known come out, and only where there is one."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.studies.accuracy.convergence import fit_order

H = [8e-5, 4e-5, 2e-5, 1e-5]


@pytest.mark.parametrize("order", [1.0, 2.0, 3.5])
@pytest.mark.parametrize("points", [3, 4])
def test_an_order_is_seen_although_the_reference_is_off_itself(order: float, points: int) -> None:
    """y = 7 + 3 (h / h0)^p against the finest of the values, exactly."""
    h = H[-points:]
    y = [7 + 3 * (each / h[0]) ** order for each in h]
    fit = fit_order(h, [abs(each - y[-1]) for each in y], h[-1])
    assert fit is not None
    assert fit.order == pytest.approx(order, abs=0.01)
    assert fit.is_clean
    assert fit.error(h[-1]) == pytest.approx(3 * (h[-1] / h[0]) ** order, rel=0.03)


def test_against_an_exact_answer_all_values_count() -> None:
    fit = fit_order(H, [5 * h**1.5 for h in H], 0.0)
    assert fit is not None
    assert (fit.order, fit.constant) == (pytest.approx(1.5, abs=0.01), pytest.approx(5, rel=0.1))


def test_what_does_not_fall_has_no_order() -> None:
    assert fit_order(H, [0.1, 0.1, 0.1, 0.0], H[-1]) is None
    assert fit_order(H[:2], [0.1, 0.0], H[1]) is None


def test_what_scatters_is_not_clean() -> None:
    rough = [h**2 * factor for h, factor in zip(H, (1.0, 3.0, 0.4, 0.0), strict=True)]
    fit = fit_order(H, rough, H[-1])
    assert fit is None or not fit.is_clean


def test_a_misfit_of_one_percent_is_clean() -> None:
    noisy = [h * (1 + 0.01 * (-1) ** n) for n, h in enumerate(H)]
    fit = fit_order(H, noisy, 0.0)
    assert fit is not None
    assert fit.is_clean
    assert np.isclose(fit.order, 1.0, atol=0.05)
