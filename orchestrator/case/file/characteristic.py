"""Piecewise linear characteristics of bushings: their files, their faults, and their springs.

A characteristic is the force of a spring with gap springs in parallel.  The spring is the line through zero;
at each corner of the characteristic a gap spring begins that has the change of the slope there
(``ports/plans.py``, ``CharacteristicPlan``).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.file.bushing_curve import FAR, bushing_rows
from orchestrator.case.file.bushing_loop import force_over_displacement
from orchestrator.case.file.data_file import read_with
from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.frames import Bushing, BushingTemperature, Characteristic
from orchestrator.ports import Array
from orchestrator.ports.plans import CharacteristicPlan

ZERO = 1e-6
"""Largest force at zero deformation, as a share of the largest force."""


def read_characteristic_files(table: dict[str, Any], folder: Path, source: str) -> Iterator[CaseProblem]:
    """Put the points of the file that a characteristic names into a case's table, in the place of its name.

    Yield all mistakes in the files; a table of another form is left to the check of the tables.
    """
    for key, row in bushing_rows(table, "characteristics"):
        if not isinstance(file := row.get("file"), str):
            continue
        try:
            points = read_with(force_over_displacement, row, folder, file, (*key, "file"), source)
        except CaseError as error:
            yield from error.problems
            continue
        row["deformation_m"], row["force_N"] = (column.tolist() for column in points)
        for word in ("file", "columns", "decimal"):
            row.pop(word, None)


def plan_of(row: Characteristic, axis: int, ratio: float) -> CharacteristicPlan:
    """Return the plan of a characteristic along an axis, with ``ratio`` times its forces."""
    deformation_m, force_N = points(row)
    slope = ratio * np.diff(force_N) / np.diff(deformation_m)
    zero = min(int(np.searchsorted(deformation_m, 0.0, side="right")) - 1, len(slope) - 1)
    side = np.where(np.arange(1, len(slope)) > zero, 1.0, -1.0)
    return CharacteristicPlan(
        axis, float(slope[zero]), side, side * deformation_m[1:-1], side * np.diff(slope)
    )


def points(row: Characteristic) -> tuple[Array, Array]:
    """Return deformations and forces of all points, (n,) each, on both sides."""
    deformation_m, force_N = np.array(row.deformation_m), np.array(row.force_N)
    if not row.symmetric:
        return deformation_m, force_N
    return np.append(-deformation_m[:0:-1], deformation_m), np.append(-force_N[:0:-1], force_N)


def check_characteristics(case: Case) -> Case:
    """Return the case.  Raises CaseError with all faults of characteristics and temperatures of bushings that
    the types of their values do not show."""
    problems: list[CaseProblem] = []
    for name, bushing in case.screen.bushings.items():
        problems += _faults(("screen", "bushings", name), bushing)
        if bushing.temperature is not None:
            problems += _temperature_faults(("screen", "bushings", name, "temperature"), bushing.temperature)
    if problems:
        raise CaseError(problems)
    return case


def _faults(of: Key, bushing: Bushing) -> Iterator[CaseProblem]:
    axes = "".join([curve.axes for curve in bushing.curves] + [row.axes for row in bushing.characteristics])
    for number, row in enumerate(bushing.characteristics):
        key = (*of, "characteristics", number)
        if any(axes.count(axis) > 1 for axis in row.axes):
            what = f'"{row.axes}" has an axis that has another characteristic or a curve'
            yield CaseProblem((*key, "axes"), what, "give each axis one of them")
        if len(row.deformation_m) != len(row.force_N):
            what = f"has {len(row.force_N)} forces for {len(row.deformation_m)} deformations"
            yield CaseProblem((*key, "force_N"), what)
        elif len(row.deformation_m) < 2:
            hint = 'give deformation_m and force_N, or file = "table.csv"'
            yield CaseProblem(key, "has fewer than two points", hint, kind="missing")
        elif any(np.diff(row.deformation_m) <= 0):
            yield CaseProblem((*key, "deformation_m"), "does not grow from point to point")
        elif any(np.diff(row.force_N) < 0):
            yield CaseProblem((*key, "force_N"), "falls from one point to the next")
        elif row.symmetric and (row.deformation_m[0], row.force_N[0]) != (0.0, 0.0):
            what = "does not begin at zero, as a symmetric characteristic does"
            yield CaseProblem((*key, "deformation_m"), what)
        else:
            yield from _misfits(of, key, bushing, row)


def _misfits(of: Key, key: Key, bushing: Bushing, row: Characteristic) -> Iterator[CaseProblem]:
    """Yield problems of a characteristic that misses zero, or that is far from the linear stiffness."""
    deformation_m, force_N = points(row)
    if not deformation_m[0] <= 0.0 <= deformation_m[-1]:
        yield CaseProblem((*key, "deformation_m"), "has no zero between its ends", "give the point 0, 0")
    elif abs(np.interp(0.0, deformation_m, force_N)) > ZERO * np.abs(force_N).max():
        hint = "deformations count from the bushing without load"
        yield CaseProblem((*key, "force_N"), "is not zero at zero deformation", hint)
    slope = np.diff(force_N) / np.diff(deformation_m)
    for axis in row.axes:
        linear = bushing.stiffness_N_per_m["xyz".index(axis)]
        if not slope.min() / FAR <= linear <= slope.max() * FAR:
            what = (
                f"{linear:g} along {axis} is far from the slopes of its characteristic, {slope.min():g} to "
            )
            what += f"{slope.max():g} N/m"
            hint = "give the stiffness at the amplitude that you expect; estimates use it"
            yield CaseProblem((*of, "stiffness_N_per_m"), what, hint)


def _temperature_faults(key: Key, row: BushingTemperature) -> Iterator[CaseProblem]:
    tests_degC = row.measured_degC
    if len(tests_degC) != len(row.stiffness_ratio) or len(tests_degC) < 2:
        what = f"has {len(row.stiffness_ratio)} ratios for {len(tests_degC)} temperatures"
        yield CaseProblem((*key, "stiffness_ratio"), what, "give two tests or more, with a ratio each")
    elif any(np.diff(tests_degC) <= 0):
        yield CaseProblem((*key, "measured_degC"), "does not grow from test to test")
    elif not tests_degC[0] <= row.works_at_degC <= tests_degC[-1]:
        what = f"{row.works_at_degC:g} is outside of the tests, {tests_degC[0]:g} to {tests_degC[-1]:g} degC"
        yield CaseProblem((*key, "works_at_degC"), what, kind="out-of-range")
