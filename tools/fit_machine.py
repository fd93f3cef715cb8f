"""Fit of a machine's values to measured amplitudes: ``python -m tools.fit_machine CASE [--run RUN]``.

The data are the amplitudes among the case's criteria whose ``ours`` is "fitted".  A model of rigid frames on
bushings, with panels as one-sided springs (``orchestrator/preflight/scene``), is fitted to them by least
squares of relative differences.  The model leaves out the panels' weight, inertia and rubber, so that the
coupled run differs from it.  ``--run`` names a run of the case: each amplitude of the model is multiplied by
the ratio of run to model at the run's values.  A few rounds of run and fit then fit the coupled machine
(space mapping: Bandler and others, IEEE Transactions on Microwave Theory and Techniques 42, 1994, 2536-2544,
doi 10.1109/22.339794).
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from orchestrator.case.deck.panels import axes
from orchestrator.case.tables.case import Case
from orchestrator.output.results.estimate import NORMAL_95
from orchestrator.output.results.quantities import AXES, number_of
from orchestrator.ports import Array
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.scene.shaking import solve_shakings
from orchestrator.studies.criteria import UNITS, Criterion, read_criteria

FREE = (
    "screen.frames.driving.mass_kg",
    "screen.frames.driven.mass_kg",
    "screen.frames.driving.inertia_kg_m2.1",
    "screen.frames.driven.inertia_kg_m2.1",
    "screen.bushings.shear.stiffness_N_per_m.2",
    "screen.decks.deck.thickness_m",
)
"""The keys that are fitted unless others are given."""


def main() -> None:
    """Fit the values of a case, and print them and the amplitudes before and after."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("case", type=Path)
    parser.add_argument("--level", default="draft")
    parser.add_argument("--set", dest="sets", action="append", default=[], help="key=value, as in the run")
    parser.add_argument("--free", action="append", help=f"a fitted key [default: {', '.join(FREE)}]")
    parser.add_argument("--run", type=Path, help="a finished run of the case, which corrects the model")
    given = parser.parse_args()
    keys = tuple(given.free or FREE)
    rows = [r for r in read_criteria(given.case).criteria if r.ours == "fitted" and r.measure == "amplitude"]
    loaded = load_judged(given.case, given.level, given.sets)
    values = np.array([value_at(loaded.layers.merged, key) for key in keys])
    wanted_m = np.array([(row.reference or np.nan) * UNITS[row.unit] for row in rows])
    modelled_m = amplitudes_m(loaded.case, rows)
    observed_m = np.array([number_of(row, given.run) for row in rows]) if given.run else modelled_m

    def predict_m(factors: Array) -> Array:
        sets = [f"{key}={value!r}" for key, value in zip(keys, (factors * values).tolist(), strict=True)]
        changed = load_judged(given.case, given.level, [*given.sets, *sets]).case
        return amplitudes_m(changed, rows) * observed_m / modelled_m

    fit = least_squares(lambda factors: predict_m(factors) / wanted_m - 1, np.ones(len(keys)), diff_step=1e-3)
    fitted_m = predict_m(fit.x)
    for row, paper, *both in zip(rows, wanted_m, observed_m, fitted_m, strict=True):
        shares = "  ".join(f"{1e3 * each:6.2f} mm {100 * (each / paper - 1):+5.1f} %" for each in both)
        print(f"{row.what:45s} {1e3 * paper:5.2f} mm  {shares}")
    for name, each in (("before", observed_m), ("after, predicted", fitted_m)):
        print(
            f"{name}: root mean square difference {100 * np.sqrt(np.mean((each / wanted_m - 1) ** 2)):.2f} %"
        )
    for key, value, factor, width in zip(keys, values, fit.x, half_widths(fit.jac, fit.fun), strict=True):
        print(f"{key} = {value * factor:.5g} +- {value * width:.2g} (was {value:.5g})")


def amplitudes_m(case: Case, rows: Sequence[Criterion]) -> Array:
    """Return the amplitudes that criteria ask for, by the model of rigid frames and springs."""
    estimated = scene(case)
    (shaking,) = solve_shakings(estimated.plan, estimated.springs, freedoms=6)
    turn = axes(case)

    def phasor_m(name: str) -> Array:
        if name in case.probes:
            probe = case.probes[name]
            (body,) = (body for body in estimated.plan.bodies if body.name == probe.frame)
            arm_m = turn @ np.array(probe.point_m) - body.center_of_mass_m
            moved_m = shaking.amplitude_m[body.name] + np.cross(shaking.angle_rad[body.name], arm_m)
            return np.asarray(turn.T @ moved_m)
        second, _, first = name.partition("-")
        frames_m = shaking.amplitude_m[second] - (shaking.amplitude_m[first] if first else 0.0)
        return np.asarray(turn.T @ frames_m)

    return np.array([abs(phasor_m(row.of)[AXES.get(row.axis, 0)]) for row in rows])


def value_at(table: Any, key: str) -> float:
    """Return the number at a dotted key of a case's tables."""
    return float(
        reduce(
            lambda inner, word: inner[int(word) if isinstance(inner, list) else word], key.split("."), table
        )
    )


def half_widths(jacobian: Array, residuals: Array) -> Array:
    """Return half widths of the 95 % confidence intervals of fitted factors, by the linearised fit."""
    spare = max(1, len(residuals) - jacobian.shape[1])
    variance = np.sum(residuals**2) / spare * np.diag(np.linalg.pinv(jacobian.T @ jacobian))
    return np.asarray(NORMAL_95 * np.sqrt(variance))


if __name__ == "__main__":
    main()
