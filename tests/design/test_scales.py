"""Scales of responses: what is predicted on them can exist."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.studies.design.scales import ENDS, SCALES

VALUES = {
    "plain": [-3.0, 0.0, 2.5],
    "percent": [ENDS, 0.5, 50.0, 80.0, 99.9],
    "logarithm": [1e-9, 0.3, 1.0, 4e5],
}
EVERY = pytest.mark.parametrize("name", SCALES)


@EVERY
def test_a_value_comes_back_from_its_scale(name: str) -> None:
    scale = SCALES[name]
    assert scale.from_fit(scale.to_fit(np.array(VALUES[name]))) == pytest.approx(VALUES[name], rel=1e-12)
    for value in VALUES[name]:
        assert float(scale.from_fit(scale.to_fit(value))) == pytest.approx(value, rel=1e-12)


@EVERY
def test_larger_values_stay_larger(name: str) -> None:
    assert (np.diff(SCALES[name].to_fit(np.array(VALUES[name]))) > 0).all()


@EVERY
def test_the_slope_of_a_scale_is_its_derivative(name: str) -> None:
    scale = SCALES[name]
    for value in VALUES[name][1:]:
        step = 1e-6 * max(abs(value), 1.0)
        expected = (scale.to_fit(value + step) - scale.to_fit(value - step)) / (2.0 * step)
        assert float(scale.slope(value)) == pytest.approx(float(expected), rel=1e-5)


def test_eighty_percent_are_the_logarithm_of_four() -> None:
    assert float(SCALES["percent"].to_fit(80.0)) == pytest.approx(np.log(4.0))
    assert float(SCALES["percent"].slope(80.0)) == pytest.approx(100.0 / (80.0 * 20.0))


@pytest.mark.parametrize("logit", [-800.0, -40.0, 40.0, 800.0])
def test_no_share_beyond_nothing_and_all_is_predicted(logit: float) -> None:
    assert 0.0 <= float(SCALES["percent"].from_fit(logit)) <= 100.0


@pytest.mark.parametrize("percent", [-1.0, 0.0, 100.0, 101.0])
def test_nothing_and_all_have_a_finite_logit(percent: float) -> None:
    scale = SCALES["percent"]
    end = ENDS if percent < 50 else 100.0 - ENDS
    assert float(scale.to_fit(percent)) == pytest.approx(float(scale.to_fit(end)))
    assert np.isfinite(scale.slope(percent))


@pytest.mark.parametrize("value", [0.0, -1.0])
def test_what_has_no_logarithm_counts_as_not_measured(value: float) -> None:
    assert np.isnan(SCALES["logarithm"].to_fit(value))
    assert np.isnan(SCALES["logarithm"].slope(value))
