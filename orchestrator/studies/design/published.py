"""Printed results of response-surface studies, compared with the data that they are said to come from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from orchestrator.ports import Array
from orchestrator.studies.design.formulas import BadFormula
from orchestrator.studies.design.quadratic import Surface, Term, least_squares, model_matrix


def term(text: str, factors: Sequence[str]) -> Term:
    """Parse ``1``, ``a``, ``a*b`` or ``a**2`` into the numbers of the factors whose product it is.

    Raises BadFormula for something else and for an unknown factor.
    """
    if text.strip() == "1":
        return ()
    squared = text.removesuffix("**2").strip() if text.strip().endswith("**2") else ""
    names = [squared, squared] if squared else [name.strip() for name in text.split("*")]
    if len(names) > 2 or not set(names) <= set(factors):
        raise BadFormula(f'"{text}" is not 1, a factor, its square, or the product of two factors')
    return tuple(sorted(factors.index(name) for name in names))


@dataclass(frozen=True)
class ImpliedError:
    """What a printed p of a factor's linear term implies.

    ``p`` and the effect give the standard error of the effect, and with the design that of one run.  All
    factors must imply the same one, the surface's own.
    """

    factor: str
    printed_p: float
    standard_error: float
    p_of_fit: float


def implied_errors(
    surface: Surface, printed: Mapping[str, float], factors: Sequence[str]
) -> list[ImpliedError]:
    """Compute the standard error of one run that each printed p implies, with the surface's residual degrees
    of freedom."""
    freedom, per_run = surface.fitted.df_resid, np.sqrt(np.diag(surface.fitted.normalized_cov_params))
    per_run_of = dict(zip(surface.terms, per_run, strict=True))
    p_of_fit = dict(zip(surface.terms, surface.fitted.pvalues, strict=True))
    coefficients = surface.coefficients
    rows = []
    for factor, p in printed.items():
        number = factors.index(factor)
        t = float(stats.t.isf(p / 2.0, freedom))
        error = float(abs(coefficients[(number,)]) / t / per_run_of[(number,)])
        rows.append(ImpliedError(factor, p, error, float(p_of_fit[(number,)])))
    return rows


@dataclass(frozen=True)
class PrintedSurface:
    """A printed formula beside the least-squares fit of the same terms; coefficients for actual units."""

    terms: list[str]
    printed: list[float]
    refitted: list[float]
    r2: float
    rmse: float
    r2_refitted: float


def compare_formula(
    actual: Array, y: Array, coefficients: Mapping[str, float], factors: Sequence[str]
) -> PrintedSurface:
    """Evaluate a printed formula on data: settings (n, factors) in actual units and a response (n,)."""
    terms = [term(text, factors) for text in coefficients]
    matrix = model_matrix(actual, terms)
    printed = np.array(list(coefficients.values()))
    refitted = least_squares(matrix, y)
    total = float(((y - y.mean()) ** 2).sum())
    left, least = (float(((y - matrix @ b) ** 2).sum()) for b in (printed, refitted))
    return PrintedSurface(
        list(coefficients),
        printed.tolist(),
        refitted.tolist(),
        1.0 - left / total,
        float(np.sqrt(left / len(y))),
        1.0 - least / total,
    )
