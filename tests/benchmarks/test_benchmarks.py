"""Every hard case is run, and every criterion of its criteria.toml is met.

A criterion that is known not to be met is a strict expected failure: it must not be met either.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from orchestrator.output.records import trust
from orchestrator.studies.commands.stability import benchmark
from orchestrator.studies.criteria import Criterion, read_criteria
from orchestrator.studies.points import Crew, run_points
from orchestrator.studies.verdicts import CaseCriteria, judge
from tests.runs.outside import has_results

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "cases" / "hard"
NAMES = sorted(file.parent.name for file in FOLDER.glob("*/criteria.toml"))
pytestmark = [pytest.mark.solver, pytest.mark.process, pytest.mark.slow]


def every_criterion() -> list[object]:
    found = []
    for name in NAMES:
        for row in read_criteria(FOLDER / name).criteria:
            known = pytest.mark.xfail(strict=True, reason=row.known_failure)
            marks = [known] if row.known_failure else []
            label = f"{name}: {row.run}: {row.what}"
            found.append(pytest.param(name, row, marks=marks, id=label))
    return found


@pytest.fixture(scope="module")
def was_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], CaseCriteria]:
    """A case with all its runs made, each case once."""
    out, made = tmp_path_factory.mktemp("hard"), {}

    def run(name: str) -> CaseCriteria:
        if name not in made:
            made[name] = benchmark(FOLDER / name, out)
            list(run_points(made[name].points, Crew(1)))
        return made[name]

    return run


@pytest.mark.parametrize(("name", "row"), every_criterion())
def test_it_is_met(was_run: Callable[[str], CaseCriteria], name: str, row: Criterion) -> None:
    result = judge(name, row, was_run(name).runs)
    assert result.is_inside, f"{result.value_in_words}; asked for: {result.band_in_words}"


@pytest.mark.parametrize("name", NAMES)
def test_every_run_has_results(was_run: Callable[[str], CaseCriteria], name: str) -> None:
    """Of those that came to their end: several of these cases have no frames, or nothing that
    drives them."""
    for point in was_run(name).points:
        if trust.came_to_its_end(point.status()):
            has_results(point.folder)
