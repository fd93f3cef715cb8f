"""Printed results beside the data that they are said to come from: Table 6, Eqs. 8 and 9 of the paper.

The known numbers were computed from Table 5 by QR decomposition with NumPy, and probabilities by scipy.stats.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.studies.design.formulas import BadFormula
from orchestrator.studies.design.published import compare_formula, implied_errors, term
from orchestrator.studies.design.quadratic import Surface, Term, quadratic_terms
from orchestrator.studies.design.study_file import PublishedTable
from tests.design.table5 import RESPONSES, shipped_study, surface, table_5

FACTORS = ["driving_amplitude", "relative_amplitude", "frequency", "slope", "tension"]
REFITTED_EQ_9 = [104.643, 3.69514, -3.76528, 0.097561, 0.812862, -0.40625, -0.0875, -0.1, -0.00731707]
REFITTED_EQ_9 += [-0.634722, 0.136111, -0.0420556, -0.205556]
# its printed terms, with the product of frequency and slope and the square of the slope that it lacks
WHOLE_EQ_8 = ["1", *FACTORS, "driving_amplitude*frequency", "relative_amplitude*slope", "frequency*slope"]
WHOLE_EQ_8 += ["driving_amplitude**2", "relative_amplitude**2", "slope**2", "tension**2"]
REFITTED_EQ_8 = [0.422311, -0.118303, 0.0829653, -0.00609756, 0.0161813, 0.0196875, 0.00128049, 0.003625]
REFITTED_EQ_8 += [0.000292683, 0.00593056, -0.0107361, 0.000478889, 0.00413889]


def printed(source: str, response: str) -> PublishedTable:
    """Return what the shipped study holds of the paper's table or equation."""
    tables = shipped_study().file.published
    return next(each for each in tables if (each.source, each.response) == (source, response))


def actual_settings() -> Array:
    """Return the settings of Table 5 in the factors' units."""
    return np.asarray(shipped_study().space.actual(table_5()[0]))


@pytest.mark.parametrize(
    ("response", "implied"),
    [
        ("velocity", {"driving_amplitude": 0.0681328, "tension": 0.0875539, "frequency": 0.0578821}),
        (
            "efficiency",
            {
                "driving_amplitude": 2.938139,
                "relative_amplitude": 12.16912,
                "tension": 2.584253,
                "frequency": 1.572397,
            },
        ),
    ],
    ids=["velocity", "efficiency"],
)
def test_the_printed_p_of_table_6_contradict_each_other(response: str, implied: dict[str, float]) -> None:
    """One surface has one standard error; those implied differ by a factor of up to eight."""
    rows = implied_errors(surface(response), printed("Table 6", response).p, FACTORS)
    assert {row.factor: row.standard_error for row in rows} == pytest.approx(implied, rel=1e-6)
    p_of_fit = {row["term"]: row["p"] for row in surface(response).anova()}
    for row in rows:
        assert row.p_of_fit == pytest.approx(p_of_fit[(FACTORS.index(row.factor),)], rel=1e-9)
        assert row.printed_p == printed("Table 6", response).p[row.factor]


@pytest.mark.parametrize(
    ("response", "implied"),
    [("velocity", [0.0684, 0.0908, 0.0597]), ("efficiency", [2.97, 12.5, 2.64, 1.61])],
    ids=["velocity", "efficiency"],
)
def test_table_6_contradicts_itself_with_the_terms_of_equations_8_and_9_too(
    response: str, implied: list[float]
) -> None:
    names = WHOLE_EQ_8 if response == "velocity" else printed("Eq. 9", response).coefficients
    x, y = table_5()
    fitted = Surface.fit(x, y[:, RESPONSES.index(response)], [term(name, FACTORS) for name in names])
    assert fitted.fitted.df_resid == 30
    rows = implied_errors(fitted, printed("Table 6", response).p, FACTORS)
    assert [row.standard_error for row in rows] == pytest.approx(implied, rel=0.005)


@pytest.mark.parametrize("response", RESPONSES)
@pytest.mark.parametrize(
    "terms", [quadratic_terms(5), [(), *[(i,) for i in range(5)]]], ids=["full", "plane"]
)
def test_the_p_of_a_fit_imply_its_own_standard_error(response: str, terms: Sequence[Term]) -> None:
    x, y = table_5()
    fitted = Surface.fit(x, y[:, RESPONSES.index(response)], list(terms))
    own = {FACTORS[row["term"][0]]: row["p"] for row in fitted.anova() if len(row["term"]) == 1}
    rows = implied_errors(fitted, own, FACTORS)
    assert [row.standard_error for row in rows] == pytest.approx([np.sqrt(fitted.fitted.scale)] * 5, rel=1e-6)


def test_so_do_they_where_a_run_of_the_design_is_missing() -> None:
    """Then the terms are not orthogonal to each other."""
    x, y = table_5()
    fitted = Surface.fit(x[1:], y[1:, 0], quadratic_terms(5))
    own = {FACTORS[row["term"][0]]: row["p"] for row in fitted.anova() if len(row["term"]) == 1}
    errors = [row.standard_error for row in implied_errors(fitted, own, FACTORS)]
    assert errors == pytest.approx([np.sqrt(fitted.fitted.scale)] * 5, rel=1e-6)


def test_equation_8_with_its_legible_signs_does_not_describe_table_5() -> None:
    velocity = table_5()[1][:, 0]
    formula = compare_formula(actual_settings(), velocity, printed("Eq. 8", "velocity").coefficients, FACTORS)
    assert formula.r2 == pytest.approx(-8.7230223, rel=1e-6)
    assert formula.rmse == pytest.approx(1.4166637, rel=1e-6)
    assert formula.r2_refitted == pytest.approx(0.9825424, rel=1e-6)


def test_equation_8_describes_table_5_with_two_terms_more_and_other_signs() -> None:
    coefficients = dict(printed("Eq. 8", "velocity").coefficients)
    coefficients |= {"frequency*slope": 0.0003, "slope**2": 0.0005}
    coefficients |= {"relative_amplitude*slope": 0.004, "driving_amplitude**2": 0.007}
    whole = {name: coefficients[name] for name in WHOLE_EQ_8}
    formula = compare_formula(actual_settings(), table_5()[1][:, 0], whole, FACTORS)
    assert formula.terms == WHOLE_EQ_8
    assert formula.printed == list(whole.values())
    assert formula.r2 == pytest.approx(0.98217, abs=5e-6)
    assert formula.r2_refitted == pytest.approx(0.986279, abs=5e-7)
    assert formula.refitted == pytest.approx(REFITTED_EQ_8, rel=2e-5)


def test_equation_9_describes_table_5() -> None:
    efficiency = table_5()[1][:, 1]
    coefficients = printed("Eq. 9", "efficiency").coefficients
    formula = compare_formula(actual_settings(), efficiency, coefficients, FACTORS)
    assert formula.r2 == pytest.approx(0.9665196, rel=1e-6)
    assert formula.rmse == pytest.approx(2.5443794, rel=1e-6)
    assert formula.r2_refitted == pytest.approx(0.9680479, rel=1e-6)
    assert formula.refitted == pytest.approx(REFITTED_EQ_9, rel=5e-6)


def test_a_formula_that_is_exact_explains_everything() -> None:
    x = np.random.default_rng(1).uniform(-1, 1, (9, 2))
    coefficients = {"1": 2.0, "a": -1.0, "a * b": 0.5, "b**2": 3.0}
    y = 2.0 - x[:, 0] + 0.5 * x[:, 0] * x[:, 1] + 3.0 * x[:, 1] ** 2
    formula = compare_formula(x, y, coefficients, ["a", "b"])
    assert (formula.r2, formula.r2_refitted) == pytest.approx((1.0, 1.0), abs=1e-12)
    assert formula.rmse == pytest.approx(0.0, abs=1e-12)
    assert formula.refitted == pytest.approx(formula.printed, abs=1e-12)


@pytest.mark.parametrize(
    ("text", "expected"),
    [("1", ()), ("a", (0,)), ("b*a", (0, 1)), (" a * b ", (0, 1)), ("b**2", (1, 1)), ("b*b", (1, 1))],
)
def test_a_term_is_read_as_the_factors_whose_product_it_is(text: str, expected: Term) -> None:
    assert term(text, ["a", "b"]) == expected


@pytest.mark.parametrize("text", ["", "2", "c", "a**3", "a*b*a", "a+b", "a*c", "c**2", "a*b**2", "sin(a)"])
def test_a_term_beyond_a_quadratic_is_refused(text: str) -> None:
    with pytest.raises(BadFormula, match="is not 1, a factor, its square, or the product of two"):
        term(text, ["a", "b"])
