"""Every hard case is run, and every criterion of its criteria.toml is met.

A criterion that is known not to be met is a strict expected failure: it must not be met either.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from orchestrator.output.records import trust
from orchestrator.studies.criteria import Criterion, read_criteria
from orchestrator.studies.points import CaseStudy, Crew, run_points
from orchestrator.studies.stability import QUIET
from orchestrator.studies.verdicts import CaseCriteria, case_criteria, judge
from orchestrator.workbench import Run
from tests.runs.outside import has_results, summary

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "cases" / "hard"
NAMES = sorted(file.parent.name for file in FOLDER.glob("*/criteria.toml"))
# softer grains need fewer steps, and lie still after half of the time
HALVED = {"at-rest": "duration_s=0.75"}
SOFTER = dict.fromkeys(("at-rest", "size-ratio"), "particles.largest_youngs_modulus_Pa=1e6")
pytestmark = [pytest.mark.solver, pytest.mark.process, pytest.mark.slow]


def every_criterion() -> list[object]:
    parameters = []
    for name in NAMES:
        for row in read_criteria(FOLDER / name).criteria:
            known = pytest.mark.xfail(strict=True, reason=row.known_failure)
            marks = [known] if row.known_failure else []
            label = f"{name}: {row.run}: {row.what}"
            parameters.append(pytest.param(name, row, marks=marks, id=label))
    return parameters


@pytest.fixture(scope="module")
def was_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], CaseCriteria]:
    """A case with all its runs made, each case once."""
    out, made = tmp_path_factory.mktemp("hard"), {}

    def run(name: str) -> CaseCriteria:
        if name not in made:
            shorter = [sets[name] for sets in (HALVED, SOFTER) if name in sets]
            case = CaseStudy(FOLDER / name, None, (*QUIET, *shorter), out / name)
            made[name] = case_criteria(case, Run.is_over)
            list(run_points(made[name].points, Crew(1)))
        return made[name]

    return run


def halved(row: Criterion) -> Criterion:
    """The criterion of a run of half the time, about half of each window."""
    windows = {name: getattr(row, name) for name in ("between_s", "earlier_s")}
    return row.model_copy(
        update={name: tuple(time_s / 2 for time_s in given) for name, given in windows.items() if given}
    )


@pytest.mark.parametrize(("name", "row"), every_criterion())
def test_it_is_met(was_run: Callable[[str], CaseCriteria], name: str, row: Criterion) -> None:
    result = judge(name, halved(row) if name in HALVED else row, was_run(name).runs)
    assert result.is_inside, f"{result.value_in_words}; asked for: {result.band_in_words}"


@pytest.mark.parametrize("name", NAMES)
def test_every_run_has_results(was_run: Callable[[str], CaseCriteria], name: str) -> None:
    """Every run that came to its end has results; several of these cases have no frames, or nothing that
    drives them. What a report draws of a case's runs differs in its values only, so that one is made."""
    ended = [each.folder for each in was_run(name).points if trust.came_to_its_end(each.status())]
    for folder in ended:
        assert summary(folder)["results"]["failed"] == {}
        assert " ERROR " not in (folder / "run.log").read_text()
    if ended:
        has_results(ended[-1])
