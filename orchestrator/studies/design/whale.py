"""The whale algorithm.

Source: S. Mirjalili, A. Lewis, Adv. Eng. Softw. 95 (2016) 51, doi:10.1016/j.advengsoft.2016.01.008; Eqs. 11
to 14 of the paper on the FFS0827.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from orchestrator.studies.design.space import Space
from orchestrator.workbench.vocabulary import Array

SPIRAL = 1.0  # b of Eq. 11


def whale_search(
    worth: Callable[[Array], Array],
    space: Space,
    rng: np.random.Generator,
    whales: int = 30,
    iterations: int = 200,
) -> Array:
    """Search the setting, coded, (factors,), with the largest worth; ``worth`` takes (p, factors).

    A, C and l are drawn for each coordinate of each whale: with one number for all of them whales move only
    along lines through each other and the centre, and stop several percent short of a best on the borders.
    """
    x = space.sample(whales, int(rng.integers(2**31)))
    values = worth(x)
    best: Array = x[np.argmax(values)].copy()
    best_value = values.max()
    for iteration in range(iterations):
        a = 2.0 * (1.0 - iteration / iterations)
        step = (2.0 * rng.random(x.shape) - 1.0) * a  # A
        weight = 2.0 * rng.random(x.shape)  # C
        angle = rng.uniform(-1.0, 1.0, x.shape)  # l
        leader = np.where(np.abs(step) > 1.0, x[rng.integers(whales, size=whales)], best)
        encircled = leader - step * np.abs(weight * leader - x)
        spiral = np.abs(best - x) * np.exp(SPIRAL * angle) * np.cos(2.0 * np.pi * angle) + best
        x = space.ordered(np.where(rng.random((whales, 1)) < 0.5, encircled, spiral))
        values = worth(x)
        if values.max() > best_value:
            best, best_value = x[np.argmax(values)].copy(), values.max()
    return best
