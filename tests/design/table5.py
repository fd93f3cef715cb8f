"""Table 5 of the paper on the FFS0827, read as its shipped study reads it.

Source: N. Xu, X. Wang, D. Lin, W. Zuo, Minerals 14 (2024) 278, doi:10.3390/min14030278.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np

from orchestrator.ports import Array
from orchestrator.studies.design.quadratic import FittedQuadratic, Quadratic, Surface
from orchestrator.studies.design.study_file import Study, read_study
from orchestrator.studies.design.table_data import read_table

RESPONSES = ("velocity", "efficiency")


@cache
def shipped_study() -> Study:
    """Read the study of Table 5 that is shipped with the paper's case."""
    return read_study(Path(__file__).parents[2] / "cases" / "ffs0827-effects" / "studies" / "table5.toml")


def table_5() -> tuple[Array, Array]:
    """Read the coded settings, (43, 5), and velocity and efficiency, (43, 2)."""
    rows = read_table(shipped_study())
    x = np.array([row.trial.setting for row in rows])
    return x, np.array([[row.responses[name].value for name in RESPONSES] for row in rows])


@cache
def fitted_quadratic() -> FittedQuadratic:
    """Fit the full quadratics to Table 5."""
    x, y = table_5()
    return Quadratic().fit(x, y, np.full_like(y, np.nan), 1)


def surface(response: str) -> Surface:
    """Return the full quadratic of velocity or efficiency."""
    return fitted_quadratic().surfaces[RESPONSES.index(response)]
