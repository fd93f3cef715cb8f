"""Do Table 6, Eq. 8 and Eq. 9 of the paper follow from its own Table 5?

``python cases/ffs0827-effects/studies/printed.py`` prints what docs/measured/design.md says of them.

All linear effects of a surface rest on one standard error of a run, so every p that is printed for one
implies that standard error, and all must agree.  A printed formula is compared with the least-squares fit of
its own terms.  Source of the printed numbers: N. Xu, X. Wang, D. Lin, W. Zuo, Minerals 14 (2024) 278,
doi:10.3390/min14030278.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt
from scipy import stats

Array = npt.NDArray[np.float64]

FACTORS = ("driving_amplitude", "relative_amplitude", "frequency", "slope", "tension")
RESPONSES = ("velocity", "efficiency")
# of the terms with "<0.0001" no number follows
TABLE_6 = {
    "velocity": {"driving_amplitude": 0.4930, "tension": 0.0016, "frequency": 0.0034},
    "efficiency": {
        "driving_amplitude": 0.1202,
        "relative_amplitude": 0.0045,
        "tension": 0.0197,
        "frequency": 0.0185,
    },
}
# with the signs that are legible in print
EQUATION_8 = {
    "1": 0.43,
    "driving_amplitude": -0.12,
    "relative_amplitude": 0.08,
    "frequency": -0.006,
    "slope": 0.015,
    "tension": 0.02,
    "driving_amplitude*frequency": 0.001,
    "relative_amplitude*slope": -0.004,
    "driving_amplitude**2": -0.007,
    "relative_amplitude**2": -0.01,
    "tension**2": 0.004,
}
EQUATION_9 = {
    "1": 107.02,
    "driving_amplitude": 3.25,
    "relative_amplitude": -4.04,
    "frequency": 0.09,
    "slope": 0.66,
    "tension": -0.38,
    "driving_amplitude*slope": -0.09,
    "relative_amplitude*slope": -0.1,
    "frequency*slope": -0.007,
    "driving_amplitude**2": -0.52,
    "relative_amplitude**2": 0.19,
    "slope**2": -0.04,
    "tension**2": -0.19,
}
FULL = (
    "1",
    *FACTORS,
    *(f"{a}*{b}" for number, a in enumerate(FACTORS) for b in FACTORS[number + 1 :]),
    *(f"{a}**2" for a in FACTORS),
)
"""The terms of a full quadratic."""


@dataclass(frozen=True)
class PrintedFormula:
    """A printed formula beside the fit of its terms: coefficients, and coefficients of determination."""

    refitted: Array
    r2: float
    r2_refitted: float


def read_table_5() -> tuple[Array, Array]:
    """Return the settings (43, 5) in the factors' units, and velocity and efficiency, (43, 2)."""
    lines = Path(__file__).with_name("table5.csv").read_text(encoding="utf-8").splitlines()
    names, *rows = [line.split(",") for line in lines if not line.startswith("#")]
    assert tuple(names) == FACTORS + RESPONSES
    table = np.array(rows, dtype=np.float64)
    return table[:, : len(FACTORS)], table[:, len(FACTORS) :]


def coded(settings: Array) -> Array:
    """Return settings (n, factors) on the range from -1 to 1."""
    low, high = settings.min(axis=0), settings.max(axis=0)
    return np.asarray(2.0 * (settings - low) / (high - low) - 1.0)


def model_matrix(x: Array, terms: Sequence[str]) -> Array:
    """Return the values (n, terms) of terms such as ``1``, ``a``, ``a*b`` and ``a**2`` at settings (n, 5)."""
    columns = dict(zip(FACTORS, x.T, strict=True)) | {"1": np.ones(len(x))}
    factors = [term.removesuffix("**2").split("*") * (1 + term.endswith("**2")) for term in terms]
    return np.column_stack([np.prod([columns[name] for name in names], axis=0) for names in factors])


def implied_errors(x: Array, y: Array, terms: Sequence[str], p: Mapping[str, float]) -> dict[str, float]:
    """Return the standard error of one run that each printed p of a linear term implies, by factor."""
    matrix = model_matrix(x, terms)
    coefficients = np.linalg.lstsq(matrix, y, rcond=None)[0]
    per_run = np.sqrt(np.diag(np.linalg.inv(matrix.T @ matrix)))
    freedom = len(y) - len(terms)
    at = {term: place for place, term in enumerate(terms)}
    return {
        name: float(abs(coefficients[at[name]]) / stats.t.isf(value / 2.0, freedom) / per_run[at[name]])
        for name, value in p.items()
    }


def standard_error(x: Array, y: Array, terms: Sequence[str]) -> float:
    """Return the standard error of one run that the residuals of a fit imply."""
    matrix = model_matrix(x, terms)
    left = y - matrix @ np.linalg.lstsq(matrix, y, rcond=None)[0]
    return float(np.sqrt(left @ left / (len(y) - len(terms))))


def compare_formula(settings: Array, y: Array, coefficients: Mapping[str, float]) -> PrintedFormula:
    """Return a printed formula beside the fit of its terms; settings (n, 5) in the factors' units."""
    matrix = model_matrix(settings, list(coefficients))
    refitted = np.linalg.lstsq(matrix, y, rcond=None)[0]
    r2 = [
        1.0 - np.sum((y - matrix @ b) ** 2) / np.sum((y - y.mean()) ** 2)
        for b in (list(coefficients.values()), refitted)
    ]
    return PrintedFormula(refitted, float(r2[0]), float(r2[1]))


def main() -> None:
    """Print both comparisons."""
    settings, measured = read_table_5()
    x = coded(settings)
    for number, name in enumerate(RESPONSES):
        errors = implied_errors(x, measured[:, number], FULL, TABLE_6[name]).values()
        own = standard_error(x, measured[:, number], FULL)
        print(
            f"Table 6, {name}: standard errors of {min(errors):.3g} to {max(errors):.3g} are implied, "
            f"{own:.3g} is that of the fit"
        )
    for name, formula in (("Eq. 8", EQUATION_8), ("Eq. 9", EQUATION_9)):
        found = compare_formula(settings, measured[:, int(name == "Eq. 9")], formula)
        print(f"{name}: R2 {found.r2:.4f} as printed, {found.r2_refitted:.4f} with its terms fitted anew")


if __name__ == "__main__":
    main()
