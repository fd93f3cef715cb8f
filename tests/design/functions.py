"""Functions with known best settings, as a study would meet them: noisy, and with limits.

Sources: L. C. W. Dixon, G. P. Szego, Towards Global Optimization 2 (1978) 1 (Branin, Hartmann); J. R. Gardner
et al., Proc. ICML (2014) 937 (with limits); E. Zitzler, K. Deb, L. Thiele, Evol. Comput. 8 (2000) 173,
doi:10.1162/106365600568202 (ZDT1); T. T. Binh, U. Korn (1997), as in K. Deb, Multi-Objective Optimization,
Wiley 2001 (BNH).  The two hidden screens are made up: ``screen`` has the shape of the paper's response
surface, and ``screen_with_band`` a band of frequencies beside it in which particles fly, which no quadratic
can follow.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array
from orchestrator.studies.design.aim import Aim, Goal, Limit
from orchestrator.studies.design.front import improvements
from orchestrator.studies.design.optimisers import Optimiser
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.surrogates import Fitted, Surrogate, calibrated


@dataclass(frozen=True)
class Problem:
    """Responses, (m, p), of actual settings, (p, f); standard deviations of their noise; what is wanted."""

    truth: Callable[[Array], Array]
    deviation: Callable[[Array], Array]
    space: Space
    aim: Aim

    def observe(self, coded: Array, rng: np.random.Generator) -> tuple[Array, Array]:
        """Run settings: responses and variances, both (p, m)."""
        truth = self.truth(self.space.actual(coded))
        deviation = self.deviation(truth)
        return (truth + deviation * rng.standard_normal(truth.shape)).T, deviation.T**2


def study(
    problem: Problem, surrogate: Surrogate, optimiser: Optimiser, start: int, total: int, seed: int
) -> tuple[Array, Fitted, Array]:
    """Run a study: a start that fills the space, then one proposal after the other.

    Returns the settings run, coded, the last fit, and what is recommended.
    """
    rng = np.random.default_rng(seed)
    x = problem.space.sample(start, seed)
    y, variance = problem.observe(x, rng)
    while len(x) < total:
        new = optimiser.propose(surrogate.fit(x, y, variance, seed), problem.aim, problem.space, x, rng)
        more = problem.observe(new[None], rng)
        x, y, variance = np.vstack([x, new]), np.vstack([y, more[0]]), np.vstack([variance, more[1]])
    fitted = calibrated(surrogate.fit(x, y, variance, seed), y, variance)
    return x, fitted, optimiser.recommend(fitted, problem.aim, problem.space, x, rng)


def constant(*deviations: float) -> Callable[[Array], Array]:
    """Noise that is the same everywhere."""
    return lambda truth: np.broadcast_to(np.array(deviations)[:, None], truth.shape)


def screen(x: Array, band: float = 0.0) -> Array:
    """Velocity in m/s and efficiency, as its logit, of a screen; slope, stroke, frequency, tension in -1 ...
    1."""
    b, a, f, d = x.T
    g = (
        1.62
        - 1.9 * b
        - 0.75 * a
        - 0.07 * f
        - 0.11 * d
        - 0.15 * a * b
        - 0.10 * f * b
        + 0.12 * b**2
        - 0.22 * d**2
    )
    v = 1.32 + 0.71 * b + 0.16 * a + 0.05 * f + 0.08 * d + 0.07 * a * b + 0.06 * f * b
    v += -0.045 * a**2 + 0.045 * b**2 + 0.06 * d**2
    r = band * np.exp(-(((f - 0.15 - 0.45 * d) / 0.30) ** 2))
    return np.array([v + 0.10 * r * (1 + a), g - 1.1 * r * (1 + 0.4 * a)])


def screen_with_band(x: Array) -> Array:
    """The same with a band of frequencies, which tension shifts, in which particles fly."""
    return screen(x, 1.0)


def percent(logit: Array) -> Array:
    """The efficiency in percent of its logit."""
    return 100.0 / (1.0 + np.exp(-np.asarray(logit)))


def screen_noise(truth: Array) -> Array:
    """Return the noise of a run, of the velocity and of the logit of the efficiency."""
    share = percent(truth[1])
    deviation = 0.25 + 1.08 * np.sqrt(share * (100.0 - share)) / 50.0
    return np.array([0.010 + 0.008 * truth[0], deviation * 100.0 / (share * (100.0 - share))])


def branin(x: Array) -> Array:
    """Smallest 0.397887 at (-pi, 12.275), (pi, 2.275), (9.42478, 2.475)."""
    a, b = x.T
    bend = b - 5.1 / (4 * np.pi**2) * a**2 + 5 / np.pi * a - 6
    return (bend**2 + 10 * (1 - 1 / (8 * np.pi)) * np.cos(a) + 10)[None]


def hartmann(x: Array) -> Array:
    """Smallest -3.32237 at (0.20169, 0.150011, 0.476874, 0.275332, 0.311652, 0.6573)."""
    heights = np.array([1.0, 1.2, 3.0, 3.2])
    widths = np.array(
        [
            [10, 3, 17, 3.5, 1.7, 8],
            [0.05, 10, 17, 0.1, 8, 14],
            [3, 3.5, 1.7, 10, 17, 8],
            [17, 8, 0.05, 10, 0.1, 14],
        ]
    )
    centres = 1e-4 * np.array(
        [
            [1312, 1696, 5569, 124, 8283, 5886],
            [2329, 4135, 8307, 3736, 1004, 9991],
            [2348, 1451, 3522, 2883, 3047, 6650],
            [4047, 8828, 8732, 5743, 1091, 381],
        ]
    )
    distance = (widths * (x[:, None, :] - centres) ** 2).sum(axis=2)
    return -(heights * np.exp(-distance)).sum(axis=1)[None]


def gardner_1(x: Array) -> Array:
    """Smallest -2 at (4.712389, 0) where the second is at most 0.5."""
    a, b = x.T
    return np.array([np.cos(2 * a) * np.cos(b) + np.sin(a), np.cos(a + b)])


def gardner_2(x: Array) -> Array:
    """Smallest 0.253236 at (4.712389, 1.253236) where the second is at most -0.95 (1.76 % of the square)."""
    a, b = x.T
    return np.array([np.sin(a) + b, np.sin(a) * np.sin(b)])


def zdt1(x: Array) -> Array:
    """Two goals to be small; the front's hypervolume over (1.1, 1.1) is 0.876667."""
    g = 1 + 9 * x[:, 1:].mean(axis=1)
    return np.array([x[:, 0], g * (1 - np.sqrt(x[:, 0] / g))])


def bnh(x: Array) -> Array:
    """Two goals to be small and two limits; the front's hypervolume over (140, 50) is 5285.3333."""
    a, b = x.T
    return np.array(
        [4 * a**2 + 4 * b**2, (a - 5) ** 2 + (b - 5) ** 2, (a - 5) ** 2 + b**2, (a - 8) ** 2 + (b + 3) ** 2]
    )


def _space(low: float | list[float], high: float | list[float], factors: int) -> Space:
    return Space(
        np.broadcast_to(np.array(low, float), factors), np.broadcast_to(np.array(high, float), factors)
    )


EFFICIENT = Aim((Goal(0, 1.0),), (Limit(1, 1.0, float(np.log(80 / 20))),))
SCREEN = Problem(screen, screen_noise, _space(-1, 1, 4), EFFICIENT)
SCREEN_WITH_BAND = Problem(screen_with_band, screen_noise, _space(-1, 1, 4), EFFICIENT)
BEST_VELOCITY = {"plain": 1.542, "band": 1.540}
SMALL = Aim((Goal(0, -1.0),))
BRANIN = Problem(branin, constant(1.0), _space([-5, 0], [10, 15], 2), SMALL)
HARTMANN = Problem(hartmann, constant(0.03), _space(0, 1, 6), SMALL)
GARDNER_1 = Problem(
    gardner_1, constant(0.05, 0.05), _space(0, 6, 2), Aim((Goal(0, -1.0),), (Limit(1, -1.0, 0.5),))
)
GARDNER_2 = Problem(
    gardner_2, constant(0.05, 0.02), _space(0, 6, 2), Aim((Goal(0, -1.0),), (Limit(1, -1.0, -0.95),))
)
TWO_SMALL = (Goal(0, -1.0), Goal(1, -1.0))
ZDT1 = Problem(zdt1, constant(0.0, 0.0), _space(0, 1, 4), Aim(TWO_SMALL))
BNH = Problem(
    bnh,
    constant(0.0, 0.0, 0.0, 0.0),
    _space(0, [5, 3], 2),
    Aim(TWO_SMALL, (Limit(2, -1.0, 25.0), Limit(3, 1.0, 7.7))),
)


def hypervolume(gains: Array, reference: Array) -> float:
    """Compute the area above the reference, (2,), that points, (2, n), dominate."""
    total, front = 0.0, np.empty((2, 0))
    for point in gains.T:
        total += float(improvements(front, reference, point[:, None])[0])
        front = np.column_stack([front, point])
    return total
