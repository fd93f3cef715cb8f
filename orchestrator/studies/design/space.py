"""The space of the factors: ranges, orders among factors, and the coding of settings to -1 ... 1."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.stats import qmc

from orchestrator.workbench.vocabulary import Array


@dataclass(frozen=True)
class Space:
    """Ranges of factors, and chains of factors whose values must not rise.

    A setting is coded: -1 is the lower end of a factor's range and 1 the upper one.  Each chain is
    a tuple of factors' numbers, all of one range; ``x[chain[0]] >= x[chain[1]] >= ...`` holds.
    """

    low: Array
    high: Array
    chains: tuple[tuple[int, ...], ...] = ()

    @property
    def factors(self) -> int:
        """The number of factors."""
        return len(self.low)

    def coded(self, actual: Array) -> Array:
        """Settings in units of the factors, (..., factors), as coded ones."""
        return (2.0 * np.asarray(actual) - self.low - self.high) / (self.high - self.low)

    def actual(self, coded: Array) -> Array:
        """Coded settings, (..., factors), in the factors' units."""
        return 0.5 * (self.low + self.high + np.asarray(coded) * (self.high - self.low))

    def ordered(self, coded: Array) -> Array:
        """Settings moved into the space: cut to the ranges, and each chain sorted.

        Sorting maps a uniform sample of the cube onto a uniform sample of the ordered part of it.
        """
        inside = np.clip(coded, -1.0, 1.0)
        for chain in self.chains:
            columns = list(chain)
            inside[..., columns] = -np.sort(-inside[..., columns], axis=-1)
        return inside

    def simplify(self, coded: Array) -> Array:
        """Return settings, (n, factors), as they are: no factor follows from others."""
        return coded

    def sample(self, count: int, seed: int) -> Array:
        """Scrambled Sobol points, (count, factors): any first part of them fills the space evenly.

        Source: I. M. Sobol', USSR Comput. Math. Math. Phys. 7 (1967) 86, doi:10.1016/0041-5553(67)90144-9;
        scrambling by A. B. Owen, J. Complexity 14 (1998) 466, doi:10.1006/jcom.1998.0487.
        """
        sampler = qmc.Sobol(self.factors, scramble=True, seed=seed)
        points = sampler.random_base2(int(np.ceil(np.log2(max(count, 2)))))[:count]
        return self.ordered(2.0 * points - 1.0)

    def candidates(self, near: Array, count: int, rng: np.random.Generator) -> Array:
        """Settings worth looking at: all over the space, on its borders, and around those of ``near``.

        Optima of screens lie where factors stand at their limits, which a sample of the inside never
        meets: a third of the points has some coordinates moved to an end of their range.
        """
        everywhere = self.sample(count, int(rng.integers(2**31)))
        borders = self.sample(count, int(rng.integers(2**31)))
        ends = rng.choice([-1.0, 1.0], borders.shape)
        borders = np.where(rng.random(borders.shape) < rng.uniform(0.2, 0.9, (count, 1)), ends, borders)
        parts = [everywhere, borders]
        if len(near):
            around = near[rng.integers(len(near), size=count)]
            width = 10.0 ** rng.uniform(-2.5, -0.3, (count, 1))
            moved = rng.random(around.shape) < 0.6
            parts.append(around + moved * width * rng.standard_normal(around.shape))
        return self.ordered(np.vstack(parts))


@dataclass(frozen=True)
class SimplerSpace(Space):
    """The part of a space in which some factors follow from the others; ``formulas`` puts them in."""

    formulas: Callable[[Array], Array] = lambda coded: coded

    def simplify(self, coded: Array) -> Array:
        """Put the factors that follow from the others into settings, (n, factors)."""
        return self.formulas(coded)

    def ordered(self, coded: Array) -> Array:
        """Move settings, (n, factors), into the part of the space."""
        return Space.ordered(self, self.simplify(Space.ordered(self, coded)))


@dataclass(frozen=True)
class SpaceWithout(Space):
    """A space without the neighbourhoods, of half the width ``distance``, of the settings ``left_out``,
    (n, factors)."""

    left_out: Array = field(default_factory=lambda: np.empty((0, 0)))
    distance: float = 0.0

    def holds(self, x: Array) -> npt.NDArray[np.bool_]:
        """Tell which settings, (n, factors), are in none of the neighbourhoods."""
        if not len(self.left_out):
            return np.ones(len(x), bool)
        apart = np.abs(x[:, None, :] - self.left_out[None]).max(axis=2)
        return np.asarray(apart.min(axis=1) > self.distance)

    def candidates(self, near: Array, count: int, rng: np.random.Generator) -> Array:
        """List the settings worth looking at that are in the space; all of them where none is."""
        candidates = super().candidates(near, count, rng)
        holds = self.holds(candidates)
        return candidates[holds] if holds.any() else candidates
