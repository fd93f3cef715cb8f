"""Quadratic response surfaces: known answers of Table 5, and what least squares must do.

The known numbers were computed from Table 5 by QR decomposition with NumPy; PRESS by fitting anew without
each row; Sobol indices by Gauss-Legendre quadrature; probabilities by scipy.stats.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from orchestrator.studies.design.plans import box_behnken
from orchestrator.studies.design.quadratic import (
    Quadratic,
    Surface,
    Term,
    least_squares,
    model_matrix,
    quadratic_terms,
)
from orchestrator.studies.design.surrogates import TooFewPoints
from tests.design.table5 import RESPONSES, surface, table_5

QUALITY = {
    "velocity": {
        "r2": 0.9874028154,
        "r2_adjusted": 0.9759508294,
        "r2_predicted": 0.9498610083,
        "sst": 8.875660465,
        "sse": 0.1118083333,
        "press": 0.4450166667,
        "standard_error": 0.07128952917,
        "rmse": 0.05099209545,
        "f": 86.22109871,
        "p": 1.917925913e-16,
    },
    "efficiency": {
        "r2": 0.9687447557,
        "r2_adjusted": 0.9403308972,
        "r2_predicted": 0.8753999687,
        "sst": 8314.604651,
        "sse": 259.875,
        "press": 1036.0,
        "standard_error": 3.436931771,
        "rmse": 2.458374392,
        "f": 34.09409376,
        "p": 3.596108964e-12,
    },
}
# coefficient, F and p of velocity; the same of efficiency
ANOVA = [
    (1.323333333, 1033.732727, 5.464361574e-20, 83, 1749.587302, 1.832073084e-22),
    (0.011875, 0.4439517031, 0.5121484879, -1.1875, 1.91005291, 0.180830236),
    (0.160625, 81.2259447, 7.727393947e-09, -9.625, 125.4814815, 1.473294996e-10),
    (0.0475, 7.103227249, 0.01413886469, -1, 1.354497354, 0.2569605958),
    (0.71, 1587.030186, 5.284180153e-22, -19.6875, 525, 7.63383649e-17),
    (0.07875, 19.52403667, 0.0002169992859, -1.625, 3.576719577, 0.07183516778),
    (0.005, 0.01967652978, 0.8897206211, -0.5, 0.08465608466, 0.7738094319),
    (0.0525, 2.169337408, 0.1549507198, -0.5, 0.08465608466, 0.7738094319),
    (0.0175, 0.2410374898, 0.6283195201, -1.75, 1.037037037, 0.3195805314),
    (0.0075, 0.044272192, 0.8352845863, 0, 0, 1),
    (0.01, 0.0787061191, 0.7816798512, -0.75, 0.1904761905, 0.6667737924),
    (0.0725, 4.136990385, 0.05418854206, -2, 1.354497354, 0.2569605958),
    (0.015, 0.177088768, 0.6779695919, -0.25, 0.02116402116, 0.8856576874),
    (0.06, 2.833420288, 0.1064604084, -1.5, 0.7619047619, 0.3921608152),
    (-0.0125, 0.1229783111, 0.7291621239, 0.25, 0.02116402116, 0.8856576874),
    (0.04, 1.259297906, 0.2738828055, -0.5, 0.08465608466, 0.7738094319),
    (0.021875, 0.6025937244, 0.4458560844, -2.5, 3.386243386, 0.07927363448),
    (-0.04479166667, 2.52652108, 0.1262156229, 0.5833333333, 0.1843621399, 0.6718267761),
    (-0.003958333333, 0.0197311868, 0.8895686098, 0.08333333333, 0.003762492651, 0.9516429505),
    (0.04604166667, 2.669503863, 0.116518432, -4.166666667, 9.406231628, 0.005644115574),
    (0.064375, 5.21870761, 0.03235373221, -3.25, 5.722751323, 0.02572212951),
]
LACK_OF_FIT = {  # error, lack, F, p
    "velocity": (0.001266666667, 0.1105416667, 8.726973684, 0.1076846881),
    "efficiency": (2.0, 257.875, 12.89375, 0.07434876178),
}
SEQUENTIAL = {  # F and p of the linear terms, the products, the squares
    "velocity": [(245.5330976, 2.66976176e-27), (0.7478683149, 0.6748320416), (3.602364581, 0.01567726692)],
    "efficiency": [
        (104.4733653, 9.052166472e-21),
        (0.2290032741, 0.9907151156),
        (4.183782454, 0.008003818253),
    ],
}
SOBOL = {  # variance, first order, total
    "velocity": (
        0.1818433854,
        [0.0004924013615, 0.04827487884, 0.004143544064, 0.9250914612, 0.01339369892],
        [0.00241331564, 0.05170044566, 0.008183956205, 0.9316676329, 0.01463866524],
    ),
    "efficiency": (
        166.0259838,
        [0.00617739233, 0.1861784194, 0.002011435859, 0.7874817281, 0.01095670196],
        [0.008561557292, 0.189440961, 0.004102808632, 0.7938813288, 0.01120766669],
    ),
}
OUTLIER = {"velocity": (28, -3.787313333), "efficiency": (37, -3.351525532)}  # row, studentised residual
LINEAR_ALONE = {"velocity": (0.9707432516, 0.959826892), "efficiency": (0.9338537821, 0.9103136729)}
EACH = pytest.mark.parametrize("response", RESPONSES)


@EACH
def test_the_quality_of_the_surface_of_table_5_is_known(response: str) -> None:
    assert surface(response).quality() == pytest.approx(QUALITY[response], rel=1e-6)
    assert surface(response).fitted.df_resid == 22


@EACH
def test_the_coefficients_and_the_anova_of_table_5_are_known(response: str) -> None:
    fitted = surface(response)
    coefficients, f, p = np.array(ANOVA)[:, 3 * RESPONSES.index(response) :][:, :3].T
    assert list(fitted.coefficients.values()) == pytest.approx(coefficients, rel=1e-6, abs=1e-10)
    rows = fitted.anova()
    assert [row["term"] for row in rows] == quadratic_terms(5) == list(fitted.coefficients)
    assert [row["coefficient"] for row in rows] == list(fitted.coefficients.values())
    assert [row["f"] for row in rows] == pytest.approx(f, rel=1e-6, abs=1e-10)
    assert [row["p"] for row in rows] == pytest.approx(p, rel=1e-6)


@EACH
def test_the_standard_errors_of_table_5_follow_from_its_design(response: str) -> None:
    """The errors of linear terms are s/4, of products s/2, since 16 and 4 runs carry them."""
    errors = {row["term"]: row["standard_error"] for row in surface(response).anova()}
    s = QUALITY[response]["standard_error"]
    for term, error in errors.items():
        if len(term) == 1:
            assert error == pytest.approx(s / 4.0, rel=1e-6)
        elif len(set(term)) == 2:
            assert error == pytest.approx(s / 2.0, rel=1e-6)


@EACH
def test_the_lack_of_fit_of_table_5_is_known(response: str) -> None:
    error, lack, f, p = LACK_OF_FIT[response]
    expected = {"error_ss": error, "error_df": 2, "lack_ss": lack, "lack_df": 20, "f": f, "p": p}
    assert surface(response).lack_of_fit() == pytest.approx(expected, rel=1e-6)


@EACH
def test_products_as_a_group_explain_nothing_of_table_5(response: str) -> None:
    rows = surface(response).sequential()
    assert [(row["terms"], row["df"]) for row in rows] == [("linear", 5), ("products", 10), ("squares", 5)]
    tests = [(row["f"], row["p"]) for row in rows]
    assert tests == [pytest.approx(expected, rel=1e-6) for expected in SEQUENTIAL[response]]


@EACH
def test_the_sobol_indices_of_table_5_are_known_in_closed_form(response: str) -> None:
    variance, first, total = surface(response).sobol_indices()
    expected = SOBOL[response]
    assert variance == pytest.approx(expected[0], rel=1e-6)
    assert first == pytest.approx(expected[1], rel=1e-6)
    assert total == pytest.approx(expected[2], rel=1e-6)


@EACH
def test_the_row_of_table_5_that_stands_out_is_known(response: str) -> None:
    residuals = surface(response).studentised_residuals()
    row = int(np.argmax(np.abs(residuals)))
    assert (row + 1, residuals[row]) == (OUTLIER[response][0], pytest.approx(OUTLIER[response][1], rel=1e-6))


@EACH
def test_the_plane_alone_of_table_5_is_known(response: str) -> None:
    x, y = table_5()
    plane: list[Term] = [(), *[(i,) for i in range(5)]]
    quality = Surface.fit(x, y[:, RESPONSES.index(response)], plane).quality()
    r2, predicted = LINEAR_ALONE[response]
    assert (quality["r2"], quality["r2_predicted"]) == pytest.approx((r2, predicted), rel=1e-6)


@pytest.mark.parametrize(
    ("slope_deg", "efficiency", "velocity"),
    [
        (10, 98.520833, 0.659375),
        (12, 96.083333, 0.784800),
        (20, 83.000000, 1.323333),
        (30, 59.145833, 2.079375),
        (40, 26.958333, 2.927500),
    ],
)
def test_the_surfaces_of_table_5_predict_what_slopes_give(
    slope_deg: float, efficiency: float, velocity: float
) -> None:
    setting = np.array([[0.0, 0.0, 0.0, (slope_deg - 20.0) / 10.0, 0.0]])
    assert surface("efficiency").predict(setting)[0][0] == pytest.approx(efficiency, abs=1e-6)
    assert surface("velocity").predict(setting)[0][0] == pytest.approx(velocity, abs=1e-6)


@EACH
def test_leaving_a_point_out_is_fitting_without_it(response: str) -> None:
    fitted = surface(response)
    mean, deviation = fitted.left_out()
    for i in (0, 27, 36):
        others = np.arange(len(fitted.y)) != i
        without = Surface.fit(fitted.x[others], fitted.y[others], fitted.terms)
        expected, covariance = without.predict(fitted.x[[i]])
        assert mean[i] == pytest.approx(expected[0], rel=1e-9)
        scale = fitted.fitted.scale / without.fitted.scale  # the closed form keeps the error of all points
        scale *= (fitted.widened / without.widened) ** 2
        assert deviation[i] == pytest.approx(np.sqrt(scale * covariance[0, 0]), rel=1e-9)


def test_where_one_degree_of_freedom_is_left_residuals_have_no_error_of_their_own() -> None:
    x = np.random.default_rng(9).uniform(-1, 1, (7, 2))
    fitted = Surface.fit(x, np.exp(x[:, 0]), quadratic_terms(2))
    assert np.isnan(fitted.studentised_residuals()).all()


def test_all_runs_of_a_setting_are_left_out_together() -> None:
    rng, terms = np.random.default_rng(8), quadratic_terms(2)
    x = np.repeat(rng.uniform(-1, 1, (9, 2)), [1, 1, 1, 1, 1, 1, 1, 2, 4], axis=0)
    fitted = Surface.fit(x, rng.standard_normal(len(x)), terms)
    mean, _ = fitted.left_out()
    for i, row in enumerate(x):
        others = (x != row).any(axis=1)
        without = Surface.fit(x[others], fitted.y[others], terms)
        assert mean[i] == pytest.approx(without.predict(x[[i]])[0][0], rel=1e-9)


def test_intervals_of_few_points_hold_the_truth_as_often_as_they_say() -> None:
    """Nine points for six terms: Student's quantile is 3.18.  Of 2 000, 95 % are 1 900 +- 10."""
    rng, terms = np.random.default_rng(5), quadratic_terms(2)
    x = np.array(list(itertools.product([-1.0, 0.0, 1.0], repeat=2)))
    at, held = np.array([[0.3, -0.6]]), 0
    for _ in range(2000):
        mean, covariance = Surface.fit(x, rng.standard_normal(9), terms).predict(at)
        held += abs(mean[0]) <= 1.96 * np.sqrt(covariance[0, 0])
    assert held == pytest.approx(1900, abs=40)


def test_coefficients_in_units_of_any_size_are_those_of_the_fit() -> None:
    """A stiffness of a million N/m beside an amplitude of millimetres in m."""
    rng, terms = np.random.default_rng(6), quadratic_terms(2)
    actual = rng.uniform([1e6, 2e-3], [2e6, 6e-3], (20, 2))
    truth = np.array([3.0, 2e-7, 150.0, 1e-5, 1e-13, 8e3])
    coefficients = least_squares(model_matrix(actual, terms), model_matrix(actual, terms) @ truth)
    np.testing.assert_allclose(coefficients, truth, rtol=1e-6)


def test_repeated_runs_without_scatter_do_not_tell_of_a_lack_of_fit() -> None:
    """Their means differ from them by rounding, which is no scatter of runs."""
    rng, terms = np.random.default_rng(7), quadratic_terms(2)
    x = np.concatenate([rng.uniform(-1, 1, (12, 2)), np.zeros((3, 2))])
    y = np.exp(x[:, 0]) + 0.1
    y[-3:] += np.array([0.0, 2.2e-16, -2.2e-16])
    assert Surface.fit(x, y, terms).lack_of_fit() is None


def test_a_surface_has_no_lack_of_fit_where_no_setting_is_repeated() -> None:
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, (12, 2))
    assert Surface.fit(x, rng.standard_normal(12), quadratic_terms(2)).lack_of_fit() is None


def test_a_true_quadratic_has_no_lack_of_fit_and_its_own_coefficients() -> None:
    rng = np.random.default_rng(2)
    x = np.repeat(rng.uniform(-1, 1, (12, 2)), 3, axis=0)
    y = 1 + 2 * x[:, 0] - x[:, 0] * x[:, 1] + 0.5 * x[:, 1] ** 2 + 0.01 * rng.standard_normal(len(x))
    fitted = Surface.fit(x, y, quadratic_terms(2))
    assert list(fitted.coefficients.values()) == pytest.approx([1, 2, 0, -1, 0, 0.5], abs=0.03)
    lack = fitted.lack_of_fit()
    assert lack is not None
    assert lack["p"] > 0.05
    bent = Surface.fit(x, y + x[:, 0] ** 4, quadratic_terms(2)).lack_of_fit()
    assert bent is not None
    assert bent["p"] < 1e-4


def test_a_surface_with_too_few_points_says_how_many_and_of_which_rank() -> None:
    x, y = table_5()
    with pytest.raises(TooFewPoints, match=r"\b21\b.*\b21\b"):
        Quadratic().fit(x[:21], y[:21], y[:21], 1)
    two_levels = np.where(x[:, :3] >= 0, 1.0, -1.0)  # squares are all one
    with pytest.raises(TooFewPoints, match=r"\b43\b.*\b7\b.*\b10\b"):
        Quadratic().fit(two_levels, y, y, 1)
    exact = np.random.default_rng(1).uniform(-1, 1, (10, 3))  # nothing is left for the error
    with pytest.raises(TooFewPoints, match=r"\b10\b.*\b10\b.*\b10\b"):
        Quadratic().fit(exact, y[:10], y[:10], 1)


def test_a_constant_response_has_a_surface_that_explains_nothing() -> None:
    x, _ = table_5()
    fitted = Surface.fit(x, np.full(len(x), 5.0), quadratic_terms(5))
    assert fitted.quality()["r2_predicted"] == 0.0
    variance, first, total = fitted.sobol_indices()
    assert variance == pytest.approx(0.0, abs=1e-20)
    assert [*first, *total] == [0.0] * 10
    assert fitted.sequential() == []
    assert len(fitted.anova()) == 21
    assert np.isfinite(fitted.studentised_residuals()).all()
    assert fitted.lack_of_fit() is None


def test_a_single_centre_of_a_box_behnken_design_is_not_judged_by_the_others() -> None:
    """The centre alone tells the squares from the constant; the other points are predicted as by a fit
    without each."""
    x = np.vstack([box_behnken(3, centres=0), np.zeros((1, 3))])
    y = 1.0 + x @ [1.0, 2.0, 3.0] + 0.1 * np.random.default_rng(2).standard_normal(len(x))
    fitted = Surface.fit(x, y, quadratic_terms(3))
    mean, deviation = fitted.left_out()
    assert np.isnan([mean[-1], deviation[-1]]).all()
    assert np.isfinite([mean[:-1], deviation[:-1]]).all()
    others = np.arange(len(x)) > 0
    matrix = model_matrix(x, quadratic_terms(3))
    without = np.linalg.lstsq(matrix[others], y[others], rcond=None)[0]
    assert mean[0] == pytest.approx(matrix[0] @ without, rel=1e-9)
    total = ((y - y.mean())[:-1] ** 2).sum()
    expected = 1.0 - ((y - mean)[:-1] ** 2).sum() / total
    assert fitted.quality()["r2_predicted"] == pytest.approx(expected, rel=1e-12)
