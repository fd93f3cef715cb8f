"""Plans: the coded settings at which a study runs first."""

from __future__ import annotations

from itertools import combinations, product

import numpy as np
from scipy.stats import qmc

from orchestrator.studies.design.space import Space
from orchestrator.workbench.vocabulary import Array

# the factors that are moved together, of each block; two at a time up to five factors
TRIPLES = {
    6: [(0, 1, 3), (1, 2, 4), (2, 3, 5), (0, 3, 4), (1, 4, 5), (0, 2, 5)],
    7: [(3, 4, 5), (0, 5, 6), (1, 4, 6), (0, 1, 3), (2, 3, 6), (0, 2, 4), (1, 2, 5)],
}
MOST_BOX_BEHNKEN = 7


def box_behnken(factors: int, centres: int = 3) -> Array:
    """List the Box-Behnken design, (runs, factors): the middles of the cube's edges, and the centre.

    Source: G. E. P. Box, D. W. Behnken, Technometrics 2 (1960) 455, doi:10.1080/00401706.1960.10489912.
    Raises ValueError where there is no such design for this number of factors (3 to 7).
    """
    if not 3 <= factors <= MOST_BOX_BEHNKEN:
        raise ValueError(
            f"a Box-Behnken design has 3 to {MOST_BOX_BEHNKEN} factors, not {factors}; sobol has any"
        )
    rows = []
    for block in TRIPLES.get(factors, list(combinations(range(factors), 2))):
        for ends in product((-1.0, 1.0), repeat=len(block)):
            row = np.zeros(factors)
            row[list(block)] = ends
            rows.append(row)
    return np.array(rows + [np.zeros(factors)] * centres)


def latin_hypercube(space: Space, count: int, seed: int) -> Array:
    """List a Latin hypercube, (count, factors), of random settings moved apart.

    Source: M. D. McKay, R. J. Beckman, W. J. Conover, Technometrics 21 (1979) 239, doi:10.2307/1268522.
    """
    sampler = qmc.LatinHypercube(space.factors, optimization="random-cd", seed=seed)
    return space.ordered(2.0 * sampler.random(count) - 1.0)


def factorial(space: Space, levels: int) -> Array:
    """List the full factorial, (levels ** factors, factors), of the settings that the space allows."""
    grid = np.array(list(product(np.linspace(-1.0, 1.0, levels), repeat=space.factors)))
    return np.asarray(grid[(space.ordered(grid.copy()) == grid).all(axis=1)])
