"""Quadratic response surface by least squares, with its analysis of variance.

Source: G. E. P. Box, K. B. Wilson, J. R. Stat. Soc. B 13 (1951) 1, doi:10.1111/j.2517-6161.1951.tb00067.x;
R. H. Myers, D. C. Montgomery, C. M. Anderson-Cook, Response Surface Methodology, Wiley 2016, chapters
2 and 6; statsmodels does the algebra.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
import numpy.typing as npt
import statsmodels.api as sm
from scipy import stats

from orchestrator.studies.design.surrogates import TooFewPoints, settings_of
from orchestrator.workbench.vocabulary import Array

REPEATED = 1e-12  # of the response: repeated runs that scatter less are the same but for rounding
NEEDED = 1e-8  # of leverage short of 1: without the point there are too few for the terms
QUALITY = (  # what is told of a surface
    "r2",
    "r2_adjusted",
    "r2_predicted",
    "sst",
    "sse",
    "press",
    "standard_error",
    "rmse",
    "f",
    "p",
)
Term = tuple[int, ...]  # the factors whose product a term is: () 1, (0,) x0, (0, 0) x0 squared


def quadratic_terms(factors: int) -> list[Term]:
    """List the terms of the full quadratic: 1, linear, products of two, squares."""
    single = [(i,) for i in range(factors)]
    return [(), *single, *combinations(range(factors), 2), *[(i, i) for i in range(factors)]]


def model_matrix(x: Array, terms: list[Term]) -> Array:
    """Compute the values, (n, terms), of the terms at settings, (n, factors)."""
    return np.column_stack([np.prod(x[:, list(term)], axis=1) for term in terms])


def least_squares(matrix: Array, y: Array) -> Array:
    """Return the coefficients b, (terms,), that make |y - matrix b| least.

    Columns are scaled to one size first: squares of moduli in Pa beside lengths in m would otherwise be taken
    for rounding errors.
    """
    size = np.linalg.norm(matrix, axis=0)
    size[size == 0] = 1.0
    return np.asarray(np.linalg.lstsq(matrix / size, y, rcond=None)[0] / size)


class Quadratic:
    """The full quadratic of each response, by ordinary least squares.

    The error is estimated from the residuals, so that what the surface cannot follow counts as error.
    """

    def fit(self, x: Array, y: Array, variance: Array, seed: int) -> FittedQuadratic:
        """Fit each response.

        Raises TooFewPoints where a response is known at no more points than the quadratic has terms.
        """
        terms = quadratic_terms(x.shape[1])
        return FittedQuadratic([Surface.fit(x, y[:, i], terms) for i in range(y.shape[1])], len(x))


@dataclass(frozen=True)
class FittedQuadratic:
    """The surfaces of all responses."""

    surfaces: list[Surface]
    points: int

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict means, (m, p), and covariances, (m, p, p), of the responses at settings, (p, f)."""
        predicted = [surface.predict(x) for surface in self.surfaces]
        return np.array([mean for mean, _ in predicted]), np.array([cov for _, cov in predicted])

    def left_out(self) -> tuple[Array, Array]:
        """Predict each response, (n, m), from other settings."""
        mean, deviation = np.full((2, self.points, len(self.surfaces)), np.nan)
        for i, surface in enumerate(self.surfaces):
            mean[surface.known, i], deviation[surface.known, i] = surface.left_out()
        return mean, deviation


@dataclass(frozen=True)
class Surface:
    """One response as a sum of terms; ``x``, ``y`` are the points at which it is known."""

    terms: list[Term]
    x: Array
    y: Array
    known: npt.NDArray[np.bool_]
    fitted: sm.regression.linear_model.RegressionResultsWrapper

    @classmethod
    def fit(cls, x: Array, y: Array, terms: list[Term]) -> Surface:
        """Fit the terms to a response, (n,), which may hold values that are not numbers.

        Raises TooFewPoints where there are fewer points with a response than terms, plus one for the error.
        """
        known = np.isfinite(y)
        matrix = model_matrix(x[known], terms)
        rank = int(np.linalg.matrix_rank(matrix)) if known.any() else 0
        if rank < len(terms) or known.sum() <= len(terms):
            raise TooFewPoints(
                f"{known.sum()} points, of rank {rank}, for {len(terms)} terms and their error"
            )
        return cls(terms, x[known], y[known], known, sm.OLS(y[known], matrix).fit())

    @property
    def coefficients(self) -> dict[Term, float]:
        """The coefficient of each term, for coded settings."""
        return dict(zip(self.terms, map(float, self.fitted.params), strict=True))

    def predict(self, x: Array) -> tuple[Array, Array]:
        """Predict means, (p,), and the covariance of their errors, (p, p), widened as ``widened`` says."""
        matrix = model_matrix(x, self.terms)
        return matrix @ self.fitted.params, self.widened**2 * (matrix @ self.fitted.cov_params() @ matrix.T)

    @property
    def widened(self) -> float:
        """The factor on deviations by which 1.96 of them on either side hold 95 %.

        The error of a run is estimated from few residuals, so that errors follow Student's distribution.
        """
        return float(stats.t.ppf(0.975, self.fitted.df_resid) / stats.norm.ppf(0.975))

    def left_out(self) -> tuple[Array, Array]:
        """Predict each of its points from all other settings: mean and standard deviation of its error.

        A setting without which the surface could not be fitted, such as the centre, has neither.
        """
        leverage, settings = self.fitted.get_influence().hat_matrix_diag, settings_of(self.x)
        rest = 1.0 - leverage * np.bincount(settings)[settings]  # of all runs of the setting together
        rest = np.where(rest > NEEDED, rest, np.nan)
        residual = np.bincount(settings, self.fitted.resid)[settings]
        deviation = self.widened * np.sqrt(self.fitted.scale * leverage / rest)
        return self.fitted.fittedvalues - leverage * residual / rest, deviation

    @property
    def is_constant(self) -> bool:
        """Whether the response is the same at all points, so that there is nothing to explain."""
        return bool(np.ptp(self.y) == 0.0)

    def studentised_residuals(self) -> Array:
        """Compute the residual of each point over its error, both estimated without the point; not a number
        where no degree of freedom is left for the error."""
        if self.is_constant:
            return np.zeros(len(self.y))
        if self.fitted.df_resid < 2:
            return np.full(len(self.y), np.nan)
        return np.asarray(self.fitted.get_influence().resid_studentized_external)

    def quality(self) -> dict[str, float]:
        """Compute R squared, adjusted and predicted (PRESS, of single runs), and the F test of the whole
        surface."""
        if self.is_constant:
            return dict.fromkeys(QUALITY, 0.0) | {"p": 1.0}
        rest = 1.0 - self.fitted.get_influence().hat_matrix_diag
        missed = self.fitted.resid / np.where(rest > NEEDED, rest, np.nan)
        total = float(self.fitted.centered_tss)
        press, told = float(np.nansum(missed**2)), np.isfinite(missed)
        predicted = 1.0 - press / float(((self.y - self.y.mean())[told] ** 2).sum())
        values = (
            self.fitted.rsquared,
            self.fitted.rsquared_adj,
            predicted,
            total,
            self.fitted.ssr,
            press,
            np.sqrt(self.fitted.scale),
            np.sqrt(self.fitted.ssr / len(self.y)),
            self.fitted.fvalue,
            self.fitted.f_pvalue,
        )
        return dict(zip(QUALITY, map(float, values), strict=True))

    def anova(self) -> list[dict[str, Any]]:
        """List each term's coefficient, standard error, F and p (one degree of freedom each)."""
        f = self.fitted.tvalues**2
        p = stats.f.sf(f, 1, self.fitted.df_resid)
        columns = zip(self.terms, self.fitted.params, self.fitted.bse, f, p, strict=True)
        return [
            {"term": term, "coefficient": b, "standard_error": e, "f": one_f, "p": one_p}
            for term, b, e, one_f, one_p in columns
        ]

    def effects(self) -> Array:
        """Compute the change of the response from the lower to the upper end of each factor, the others in
        the centre, with half of its 95 % interval, (factors, 2)."""
        linear = [self.terms.index((factor,)) for factor in range(self.x.shape[1])]
        t = float(stats.t.ppf(0.975, self.fitted.df_resid))
        return np.column_stack([2.0 * self.fitted.params[linear], 2.0 * t * self.fitted.bse[linear]])

    def lack_of_fit(self) -> dict[str, float] | None:
        """Test the lack of fit against the scatter of repeated settings; None without any.

        Source: Myers, Montgomery, Anderson-Cook 2016, section 2.7.
        """
        group = settings_of(self.x)
        means = np.bincount(group, self.y) / np.bincount(group)
        error = float(((self.y - means[group]) ** 2).sum())
        error_df = len(self.y) - int(group.max()) - 1
        lack, lack_df = float(self.fitted.ssr) - error, int(self.fitted.df_resid) - error_df
        rounding = REPEATED**2 * float((self.y**2).sum())
        if error_df < 1 or lack_df < 1 or error <= rounding:
            return None
        f = lack / lack_df / (error / error_df)
        return {
            "error_ss": error,
            "error_df": error_df,
            "lack_ss": lack,
            "lack_df": lack_df,
            "f": f,
            "p": float(stats.f.sf(f, lack_df, error_df)),
        }

    def sequential(self) -> list[dict[str, float | str]]:
        """Test the groups of terms one after the other: linear, products, squares."""
        rows: list[dict[str, float | str]] = []
        if self.is_constant:
            return rows
        groups = {
            "linear": [t for t in self.terms if len(t) < 2],
            "products": [t for t in self.terms if len(t) < 2 or t[0] != t[1]],
            "squares": self.terms,
        }
        before = sm.OLS(self.y, np.ones((len(self.y), 1))).fit()
        for name, terms in groups.items():
            model = sm.OLS(self.y, model_matrix(self.x, terms)).fit()
            if model.df_resid < before.df_resid:
                f, p, df = model.compare_f_test(before)
                rows.append({"terms": name, "df": df, "f": float(f), "p": float(p)})
            before = model
        return rows

    def sobol_indices(self) -> tuple[float, Array, Array]:
        """Compute variance, first-order and total Sobol indices over the coded cube in closed form.

        With uniform factors, Var(x) = 1/3 and Var(x^2) = 4/45.  Source: I. M. Sobol', Math. Comput.
        Simul. 55 (2001) 271, doi:10.1016/S0378-4754(00)00270-6.
        """
        factors = self.x.shape[1]
        first, total = np.zeros((2, factors))
        for term, b in self.coefficients.items():
            if len(term) == 1 or (len(term) == 2 and term[0] == term[1]):
                share = b**2 / 3.0 if len(term) == 1 else 4.0 * b**2 / 45.0
                first[term[0]] += share
                total[term[0]] += share
            elif term:
                total[list(term)] += b**2 / 9.0
        variance = float(first.sum() + (total - first).sum() / 2.0)
        if self.is_constant:
            return 0.0, np.zeros(factors), np.zeros(factors)
        return variance, first / variance, total / variance
