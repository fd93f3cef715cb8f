"""A dear level on top of a cheap one."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.gaussian_process import GaussianProcess
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.two_levels import TwoLevels

SPACE = Space(np.full(2, -1.0), np.full(2, 1.0))
SMALL = 1e-8  # variance of the noise


def bent(x: Array) -> Array:
    """Return the cheap response, (n, 1), of settings (n, 2): no plane, and no quadratic."""
    return np.sin(3.0 * x[:, [0]]) * np.exp(x[:, [1]])


def dear(x: Array) -> Array:
    """Return the dear response: half of the cheap one, and a plane."""
    return 0.5 * bent(x) + 2.0 - 0.3 * x[:, [1]]


def fit(dear_runs: int, cheap_runs: int) -> tuple[float, float]:
    """Return the root mean square error over the space with and without the cheap level."""
    x, cheap_x, test_x = (SPACE.sample(n, seed) for n, seed in ((dear_runs, 1), (cheap_runs, 2), (200, 3)))
    cheap = GaussianProcess().fit(cheap_x, bent(cheap_x), np.full((cheap_runs, 1), SMALL), 1)
    errors = []
    for surrogate in (TwoLevels(cheap, GaussianProcess()), GaussianProcess()):
        fitted = surrogate.fit(x, dear(x), np.full((dear_runs, 1), SMALL), 1)
        mean, covariance = fitted.predict(test_x)
        errors.append(float(np.sqrt(np.mean((mean[0] - dear(test_x)[:, 0]) ** 2))))
        assert (np.diagonal(covariance[0]) >= 0).all()
    return errors[0], errors[1]


def test_a_cheap_level_gives_the_shape() -> None:
    """Eight dear runs know little of the bends; sixty cheap ones know them all."""
    both, alone = fit(8, 60)
    assert alone > 5 * both


def test_a_cheap_level_that_tells_nothing_does_little_harm() -> None:
    x = SPACE.sample(20, 1)
    noise = np.random.default_rng(1).standard_normal((40, 1))
    cheap = GaussianProcess().fit(SPACE.sample(40, 2), noise, np.ones((40, 1)), 1)
    fitted = TwoLevels(cheap, GaussianProcess()).fit(x, dear(x), np.full((20, 1), SMALL), 1)
    alone = GaussianProcess().fit(x, dear(x), np.full((20, 1), SMALL), 1)
    test_x = SPACE.sample(200, 3)
    errors = [np.mean((f.predict(test_x)[0][0] - dear(test_x)[:, 0]) ** 2) for f in (fitted, alone)]
    assert errors[0] < 2.0 * errors[1]


def test_left_out_points_know_the_cheap_level() -> None:
    x, cheap_x = SPACE.sample(8, 1), SPACE.sample(60, 2)
    cheap = GaussianProcess().fit(cheap_x, bent(cheap_x), np.full((60, 1), SMALL), 1)
    mean, deviation = (
        TwoLevels(cheap, GaussianProcess()).fit(x, dear(x), np.full((8, 1), SMALL), 1).left_out()
    )
    assert mean == pytest.approx(dear(x), abs=0.3)
    assert (deviation > 0).all()


def test_left_out_points_are_as_uncertain_as_the_cheap_level() -> None:
    """A cheap level with noise, and dear runs that are exactly half of it and a plane."""
    x, cheap_x = SPACE.sample(12, 1), SPACE.sample(30, 2)
    noisy = bent(cheap_x) + 0.3 * np.random.default_rng(1).standard_normal((30, 1))
    cheap = GaussianProcess().fit(cheap_x, noisy, np.full((30, 1), 0.09), 1)
    fitted = TwoLevels(cheap, GaussianProcess()).fit(x, dear(x), np.full((12, 1), SMALL), 1)
    assert fitted.factor[0] > 0.2
    least = fitted.factor * np.sqrt(np.diagonal(cheap.predict(x)[1][0]))[:, None]
    assert (fitted.left_out()[1] >= least).all()
