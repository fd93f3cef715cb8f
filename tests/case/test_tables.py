"""The tables: every float has its unit, and the documentation is the tables'."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import pytest
from annotated_types import Le, Lt
from pydantic import BaseModel, ValidationError

from orchestrator.case.file.plausible import RANGES
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import unit_of
from orchestrator.studies.design.study_file import StudyFile
from tools.case_reference import __main__ as case_reference
from tools.case_reference.texts import texts_of

# keys of pure numbers
DIMENSIONLESS = frozenset(
    {
        "along",
        "across",
        "axis",
        "stagger",
        "margin_share",
        "start",
        "at",
        "passing",
        "poisson_ratio",
        "ratio",
        "scale",
        "restitution",
        "bond_number",
        "sliding_friction",
        "rolling_friction",
        "rayleigh_fraction",
        "coarse_graining",
        "damping_ratio",
        "mass_fraction",
        "loss_factor",
        "storage_ratio",
        "stiffness_ratio",
        "rated_slip",
        "breakdown_ratio",
        "spheres",  # in any unit: the sieve size scales them
        "tolerance",
        "limit",  # of a monitor item, in its own unit
        "largest_created_share",
        "largest_created_in_total",
        "largest_growing_share",
        "largest_stretch",
        "largest_overlap",
        "largest_penetration",
        "largest_step_share",
        "strain_amplitude",
        "cycles",
        "slope",
    }
)


def tables(table: type[BaseModel] = Case) -> Iterator[type[BaseModel]]:
    yield table
    for field in table.model_fields.values():
        for inner, _ in case_reference.tables_in(field.annotation):
            yield from tables(inner)


def has_float(kind: Any) -> bool:
    return kind is float or any(has_float(argument) for argument in get_args(kind))


FLOATS = {
    key for table in tables() for key, field in table.model_fields.items() if has_float(field.annotation)
}


@pytest.mark.parametrize("key", sorted(FLOATS))
def test_every_float_has_a_unit_or_is_listed_as_having_none(key: str) -> None:
    assert bool(unit_of(key, "")) != (key in DIMENSIONLESS)


def test_the_list_of_keys_without_unit_has_no_leftovers() -> None:
    assert DIMENSIONLESS <= FLOATS


def marks(kind: Any) -> Iterator[Any]:
    yield from getattr(kind, "__metadata__", ())
    for argument in get_args(kind):
        yield from marks(argument)


def test_every_float_has_a_largest_value() -> None:
    """The type or the plausible range bounds each float: nothing absurd gets as far as a solver."""
    bounded = {
        key
        for table in tables()
        for key, field in table.model_fields.items()
        if any(isinstance(mark, Le | Lt) for mark in [*field.metadata, *marks(field.annotation)])
    }
    assert FLOATS - bounded - set(RANGES) == {
        "mass_fraction",
        "spheres",
    }  # shares of 1, and shapes of any scale


def test_plausible_ranges_are_of_keys_that_exist() -> None:
    assert set(RANGES) <= FLOATS


@pytest.mark.parametrize("table", sorted({*tables(), *tables(StudyFile)}, key=lambda table: table.__name__))
def test_every_table_and_key_is_described(table: type[BaseModel]) -> None:
    assert table.__doc__
    assert set(table.model_fields) <= {key for key, text in texts_of(table).items() if text}


@pytest.mark.parametrize(
    ("page", "words"), [("case-format.md", ()), ("study-format.md", ("study",))], ids=["case", "study"]
)
def test_the_page_on_a_format_is_the_tables(page: str, words: tuple[str, ...]) -> None:
    """The page is written where no test has brought a solver of its own."""
    docs = Path(__file__).parents[2] / "docs"
    command = ["-m", "tools.case_reference", *words]
    own = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    written = subprocess.run(
        [sys.executable, *command],
        capture_output=True,
        encoding="utf-8",
        check=True,
        env=own,
        cwd=docs.parent,
    )
    assert (docs / page).read_text() == written.stdout, f"python {' '.join(command)} > docs/{page}"


def test_tables_are_frozen() -> None:
    probe = Case.model_fields["coupling"].get_default(call_default_factory=True)
    with pytest.raises(ValidationError, match="frozen"):
        probe.sync_interval_s = 1.0
