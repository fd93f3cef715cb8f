"""Maxwell branches fitted to a measured loss factor.

Branches (g_i, tau_i) beside an elastic modulus make the loss factor at the angular frequency w

    eta = sum g_i x_i / (1 + x_i^2) / (1 + sum g_i x_i^2 / (1 + x_i^2)),   x_i = w tau_i,

whose denominator is the storage modulus over the elastic modulus (Ferry, Viscoelastic Properties of
Polymers, 3rd ed. 1980, chapter 3).  For given relaxation times the fit is linear in the g_i, and
non-negative least squares minimise its relative errors (Lawson and Hanson, Solving Least Squares
Problems, 1974, chapter 23).  The fit follows the whole curve, which is straight in logarithms between
its points.  The logarithms of the times are evenly spaced between two ends, and several pairs of ends
are tried.  The result has the fewest branches that meet the curve.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import pairwise, product

import numpy as np

from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.tables.case import Case, Hyperelastic, MaxwellBranch
from orchestrator.ports import Array

MOST_BRANCHES = 8
GOOD = 0.03
"""Relative error below which a fit needs no more branches."""
WORST = 0.1
"""Relative error above which a fit does not meet the curve; measured curves scatter by some per cent."""
PER_DECADE = 8
ENDS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0, 8.0)
"""Factors for the range of the times, which reach from 1 / (highest w x end) to end / lowest w."""

Branches = tuple[tuple[float, float], ...]
Point = tuple[float, float, float | None]


@dataclass(frozen=True)
class Fit:
    """Branches (g, tau in s) fitted to a curve, and their largest relative error, which occurs ``at_Hz``."""

    branches: Branches
    error: float
    at_Hz: float


def moduli(branches: Branches, speed_rad_per_s: Array) -> tuple[Array, Array]:
    """Return the storage modulus over the elastic modulus (n,) and the loss factor (n,).

    ``speed_rad_per_s`` (n,) are angular frequencies.
    """
    ratio, time_s = np.array(branches, dtype=np.float64).reshape(-1, 2).T
    x = np.outer(speed_rad_per_s, time_s)
    storage = 1.0 + x**2 / (1.0 + x**2) @ ratio
    return storage, x / (1.0 + x**2) @ ratio / storage


def fit_loss_curves(case: Case) -> Case:
    """Return the case with branches for all materials that have a ``loss_curve`` but no branches.

    Raises CaseError for curves that no branches, or not the given ones, meet, and for frequencies that do not
    rise.
    """
    materials, problems = dict(case.materials), []
    for name, material in case.materials.items():
        law = material.hyperelastic
        if law is None or not law.loss_curve:
            continue
        faults = [*_faults(name, law)]
        if not faults and law.maxwell:
            faults = [*_stale_branches(name, law)]
        elif not faults:
            fit = fit_branches(curve_points(law))
            faults = [*_misfits(name, fit)]
            maxwell = tuple(MaxwellBranch(ratio=g, relaxation_s=tau) for g, tau in fit.branches)
            law = law.model_copy(update={"maxwell": maxwell})
            materials[name] = material.model_copy(update={"hyperelastic": law})
        problems += faults
    if problems:
        raise CaseError(problems)
    return case.model_copy(update={"materials": materials})


def curve_points(law: Hyperelastic) -> tuple[Point, ...]:
    """Return the points of a material's loss curve: frequency in Hz, loss factor and storage ratio."""
    return tuple((p.frequency_Hz, p.loss_factor, p.storage_ratio) for p in law.loss_curve)


@cache
def fit_branches(points: tuple[Point, ...]) -> Fit:
    """Return the fit with the fewest branches that are good enough, or else the best fit of all."""
    curve = _interpolate(points)
    best = Fit((), np.inf, curve[0][0])
    for count in range(1, MOST_BRANCHES + 1):
        fits = [_fit_ratios(curve, time_s) for time_s in _times(curve, count)]
        best = min([best, *fits], key=lambda fit: fit.error)
        if best.error <= GOOD:
            break
    return best


def compare_with_curve(branches: Branches, points: Sequence[Point]) -> Fit:
    """Return a fit of these branches, with their largest relative error along the curve."""
    return _measure(branches, _interpolate(points))


def _interpolate(points: Sequence[Point]) -> list[Point]:
    """Return at least ``PER_DECADE`` points per decade of the curve, which is straight in logarithms."""
    curve = list(points[:1])
    for one, other in pairwise(points):
        count = int(np.ceil(PER_DECADE * np.log10(other[0] / one[0])))
        curve += [_between(one, other, share) for share in np.arange(1, count + 1) / count]
    return curve


def _between(one: Point, other: Point, share: float) -> Point:
    frequency_Hz, loss = (a ** (1 - share) * b**share for a, b in zip(one[:2], other[:2], strict=True))
    if one[2] is None or other[2] is None:
        return frequency_Hz, loss, None
    return frequency_Hz, loss, one[2] ** (1 - share) * other[2] ** share


def _measure(branches: Branches, curve: Sequence[Point]) -> Fit:
    frequency_Hz = np.array([point[0] for point in curve])
    storage, loss = moduli(branches, 2 * np.pi * frequency_Hz)
    error = np.abs(loss / np.array([point[1] for point in curve]) - 1)
    given = np.array([np.nan if point[2] is None else point[2] for point in curve])
    error = np.fmax(error, np.abs(storage / given - 1))
    return Fit(branches, float(error.max()), float(frequency_Hz[error.argmax()]))


def _times(curve: Sequence[Point], count: int) -> Iterator[Array]:
    """Yield sets of ``count`` relaxation times in s, one for each pair of ends."""
    slowest, fastest = 2 * np.pi * curve[0][0], 2 * np.pi * curve[-1][0]
    for low, high in product(ENDS, ENDS):
        shortest_s, longest_s = 1 / (fastest * low), high / slowest
        if count == 1:
            yield np.array([np.sqrt(shortest_s * longest_s)])
        elif shortest_s < longest_s:
            yield np.geomspace(shortest_s, longest_s, count)


def _fit_ratios(curve: Sequence[Point], time_s: Array) -> Fit:
    """Return the best fit of branches with given relaxation times; branches with a ratio of 0 drop out."""
    from scipy.optimize import nnls

    x = 2 * np.pi * np.outer([point[0] for point in curve], time_s)
    loss, storage = x / (1.0 + x**2), x**2 / (1.0 + x**2)
    rows = [line / eta - more for line, more, (_, eta, _) in zip(loss, storage, curve, strict=True)]
    wanted = [1.0] * len(rows)
    for more, (_, _, given) in zip(storage, curve, strict=True):
        if given is not None:
            rows.append(more / given)
            wanted.append(1.0 - 1.0 / given)
    ratio, _ = nnls(np.array(rows), np.array(wanted))
    used = ratio > 0
    pairs = tuple(zip(ratio[used].tolist(), time_s[used].tolist(), strict=True))
    return _measure(pairs, curve)


def _faults(name: str, law: Hyperelastic) -> Iterator[CaseProblem]:
    """Yield a problem if the frequencies of a material's loss curve do not rise."""
    frequencies = [point.frequency_Hz for point in law.loss_curve]
    if frequencies != sorted(set(frequencies)):
        yield CaseProblem(_key(name), "frequencies must rise from row to row")


def _stale_branches(name: str, law: Hyperelastic) -> Iterator[CaseProblem]:
    """Yield a problem if the branches that a material gives do not meet its loss curve."""
    off = compare_with_curve(tuple((row.ratio, row.relaxation_s) for row in law.maxwell), curve_points(law))
    if off.error > WORST:
        what = f"its Maxwell branches do not fit it: off by {off.error:.0%} at {off.at_Hz:g} Hz"
        yield CaseProblem(_key(name), what, "leave out maxwell, which is then fitted anew")


def _misfits(name: str, fit: Fit) -> Iterator[CaseProblem]:
    """Yield a problem if the best fit does not meet a material's loss curve."""
    if fit.error > WORST:
        what = (
            f"no {MOST_BRANCHES} Maxwell branches fit it: the best are off by {fit.error:.0%} "
            f"at {fit.at_Hz:g} Hz"
        )
        hint = "their loss factor rises and falls no faster than the frequency; smooth the curve"
        yield CaseProblem(_key(name), what, hint)


def _key(name: str) -> Key:
    return ("materials", name, "hyperelastic", "loss_curve")
