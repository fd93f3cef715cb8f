"""Springs with friction and Maxwell elements, fitted to the measured curve of a bushing.

Under a harmonic deformation of amplitude A and angular frequency w, the force of such a bushing has a first
harmonic k' A in phase and k'' A a quarter of a cycle ahead.  The elements are in parallel, so that k' and k''
are sums:

    spring     k' = k,                            k'' = 0
    friction   k' = k (t - sin t cos t) / pi,     k'' = 4 k (s / A) (1 - s / A) / pi,   cos t = 1 - 2 s / A
    Maxwell    k' = k x^2 / (1 + x^2),            k'' = k x / (1 + x^2),                x = w T

where a friction element slips at the stretch s < A (below it, it is a spring), and T is the relaxation time.
The energy lost in a cycle is pi k'' A^2, and the loss factor k'' / k'.  (Iwan, Journal of Applied Mechanics
33, 1966, 893-900, doi 10.1115/1.3625199; Ferry, Viscoelastic Properties of Polymers, 3rd ed. 1980, chapter
3.)

For given s and T the stiffnesses follow by non-negative least squares of the relative errors of k' and k''
(Lawson and Hanson, Solving Least Squares Problems, 1974, chapter 23).  The logarithms of s and T are then
improved by least squares around that (variable projection: Golub and Pereyra, Inverse Problems 19, 2003,
R1-R26, doi 10.1088/0266-5611/19/2/201).  The fit has the fewest elements that meet the points, or is the
closest of all.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from itertools import chain, groupby
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.file.bushing_loop import points_of
from orchestrator.case.file.data_file import read_with
from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.file.units import in_own_units
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.frames import Bushing, BushingCurve, CurvePoint, FrictionElement, MaxwellElement
from orchestrator.ports import Array

MOST_FRICTION = 4
MOST_MAXWELL = 3
GOOD = 0.03
"""Relative error of stiffness and loss below which a fit needs no more elements."""
BETTER = 0.9
"""A fit with more elements must have an error smaller by this factor."""
WORST = 0.15
"""Relative error of the stiffness above which a fit does not meet the curve."""
WORST_LOSS = 0.5
"""Relative error of the loss factor above which a fit does not meet the curve."""
LOSS_WEIGHT = 0.3
"""Weight of errors of k'' against those of k': measured losses scatter more."""
LEAST_LOSS = 0.01
"""Loss factor to which errors of smaller loss factors are related."""
FAR = 1.5
"""Factor by which the linear stiffness may leave the range of the measured ones."""

Point = tuple[float, float, float, float]
"""Amplitude in m, frequency in Hz, k' in N/m and loss factor."""


@dataclass(frozen=True)
class Elements:
    """A spring of stiffness ``elastic_N_per_m``, friction elements (stiffness in N/m, slip in m) and Maxwell
    elements (stiffness in N/m, relaxation time in s)."""

    elastic_N_per_m: float
    friction: tuple[tuple[float, float], ...]
    maxwell: tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class CurveFit:
    """Elements fitted to points, and their largest relative errors of stiffness and loss factor."""

    elements: Elements
    stiffness_error: float
    loss_error: float

    @property
    def error(self) -> float:
        """The larger error, with the loss's weight."""
        return max(self.stiffness_error, LOSS_WEIGHT * self.loss_error)


def harmonic_stiffness(elements: Elements, amplitude_m: Array, frequency_Hz: Array) -> tuple[Array, Array]:
    """Return k' and k'' in N/m, (n,) each, at these amplitudes and frequencies, (n,) each."""
    slip_m, relaxation_s = (
        np.array([row[1] for row in rows]) for rows in (elements.friction, elements.maxwell)
    )
    in_phase, ahead = _shares(amplitude_m, frequency_Hz, slip_m, relaxation_s)
    stiffness = [elements.elastic_N_per_m, *(row[0] for row in (*elements.friction, *elements.maxwell))]
    return in_phase @ stiffness, ahead @ stiffness


def steady_loop(elements: Elements, amplitude_m: float, frequency_Hz: float) -> tuple[Array, Array]:
    """Return deformation and force of a cycle of harmonic deformation, (401,) each, from its largest value
    on."""
    angle = np.linspace(0, 2 * np.pi, 401)
    deformation_m, lag_m = amplitude_m * np.cos(angle), -amplitude_m * np.sin(angle)
    force_N = elements.elastic_N_per_m * deformation_m
    for stiffness_N_per_m, relaxation_s in elements.maxwell:
        x = 2 * np.pi * frequency_Hz * relaxation_s
        force_N = force_N + stiffness_N_per_m * x * (x * deformation_m + lag_m) / (1 + x**2)
    for stiffness_N_per_m, slip_m in elements.friction:
        stretch_m = [min(amplitude_m, slip_m)]
        for step_m in np.diff(deformation_m).tolist():
            stretch_m.append(min(max(stretch_m[-1] + step_m, -slip_m), slip_m))
        force_N = force_N + stiffness_N_per_m * np.array(stretch_m)
    return deformation_m, force_N


def elements_of(curve: BushingCurve) -> Elements:
    """Return the elements of a curve that was fitted, or whose case gives them."""
    assert curve.elastic_N_per_m is not None, "fit_bushing_curves fits every curve"
    return Elements(
        curve.elastic_N_per_m,
        tuple((row.stiffness_N_per_m, row.slip_m) for row in curve.friction),
        tuple((row.stiffness_N_per_m, row.relaxation_s) for row in curve.maxwell),
    )


def compare_with_points(curve: BushingCurve) -> CurveFit:
    """Return the errors of a curve's elements at its points."""
    return _measure(elements_of(curve), curve_points(curve))


def curve_points(curve: BushingCurve) -> tuple[Point, ...]:
    """Return the measured points of a curve."""
    return tuple(
        (point.amplitude_m, point.frequency_Hz, point.stiffness_N_per_m, _loss_factor(point))
        for point in curve.points
    )


def fit_bushing_curves(case: Case) -> Case:
    """Return the case with elements for all bushings' curves that have points but no elements.

    Raises CaseError for curves that no elements meet, and for every fault in them.
    """
    rows, problems = dict(case.screen.bushings), []
    for name, bushing in rows.items():
        if not bushing.curves:
            continue
        faults = [*_faults(name, bushing)]
        if not faults:
            curves = [_fitted(curve) for curve in bushing.curves]
            rows[name] = bushing.model_copy(update={"curves": tuple(curves)})
            faults = [*_misfits(name, bushing.curves, curves)]
        problems += faults
    if problems:
        raise CaseError(problems)
    return case.model_copy(update={"screen": case.screen.model_copy(update={"bushings": rows})})


def read_curve_files(table: dict[str, Any], folder: Path, source: str) -> Iterator[CaseProblem]:
    """Put the points of each file that a bushing's curve names into a case's table, in the place of its name.

    Yield all mistakes in the files; a table of another form is left to the check of the tables.
    """
    for key, curve in bushing_rows(table, "curves"):
        files = curve.get("file")
        files = files if isinstance(files, list) else [files]
        if not all(isinstance(file, str) for file in files):
            continue
        told = in_own_units(curve).get("frequency_Hz")
        frequency_Hz = float(told) if isinstance(told, int | float) else None
        read = partial(points_of, frequency_Hz=frequency_Hz)
        try:
            points = [read_with(read, curve, folder, file, (*key, "file"), source) for file in files]
        except CaseError as error:
            yield from error.problems
            continue
        curve["points"] = [*chain(*points)]
        for word in ("file", "columns", "decimal", "frequency_Hz"):
            curve.pop(word, None)


def bushing_rows(table: dict[str, Any], word: str) -> Iterator[tuple[Key, dict[str, Any]]]:
    """Yield key and table of each element of a list, such as "curves", of each bushing of a case's table."""
    screen = table.get("screen")
    bushings = screen.get("bushings") if isinstance(screen, dict) else None
    for name, bushing in bushings.items() if isinstance(bushings, dict) else ():
        rows = bushing.get(word) if isinstance(bushing, dict) else None
        for number, row in enumerate(rows if isinstance(rows, list) else []):
            if isinstance(row, dict):
                yield ("screen", "bushings", name, word, number), row


@cache
def fit_points(points: tuple[Point, ...]) -> CurveFit:
    """Return the fit with the fewest elements that is good enough, or else the closest of all."""
    amplitude_m, frequency_Hz = (np.unique([point[number] for point in points]) for number in (0, 1))
    most_friction = min(MOST_FRICTION, 2 * len(amplitude_m) - 1)
    most_maxwell = min(MOST_MAXWELL, 2 * len(frequency_Hz) - 1)
    counts = [(n, m) for n in range(most_friction + 1) for m in range(most_maxwell + 1)]
    best: CurveFit | None = None
    for count in sorted(counts, key=sum):
        fit = _fit(points, *count)
        if best is None or fit.error < BETTER * best.error:
            best = fit
        if best.error <= GOOD:
            break
    assert best is not None, "there is at least the spring alone"
    return best


def _fit(points: Sequence[Point], friction: int, maxwell: int) -> CurveFit:
    """Return the fit with so many elements at most; elements without stiffness drop out."""
    from scipy.optimize import least_squares

    amplitude_m, frequency_Hz = (np.array([point[number] for point in points]) for number in (0, 1))
    slowest, fastest = 2 * np.pi * frequency_Hz.min(), 2 * np.pi * frequency_Hz.max()
    start = np.log([*_spread(amplitude_m.min() / 3, amplitude_m.max() / 2, friction)])
    start = np.append(start, np.log([*_spread(0.5 / fastest, 2 / slowest, maxwell)]))
    low = np.log([amplitude_m.min() / 30] * friction + [0.1 / fastest] * maxwell)
    high = np.log([amplitude_m.max() * 0.99] * friction + [10 / slowest] * maxwell)

    def residual(logarithms: Array) -> Array:
        return _project(points, *np.split(np.exp(logarithms), [friction]))[1]

    if len(start):
        start = least_squares(residual, np.clip(start, low, high), bounds=(low, high), max_nfev=30).x
    slip_m, relaxation_s = np.split(np.exp(start), [friction])
    stiffness, _ = _project(points, slip_m, relaxation_s)
    pairs = [*zip(stiffness[1:].tolist(), [*slip_m.tolist(), *relaxation_s.tolist()], strict=True)]
    kept = [tuple(pair for pair in part if pair[0] > 0) for part in (pairs[:friction], pairs[friction:])]
    return _measure(Elements(float(stiffness[0]), kept[0], kept[1]), points)


def _spread(low: float, high: float, count: int) -> Array:
    """Return ``count`` numbers between two ends, evenly spaced in logarithms; the middle if it is one."""
    return np.geomspace(low, high, count) if count > 1 else np.array([np.sqrt(low * high)] * count)


def _project(points: Sequence[Point], slip_m: Array, relaxation_s: Array) -> tuple[Array, Array]:
    """Return the best stiffnesses (1 + elements,) in N/m, and the weighted relative errors (2 points,)."""
    from scipy.optimize import nnls

    amplitude_m, frequency_Hz, stiffness, loss = np.array(points).T
    in_phase, ahead = _shares(amplitude_m, frequency_Hz, slip_m, relaxation_s)
    size = stiffness.mean()
    wanted = LOSS_WEIGHT * loss / np.maximum(loss, LEAST_LOSS)
    per_loss = LOSS_WEIGHT * size / (stiffness * np.maximum(loss, LEAST_LOSS))
    rows = np.vstack([in_phase * (size / stiffness)[:, None], ahead * per_loss[:, None]])
    target = np.concatenate([np.ones(len(stiffness)), wanted])
    scaled, _ = nnls(rows, target)
    return size * scaled, rows @ scaled - target


def _shares(
    amplitude_m: Array, frequency_Hz: Array, slip_m: Array, relaxation_s: Array
) -> tuple[Array, Array]:
    """Return k' / k and k'' / k, (n, 1 + elements) each, of the spring, friction and Maxwell elements."""
    ratio = np.minimum(np.divide.outer(1 / amplitude_m, 1 / slip_m), 1.0)  # s / A
    angle = np.arccos(1 - 2 * ratio)
    x = 2 * np.pi * np.multiply.outer(frequency_Hz, relaxation_s)
    in_phase = [np.ones((len(x), 1)), (angle - np.sin(angle) * np.cos(angle)) / np.pi, x**2 / (1 + x**2)]
    ahead = [np.zeros((len(x), 1)), 4 * ratio * (1 - ratio) / np.pi, x / (1 + x**2)]
    return np.hstack(in_phase), np.hstack(ahead)


def _measure(elements: Elements, points: Sequence[Point]) -> CurveFit:
    """Return a fit of these elements with their largest errors at the points; zero without points."""
    if not points:
        return CurveFit(elements, 0.0, 0.0)
    amplitude_m, frequency_Hz, stiffness, loss = np.array(points).T
    in_phase, ahead = harmonic_stiffness(elements, amplitude_m, frequency_Hz)
    lost = np.abs(ahead / in_phase - loss) / np.maximum(loss, LEAST_LOSS)
    return CurveFit(elements, float(np.abs(in_phase / stiffness - 1).max()), float(lost.max()))


def _fitted(curve: BushingCurve) -> BushingCurve:
    if curve.elastic_N_per_m is not None:
        return curve
    elements = fit_points(curve_points(curve)).elements
    friction = [FrictionElement(stiffness_N_per_m=k, slip_m=s) for k, s in elements.friction]
    maxwell = [MaxwellElement(stiffness_N_per_m=k, relaxation_s=t) for k, t in elements.maxwell]
    elastic = {"elastic_N_per_m": elements.elastic_N_per_m or None}
    return curve.model_copy(update=elastic | {"friction": tuple(friction), "maxwell": tuple(maxwell)})


def _loss_factor(point: CurvePoint) -> float:
    if point.loss_factor is not None:
        return point.loss_factor
    assert point.damping_N_s_per_m is not None, "_faults refuses points without a loss"
    return 2 * np.pi * point.frequency_Hz * point.damping_N_s_per_m / point.stiffness_N_per_m


def _faults(name: str, bushing: Bushing) -> Iterator[CaseProblem]:
    """Yield the problems of a bushing's curves that the types of their values do not show."""
    axes = "".join(curve.axes for curve in bushing.curves)
    for number, curve in enumerate(bushing.curves):
        key = _key(name, number)
        if any(axes.count(axis) > 1 for axis in curve.axes):
            yield CaseProblem((*key, "axes"), f'"{curve.axes}" has an axis twice', "give each one curve")
        if not curve.points and curve.elastic_N_per_m is None:
            yield CaseProblem(
                key, "has no points", 'give points, file = "table.csv" or elastic_N_per_m', kind="missing"
            )
        if curve.elastic_N_per_m is None and (curve.friction or curve.maxwell):
            yield CaseProblem(
                (*key, "elastic_N_per_m"), "missing beside friction and maxwell", kind="missing"
            )
        yield from faults_of_points(key, curve)
        measured = [point.stiffness_N_per_m for point in curve.points]
        for axis in curve.axes if measured else ():
            linear = bushing.stiffness_N_per_m["xyz".index(axis)]
            if not min(measured) / FAR <= linear <= max(measured) * FAR:
                what = f"{linear:g} along {axis} is far from the measured {min(measured):g} to "
                what += f"{max(measured):g} N/m"
                hint = "give the stiffness at the amplitude that you expect; estimates use it"
                yield CaseProblem(("screen", "bushings", name, "stiffness_N_per_m"), what, hint)


def faults_of_points(key: Key, curve: BushingCurve) -> Iterator[CaseProblem]:
    """Yield a problem for each point of a curve that has not one loss."""
    for place, point in enumerate(curve.points):
        if (point.loss_factor is None) == (point.damping_N_s_per_m is None):
            what = "has no loss" if point.loss_factor is None else "has two losses"
            yield CaseProblem((*key, "points", place), what, "give loss_factor or damping_N_s_per_m")


def _misfits(
    name: str, given: Sequence[BushingCurve], fitted: Sequence[BushingCurve]
) -> Iterator[CaseProblem]:
    """Yield a problem for every curve whose elements, given or the best ones, do not meet its points."""
    for number, (before, curve) in enumerate(zip(given, fitted, strict=True)):
        if curve.elastic_N_per_m is None:
            what = "falls to nothing at large amplitudes and low frequencies, where a bushing has a spring"
            yield CaseProblem(_key(name, number), what, "measure there, or give elastic_N_per_m")
        elif (off := compare_with_points(curve)).stiffness_error > WORST or off.loss_error > WORST_LOSS:
            errors = f"stiffness off by {off.stiffness_error:.0%}, loss factor by {off.loss_error:.0%}"
            if before.elastic_N_per_m is not None:
                what = f"its elements do not fit its points: {errors}"
                hint = "leave out elastic_N_per_m, friction and maxwell, which are then fitted anew"
            elif rising := _rising_N_per_m(before):
                small, large = rising
                what = f"its stiffness rises with the amplitude, from {small:g} to {large:g} N/m"
                hint = (
                    "friction and Maxwell elements make no progressive spring; give its force over the "
                    "deformation as characteristics"
                )
            else:
                what = f"no spring with friction and Maxwell elements fits it: {errors}"
                hint = (
                    "such a spring's stiffness falls with the amplitude and rises with the frequency; smooth "
                    "the points"
                )
            yield CaseProblem(_key(name, number), what, hint)


def _rising_N_per_m(curve: BushingCurve) -> tuple[float, float] | None:
    """Return the stiffness at the smallest and at the largest amplitude of a frequency at which it rises by
    more than a fit may be off; None without one."""
    rows = sorted((p.frequency_Hz, p.amplitude_m, p.stiffness_N_per_m) for p in curve.points)
    for _, group in groupby(rows, key=itemgetter(0)):
        at = [*group]
        if at[-1][1] > at[0][1] and at[-1][2] > (1 + WORST) * at[0][2]:
            return at[0][2], at[-1][2]
    return None


def _key(name: str, number: int) -> Key:
    return ("screen", "bushings", name, "curves", number)
