"""Optimisers behind one port: where a study runs its next point, and what it recommends."""

from __future__ import annotations

from itertools import pairwise
from typing import Protocol

import numpy as np
import numpy.typing as npt
from scipy import stats
from scipy.optimize import minimize

from orchestrator.studies.design.aim import Aim, Limit
from orchestrator.studies.design.front import improvements, nondominated
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.surrogates import Fitted
from orchestrator.studies.design.whale import whale_search
from orchestrator.workbench.vocabulary import Array

CANDIDATES = 150  # of each kind: all over the space, on its borders, around the best
DRAWS = 128  # of all responses at the candidates
NARROWED = 5  # times that the candidates of a recommendation are drawn around the best
STARTS = 20  # of SLSQP
SPREAD = 64  # settings that tell how much responses differ over the space
TOLERANCE = 1e-6  # of a limit, in spreads of its response over the space
WORTHLESS = -1e30  # of settings that break a limit: below any goal in any unit


class Optimiser(Protocol):
    """A way to choose settings from the predictions of the surrogates.

    ``done``, (n, factors), are the coded settings that have been run or are being run.
    """

    def propose(self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator) -> Array:
        """Propose the next setting to be run, coded, (factors,)."""
        ...

    def recommend(
        self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator
    ) -> Array:
        """Choose the setting, coded, (factors,), with the best expected first goal whose limits hold with the
        aim's confidence; where no setting is so sure, the setting that keeps the limits most probably."""
        ...


class _Confident:
    """Recommend by a random search that narrows in on the best settings."""

    def recommend(
        self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator
    ) -> Array:
        """Choose the best setting that keeps the limits with the aim's confidence."""
        best = near = space.ordered(done.copy())
        for _ in range(NARROWED):
            candidates = np.vstack([best[:1], space.candidates(near, 2 * CANDIDATES, rng)])
            best = near = candidates[np.argsort(-confident_worth(fitted, aim, candidates))[:5]]
        return np.asarray(best[0])


class ExpectedImprovement(_Confident):
    """The largest expected gain over the best so far, where neither is known without noise.

    Responses are drawn jointly at all settings done and at candidates; what a candidate gains in a
    draw counts only where it keeps all limits in that draw.  With two goals the gain is that of the
    hypervolume under their front.  Source: B. Letham, B. Karrer, G. Ottoni, E. Bakshy, Bayesian Anal. 14
    (2019) 495, doi:10.1214/18-BA1110; hypervolume: M. Emmerich, K. Giannakoglou, B. Naujoks, IEEE Trans.
    Evol. Comput. 10 (2006) 421, doi:10.1109/TEVC.2005.859463.
    """

    def propose(self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator) -> Array:
        """Propose the candidate with the largest mean gain over all draws."""
        near = np.vstack([_best_done(fitted, aim, done), self.recommend(fitted, aim, space, done, rng)])
        candidates = space.candidates(near, CANDIDATES, rng)
        drawn = _draw(fitted, np.vstack([done, candidates]), rng)
        gains, kept = aim.gains(drawn), aim.kept(drawn)
        before, after = np.s_[..., : len(done)], np.s_[..., len(done) :]
        if not kept.any():  # nothing is to be gained yet: come nearer to the limits
            margin = aim.margin(*predict_each(fitted, candidates))
            return np.asarray(candidates[int(np.argmax(margin))])
        mean_gain = _gain(gains[before], kept[before], gains[after], kept[after]).mean(axis=0)
        return np.asarray(candidates[int(np.argmax(mean_gain))])


class Whale:
    """The predicted best, searched by the whale algorithm, as the paper does."""

    def propose(self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator) -> Array:
        """Propose the setting with the best predicted goal among those predicted to keep the limits."""
        return whale_search(lambda x: predicted_worth(fitted, aim, x), space, rng)

    def recommend(
        self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator
    ) -> Array:
        """Choose the best setting that keeps the limits with the aim's confidence."""
        return whale_search(lambda x: confident_worth(fitted, aim, x), space, rng)


class Gradient:
    """The predicted best, searched by sequential quadratic programming (SLSQP) from many starts.

    Source: D. Kraft, DFVLR-FB 88-28 (1988); scipy.optimize does it.
    """

    def propose(self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator) -> Array:
        """Propose the setting with the best predicted goal among those predicted to keep the limits."""
        return self._search(fitted, aim, space, rng, 0.0)

    def recommend(
        self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator
    ) -> Array:
        """Choose the best setting each of whose limits holds with the aim's confidence."""
        margin = float(stats.norm.ppf(aim.confidence ** (1.0 / max(len(aim.limits), 1))))
        return self._search(fitted, aim, space, rng, margin)

    def _search(
        self, fitted: Fitted, aim: Aim, space: Space, rng: np.random.Generator, margin: float
    ) -> Array:
        """Search for the best predicted goal where limits are kept by so many standard deviations."""
        spread = np.maximum(predict_each(fitted, space.sample(SPREAD, 1))[0].std(axis=1), 1e-300)
        goal = aim.goals[0]

        def distance(x: Array, limit: Limit) -> float:
            mean, deviation = predict_each(fitted, space.simplify(x[None]))
            kept_by = limit.sign * (mean[limit.response, 0] - limit.value)
            return float((kept_by - margin * deviation[limit.response, 0]) / spread[limit.response])

        def loss(x: Array) -> float:
            mean, _ = predict_each(fitted, space.simplify(x[None]))
            return -goal.sign * float(mean[goal.response, 0] / spread[goal.response])

        limits = [
            {"type": "ineq", "fun": lambda x, limit=limit: distance(x, limit)} for limit in aim.limits
        ] + [
            {"type": "ineq", "fun": lambda x, i=i, j=j: x[i] - x[j]}
            for chain in space.chains
            for i, j in pairwise(chain)
        ]
        ends = [
            minimize(loss, start, bounds=[(-1, 1)] * space.factors, constraints=limits).x
            for start in space.sample(STARTS, int(rng.integers(2**31)))
        ]
        settings = space.ordered(np.array(ends))
        missing = [max((-distance(x, limit) for limit in aim.limits), default=0.0) for x in settings]
        least = min(missing)
        losses = [
            loss(x) if gap <= max(least, TOLERANCE) else np.inf
            for x, gap in zip(settings, missing, strict=True)
        ]
        return np.asarray(settings[int(np.argmin(losses))])


class Sobol(_Confident):
    """The next point of a sequence that fills the space: what any search is to be better than."""

    def propose(self, fitted: Fitted, aim: Aim, space: Space, done: Array, rng: np.random.Generator) -> Array:
        """Propose a point of a new scrambled Sobol set."""
        return np.asarray(space.sample(1, int(rng.integers(2**31)))[0])


OPTIMISERS: dict[str, type[Optimiser]] = {
    "expected-improvement": ExpectedImprovement,
    "whale": Whale,
    "gradient": Gradient,
    "sobol": Sobol,
}


def confident_worth(fitted: Fitted, aim: Aim, x: Array) -> Array:
    """Compute the expected first goal, (p,), of settings, (p, f), that keep the limits with the aim's
    confidence.

    The worth of all others is far below, and higher where they keep the limits more probably.
    """
    mean, deviation = predict_each(fitted, x)
    sure, gain = aim.log_probability(mean, deviation), aim.gains(mean)[0]
    return np.where(sure >= np.log(aim.confidence), gain, WORTHLESS * (1.0 - sure))


def predicted_worth(fitted: Fitted, aim: Aim, x: Array) -> Array:
    """Compute the predicted first goal, (p,); where a limit is predicted to fail, below all that keep it."""
    mean, _ = predict_each(fitted, x)
    missing = np.zeros(len(x))
    for limit in aim.limits:
        missing += np.maximum(limit.sign * (limit.value - mean[limit.response]), 0.0)
    return np.where(missing > 0, WORTHLESS * (1.0 + missing), aim.gains(mean)[0])


def predict_each(fitted: Fitted, x: Array, block: int = 100) -> tuple[Array, Array]:
    """Predict means and standard deviations, (m, p), of the responses at settings, (p, f), one by one."""
    means, deviations = [], []
    for start in range(0, len(x), block):
        mean, covariance = fitted.predict(x[start : start + block])
        means.append(mean)
        deviations.append(np.sqrt(np.maximum(np.diagonal(covariance, axis1=1, axis2=2), 0.0)))
    return np.hstack(means), np.hstack(deviations)


def _best_done(fitted: Fitted, aim: Aim, done: Array, count: int = 4) -> Array:
    """The settings done that are predicted best, those that keep the limits before all others."""
    mean, deviation = predict_each(fitted, done)
    margin, gain = aim.margin(mean, deviation), aim.gains(mean)
    if len(aim.goals) > 1:
        front = nondominated(gain, margin > 0)
        return done[front] if front.any() else done[np.argsort(-margin)[:count]]
    order = np.argsort(-np.where(margin > 0, gain[0], gain[0].min() - 1.0 + margin))
    return np.asarray(done[order[:count]])


def _draw(fitted: Fitted, x: Array, rng: np.random.Generator) -> Array:
    """Draw the responses, (m, draws, p), at settings, (p, f), together."""
    drawn = []
    for mean, covariance in zip(*fitted.predict(x), strict=True):
        values, vectors = np.linalg.eigh(covariance)  # singular where there is no noise
        root = vectors * np.sqrt(np.maximum(values, 0.0))
        drawn.append(mean + rng.standard_normal((DRAWS, len(x))) @ root.T)
    return np.array(drawn)


def _gain(gains: Array, kept: npt.NDArray[np.bool_], new: Array, new_kept: npt.NDArray[np.bool_]) -> Array:
    """Compute what new settings gain, (draws, new), over those done, in each draw.

    ``gains`` (goals, draws, n) and ``kept`` (draws, n) are of the settings done, the others of new ones.
    """
    if len(gains) == 1:
        lowest = min(gains.min(), new.min())
        best = np.where(kept, gains[0], lowest).max(axis=1)
        return np.where(new_kept, np.maximum(new[0] - best[:, None], 0.0), 0.0)
    reference = reference_point(gains.mean(axis=1), kept.mean(axis=0) > 0.5)
    rows = zip(gains.swapaxes(0, 1), kept, new.swapaxes(0, 1), new_kept, strict=True)
    return np.array([np.where(ok, improvements(g[:, k], reference, n), 0.0) for g, k, n, ok in rows])


def reference_point(gains: Array, kept: npt.NDArray[np.bool_]) -> Array:
    """Choose the point, (goals,), that the hypervolume is measured from: a tenth of their range below the
    lowest gains of the settings done that keep the limits, or of all where none does."""
    known = gains[:, kept] if kept.any() else gains
    low, high = known.min(axis=1), known.max(axis=1)
    return np.asarray(low - 0.1 * np.maximum(high - low, 1e-9))
