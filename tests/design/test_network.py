"""The network's members: what a member has not seen, and how they scatter."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.network import PENALTIES, FittedNetwork, Network
from orchestrator.studies.design.space import Space

POINTS = 32  # a power of two: means of whole numbers are exact, in any order
FEW = Network(nodes=4, members=3)


def settings() -> Array:
    """Return settings of two factors."""
    return Space(-np.ones(2), np.ones(2)).sample(POINTS, 1)


def fit(y: Array, network: Network = FEW) -> FittedNetwork:
    """Fit a network to a response, (n,)."""
    return network.fit(settings(), y[:, None], np.zeros((POINTS, 1)), 1)


def whole_numbers() -> Array:
    """Return a bent response, in whole numbers."""
    x = settings()
    return np.asarray(np.round(50.0 * (x[:, 0] - 0.5 * x[:, 1] + 0.7 * x[:, 0] ** 2)))


def test_a_member_does_not_see_the_points_that_test_it() -> None:
    """Responses are exchanged among a member's test points: it must say the same of them."""
    y = whole_numbers()
    fitted = fit(y)
    for member in range(FEW.members):
        test = np.flatnonzero(np.isfinite(fitted.tested[member, :, 0]))
        exchanged = y.copy()
        exchanged[test] = y[np.roll(test, 1)]
        again = fit(exchanged)
        np.testing.assert_array_equal(again.tested[member], fitted.tested[member])
        assert not np.array_equal(again.tested, fitted.tested, equal_nan=True)  # others were trained by them


def test_a_member_is_tested_by_a_seventh_of_the_points_and_each_by_others() -> None:
    fitted = fit(whole_numbers())
    tested = np.isfinite(fitted.tested[:, :, 0])
    assert (tested.sum(axis=1) == POINTS - round(0.85 * POINTS)).all()
    assert len({tuple(row) for row in tested}) == FEW.members


def test_a_member_has_the_penalty_that_predicts_the_choosing_points_best() -> None:
    """Pure noise is best predicted by the most penalised net, an exact function by a little penalised one."""
    noise = np.random.default_rng(1).standard_normal(POINTS)
    many = Network(members=8)
    of_noise, of_exact = ([net.alpha for net in fit(y, many).nets] for y in (noise, whole_numbers()))
    assert np.median(of_noise) == max(PENALTIES)
    assert np.median(of_exact) < max(PENALTIES)


def test_members_that_differ_widen_the_prediction() -> None:
    y = whole_numbers()
    fitted = fit(y, Network(members=6))
    inside, outside = np.zeros((1, 2)), np.array([[3.0, -3.0]])
    assert fitted.predict(outside)[1][0, 0, 0] > 2.0 * fitted.predict(inside)[1][0, 0, 0]
    mean, cov = fitted.predict(inside)
    members = np.array([net.predict(inside)[0] for net in fitted.nets]) * y.std() + y.mean()
    assert mean[0, 0] == pytest.approx(members.mean())
    missed = (fitted.tested[:, :, 0] * y.std() + y.mean()) - y
    assert cov[0, 0, 0] == pytest.approx(members.var(ddof=1) + np.nanmean(missed**2))


def test_noise_is_not_taken_for_knowledge() -> None:
    """The error that members make on their test points is at least that of the noise."""
    rng = np.random.default_rng(2)
    fitted = fit(rng.standard_normal(POINTS), Network(members=6))
    deviation = np.sqrt(np.diagonal(fitted.predict(settings())[1][0]))
    assert (deviation > 0.8).all()


def test_one_setting_alone_has_a_covariance_too() -> None:
    mean, cov = fit(whole_numbers()).predict(np.zeros((1, 2)))
    assert (mean.shape, cov.shape) == ((1, 1), (1, 1, 1))


def test_what_members_explain_is_told_one_by_one() -> None:
    """The members explain nearly all of what can be learnt, and less than nothing of noise; each has points
    of its own."""
    shares = fit(whole_numbers(), Network()).explained_by_members()
    assert shares.shape == (20, 1)
    assert np.median(shares) > 0.9
    noise = fit(np.random.default_rng(2).standard_normal(POINTS), Network()).explained_by_members()
    assert np.median(noise) < 0.3
    assert len(np.unique(noise)) == 20
