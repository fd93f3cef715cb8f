"""The loss of searches on noisy functions whose best settings are known: ``python -m tools.search_series
[SEEDS]``.

The tool makes whole searches with each surrogate and optimiser that a study offers, and with the way of the
paper on the FFS0827 (Box-Behnken plan, quadratic, whale).  The loss is what the recommended setting gives
away; on the hidden screens (``tests/design/functions.py``) a point of efficiency below the limit counts 0.053
m/s. Measured figures: docs/measured/design.md.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Annotated

import numpy as np
import typer

from orchestrator.ports import Array
from orchestrator.studies.design.aim import Aim, Goal, Limit
from orchestrator.studies.design.front import improvements
from orchestrator.studies.design.gaussian_process import GaussianProcess
from orchestrator.studies.design.models import SURROGATES
from orchestrator.studies.design.optimisers import OPTIMISERS, Whale
from orchestrator.studies.design.plans import box_behnken
from orchestrator.studies.design.quadratic import Quadratic
from orchestrator.studies.design.two_levels import TwoLevels
from tests.design import functions
from tests.design.functions import Problem, percent, study
from tests.design.test_search import SCREENS, judged, short_of_limits

GIVEN = (  # problem, its best value, runs of the start, of all
    ("Branin", functions.BRANIN, 0.397887, 12, 30),
    ("Hartmann, six factors", functions.HARTMANN, -3.32237, 20, 60),
    ("Gardner 1", functions.GARDNER_1, -2.0, 12, 30),
    ("Gardner 2", functions.GARDNER_2, 0.253236, 12, 30),
)
FRONTS = (
    ("ZDT1", functions.ZDT1, (-1.1, -1.1), 0.876667, 20),
    ("BNH", functions.BNH, (-140.0, -50.0), 5285.3333, 12),
)
METHODS = (
    ("gaussian-process", "expected-improvement"),
    ("gaussian-process", "sobol"),
    ("gaussian-process", "whale"),
    ("network", "whale"),
)


def main(seeds: Annotated[int, typer.Argument()] = 12) -> None:
    """Print a table of the losses on all problems."""
    print(
        "| problem | runs | method | median loss | worst loss | worst beyond a limit | time of a search / s |"
    )
    print("|---|---|---|---|---|---|---|")
    for screen in SCREENS:
        _print(f"screen, {screen}", 27, "Box-Behnken, quadratic, whale", seeds, partial(_paper, screen))
        for names in METHODS:
            _print(f"screen, {screen}", 27, ", ".join(names), seeds, partial(_screen, screen, names))
    for name, problem, best, start, total in GIVEN:
        _print(name, total, ", ".join(METHODS[0]), seeds, partial(_given, problem, best, start, total))
    for name, problem, reference, volume, start in FRONTS:
        for seed in range(1, 4):
            x, _, _ = study(
                problem,
                SURROGATES["gaussian-process"](),
                OPTIMISERS["expected-improvement"](),
                start,
                60,
                seed,
            )
            y = problem.truth(problem.space.actual(x))
            share = _area(problem.aim.gains(y)[:, problem.aim.kept(y)], np.array(reference)) / volume
            print(
                f"| {name} | 60 | hypervolume over the exact one, seed {seed} | {share:.4f} | | | |",
                flush=True,
            )
    print()
    print_levels(seeds)


def _area(gains: Array, reference: Array) -> float:
    """Return the area between points, (2, n), and a reference, (2,): what a corner beyond all of them would
    not add."""
    corner = gains.max(axis=1)
    return float(np.prod(corner - reference) - improvements(gains, reference, corner[:, None])[0])


def print_levels(seeds: int) -> None:
    """Print what a cheap level of many runs adds to few runs of a dear one, on the screen with the band.

    The cheap level has 0.62 of the efficiency's logit without half of the band, and a biased velocity.
    """
    problem = SCREENS["band"]
    test_x = problem.space.sample(512, 99)
    truth = problem.truth(test_x)
    print("| dear runs | cheap runs | Q2 of the velocity, median | of the efficiency, median | worst |")
    print("|---|---|---|---|---|")
    for dear, cheap in ((10, 0), (10, 60), (18, 0), (18, 60), (27, 0), (54, 0)):
        rows = np.array([_explained_by_levels(problem, test_x, truth, dear, cheap, s) for s in range(seeds)])
        velocity, efficiency = np.median(rows, axis=0)
        worst = rows[:, 1].min()
        print(f"| {dear} | {cheap} | {velocity:.3f} | {efficiency:.3f} | {worst:.3f} |", flush=True)


def _explained_by_levels(
    problem: Problem, test_x: Array, truth: Array, dear: int, cheap: int, seed: int
) -> Array:
    """Return the share of each response's variance over the space that the fitted surrogate explains."""
    rng, surrogate = np.random.default_rng(seed), GaussianProcess()
    x = problem.space.sample(dear, seed)
    y, variance = problem.observe(x, rng)
    if cheap:
        below_x = problem.space.sample(cheap, 100 + seed)
        velocity, logit = problem.truth(below_x)
        below = np.array([0.9 * velocity - 0.1, 0.31 * (logit + functions.screen(below_x)[1]) - 0.4])
        deviation = functions.screen_noise(below)
        below += deviation * rng.standard_normal(below.shape)
        fitted = TwoLevels(surrogate.fit(below_x, below.T, deviation.T**2, seed), surrogate).fit(
            x, y, variance, seed
        )
        mean, _ = fitted.predict(test_x)
    else:
        mean, _ = surrogate.fit(x, y, variance, seed).predict(test_x)
    return np.asarray(1.0 - ((mean - truth) ** 2).mean(axis=1) / truth.var(axis=1))


def _print(name: str, runs: int, method: str, seeds: int, loss: Callable[[int], tuple[float, float]]) -> None:
    begun_s = time.process_time()
    losses, beyond = np.array([loss(seed) for seed in range(1, seeds + 1)]).T
    each_s = (time.process_time() - begun_s) / seeds
    cells = f"{np.median(losses):.3f} | {losses.max():.3f} | {max(beyond.max(), 0.0):.2f} | {each_s:.1f}"
    print(f"| {name} | {runs} | {method} | {cells} |", flush=True)


def _screen(screen: str, names: tuple[str, str], seed: int) -> tuple[float, float]:
    surrogate, optimiser = SURROGATES[names[0]](), OPTIMISERS[names[1]]()
    start = 14 if names[0] == "network" else 13  # a network needs 14 points
    return judged(screen, study(SCREENS[screen], surrogate, optimiser, start, 27, seed)[2])


def _paper(screen: str, seed: int) -> tuple[float, float]:
    problem, rng = SCREENS[screen], np.random.default_rng(seed)
    x, aim = box_behnken(4), Aim((Goal(0, 1.0),), (Limit(1, 1.0, 80.0),))
    y, variance = problem.observe(x, rng)
    y[:, 1] = percent(y[:, 1])
    return judged(screen, Whale().propose(Quadratic().fit(x, y, variance, 1), aim, problem.space, x, rng))


def _given(problem: Problem, best: float, start: int, total: int, seed: int) -> tuple[float, float]:
    surrogate, optimiser = SURROGATES["gaussian-process"](), OPTIMISERS["expected-improvement"]()
    setting: Array = study(problem, surrogate, optimiser, start, total, seed)[2]
    value = float(problem.truth(problem.space.actual(setting[None]))[0, 0])
    return value - best, short_of_limits(problem, setting)


if __name__ == "__main__":
    typer.run(main)
