"""What a study is after: goals to be made large or small, limits to be kept, and how surely."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from orchestrator.workbench.vocabulary import Array


@dataclass(frozen=True)
class Goal:
    """A response, by its number, to be made as large (``sign`` 1) or as small (-1) as possible."""

    response: int
    sign: float


@dataclass(frozen=True)
class Limit:
    """A response, by its number, that must be at least (``sign`` 1) or at most (-1) ``value``."""

    response: int
    sign: float
    value: float


@dataclass(frozen=True)
class Aim:
    """Goals and limits; the limits of what is recommended are to hold with ``confidence``."""

    goals: tuple[Goal, ...]
    limits: tuple[Limit, ...] = ()
    confidence: float = 0.9

    @property
    def responses(self) -> list[int]:
        """The numbers of the responses that goals and limits name."""
        return [goal.response for goal in self.goals] + [limit.response for limit in self.limits]

    def gains(self, y: Array) -> Array:
        """Compute the goals, the larger the better, (goals, ...), of responses (m, ...)."""
        return np.array([goal.sign * y[goal.response] for goal in self.goals])

    def kept(self, y: Array) -> npt.NDArray[np.bool_]:
        """Tell where responses, (m, ...), keep all limits."""
        kept = np.ones(y.shape[1:], bool)
        for limit in self.limits:
            kept &= limit.sign * (y[limit.response] - limit.value) >= 0
        return kept

    def margin(self, mean: Array, deviation: Array) -> Array:
        """Compute by how many standard deviations the tightest limit is kept, (...).

        Infinite where there are no limits.
        """
        margins = [
            limit.sign * (mean[limit.response] - limit.value) / np.maximum(deviation[limit.response], 1e-12)
            for limit in self.limits
        ]
        return np.min(margins, axis=0) if margins else np.full(mean.shape[1:], np.inf)

    def log_probability(self, mean: Array, deviation: Array) -> Array:
        """Compute the logarithm, (...), of the probability that all limits are kept; errors of responses are
        independent."""
        result = np.zeros(mean.shape[1:])
        for limit in self.limits:
            distance = limit.sign * (mean[limit.response] - limit.value)
            result += stats.norm.logcdf(distance / np.maximum(deviation[limit.response], 1e-12))
        return result
