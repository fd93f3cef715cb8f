"""Printed results beside the data that they are said to come from: Table 6, Eqs. 8 and 9 of the paper.

The known numbers were computed from Table 5 by QR decomposition with NumPy, and probabilities by scipy.stats.
"""

from __future__ import annotations

import runpy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import t as student_t

from orchestrator.studies.criteria import read_criteria
from tests.design.table5 import RESPONSES, surface, table_5

ROOT = Path(__file__).parents[2]
PRINTED = SimpleNamespace(**runpy.run_path(str(ROOT / "cases/ffs0827-effects/studies/printed.py")))
SETTINGS, MEASURED = PRINTED.read_table_5()
REFITTED_EQ_9 = [104.643, 3.69514, -3.76528, 0.097561, 0.812862, -0.40625, -0.0875, -0.1, -0.00731707]
REFITTED_EQ_9 += [-0.634722, 0.136111, -0.0420556, -0.205556]


def test_the_settings_are_those_that_the_study_reads() -> None:
    x, measured = table_5()
    assert PRINTED.coded(SETTINGS) == pytest.approx(x, abs=1e-15)
    assert pytest.approx(measured, abs=0) == MEASURED


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
    y = MEASURED[:, RESPONSES.index(response)]
    errors = PRINTED.implied_errors(PRINTED.coded(SETTINGS), y, PRINTED.FULL, PRINTED.TABLE_6[response])
    assert errors == pytest.approx(implied, rel=1e-6)


@pytest.mark.parametrize("response", RESPONSES)
def test_the_p_of_a_fit_imply_its_own_standard_error(response: str) -> None:
    x, y, fitted = PRINTED.coded(SETTINGS), MEASURED[:, RESPONSES.index(response)], surface(response)
    own = PRINTED.standard_error(x, y, PRINTED.FULL)
    assert own == pytest.approx(np.sqrt(fitted.fitted.scale), rel=1e-9)
    p = {PRINTED.FACTORS[row["term"][0]]: row["p"] for row in fitted.anova() if len(row["term"]) == 1}
    errors = PRINTED.implied_errors(x, y, PRINTED.FULL, p)
    assert [*errors.values()] == pytest.approx([own] * 5, rel=1e-6)


def test_equation_8_with_its_legible_signs_does_not_describe_table_5() -> None:
    formula = PRINTED.compare_formula(SETTINGS, MEASURED[:, 0], PRINTED.EQUATION_8)
    assert formula.r2 == pytest.approx(-8.7230223, rel=1e-6)
    assert formula.r2_refitted == pytest.approx(0.9825424, rel=1e-6)


def test_equation_9_describes_table_5() -> None:
    formula = PRINTED.compare_formula(SETTINGS, MEASURED[:, 1], PRINTED.EQUATION_9)
    assert formula.r2 == pytest.approx(0.9665196, rel=1e-6)
    assert formula.r2_refitted == pytest.approx(0.9680479, rel=1e-6)
    assert formula.refitted == pytest.approx(REFITTED_EQ_9, rel=5e-6)


@pytest.mark.parametrize("response", RESPONSES)
def test_the_errors_of_the_papers_effects_are_those_of_its_fit(response: str) -> None:
    """The criteria hold our numbers against 95 % intervals of the full quadratic."""
    x, y = PRINTED.coded(SETTINGS), MEASURED[:, RESPONSES.index(response)]
    terms = PRINTED.model_matrix(x, PRINTED.FULL)
    free = len(x) - len(PRINTED.FULL)
    assert free == 22
    variances = np.diag(np.linalg.inv(terms.T @ terms))
    own = PRINTED.standard_error(x, y, PRINTED.FULL)
    of_interval = student_t.ppf(0.975, free) * own
    centre, effect = of_interval * np.sqrt(variances[0]), 2.0 * of_interval * np.sqrt(variances[1])
    unit = {"velocity": "m/s", "efficiency": "%"}[response]
    rows = [row for row in read_criteria(ROOT / "cases/ffs0827-effects").criteria if row.unit == unit]
    for row in rows:
        assert row.error == pytest.approx(effect if row.is_effect else centre, rel=0.02), row.what
    (two_rows,) = (
        row for row in read_criteria(ROOT / "cases/ffs0827-slice").criteria if row.error and row.unit == unit
    )
    assert two_rows.error == pytest.approx(of_interval / np.sqrt(2.0), rel=0.02)
