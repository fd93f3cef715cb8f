"""Every hard case is run, and every criterion of its expected.toml is met.

A criterion that is known not to be met is a strict expected failure: it must not be met either.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from orchestrator.output.records import trust
from orchestrator.studies import sweep
from orchestrator.studies.hard import cases, verdicts
from orchestrator.studies.hard.criterion import Criterion
from orchestrator.studies.hard.expected import read
from orchestrator.studies.workers import Crew
from tests.runs.outside import has_results

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "cases" / "hard"
NAMES = sorted(file.parent.name for file in FOLDER.glob("*/expected.toml"))
pytestmark = [pytest.mark.solver, pytest.mark.process, pytest.mark.slow]


def every_criterion() -> list[object]:
    found = []
    for name in NAMES:
        for row in read(FOLDER / name).criteria:
            known = pytest.mark.xfail(strict=True, reason=row.known_failure)
            marks = [known] if row.known_failure else []
            label = f"{name}: {row.run}: {row.what}"
            found.append(pytest.param(name, row, marks=marks, id=label))
    return found


@pytest.fixture(scope="module")
def was_run(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], cases.HardCase]:
    """A case with all its runs made, each case once."""
    out, made = tmp_path_factory.mktemp("hard"), {}

    def run(name: str) -> cases.HardCase:
        if name not in made:
            made[name] = cases.hard_case(FOLDER / name, out)
            sweep.run([*made[name].points.values()], Crew(1), lambda line: None)
        return made[name]

    return run


@pytest.mark.parametrize(("name", "row"), every_criterion())
def test_it_is_met(was_run: Callable[[str], cases.HardCase], name: str, row: Criterion) -> None:
    line = verdicts.line(was_run(name), row)
    assert line.inside, f"{line.said}; asked for: {line.asked}"


@pytest.mark.parametrize("name", NAMES)
def test_every_run_has_results(was_run: Callable[[str], cases.HardCase], name: str) -> None:
    """Of those that came to their end: several of these cases have no frames, or nothing that
    drives them."""
    for point in was_run(name).points.values():
        if trust.came_to_its_end(point.status()):
            has_results(point.folder)
