"""The output and a first end do not change how a run goes on, also where the monitor shortens intervals.

The scenes are random ones of the bank of promises, at an interval so long that the monitor shortens it.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from orchestrator.cli import launch
from orchestrator.output import checkpoints
from orchestrator.output.records import trust
from tests.cases import case_folder
from tests.runs.outside import summary
from tests.saved_states import differences
from tools.promise_bank import LEVEL, random_case, with_interval

pytestmark = pytest.mark.slow
INTERVALS = 120


def physics(run: Path) -> dict[str, Any]:
    """Return what decides how the machine goes on: members, loads between them, and the monitor's pace."""
    newest = checkpoints.find_newest(run)
    assert newest is not None
    state = newest.state(None)
    return {
        "members": state["members"],
        "coupling": state["coupling"],
        "pace": state["monitor"]["pace"],
        "work": state["monitor"]["work"],
    }


def case_of(seed: int, interval_s: float) -> dict[str, Any]:
    table = with_interval(random_case(seed), "particles-first", interval_s, INTERVALS * interval_s)
    return table | {"monitor": {"crossed_surface": "warn", "penetrated_surfaces": "warn"}}


def run(case: dict[str, Any], folder: Path, *sets: str) -> Path:
    code = launch.run(case_folder(folder / "case", case, strip=LEVEL), None, folder / "run", sets)
    assert code in (trust.EXIT_CODES[trust.DONE], trust.EXIT_CODES[trust.DOUBTFUL])
    return folder / "run"


@pytest.mark.parametrize(("seed", "interval_s", "output", "end"), [(6, 1.2e-4, 7, 61), (7, 3.82e-4, 3, 33)])
def test_the_end_is_the_same_to_the_bit(
    seed: int, interval_s: float, output: int, end: int, tmp_path: Path
) -> None:
    case = case_of(seed, interval_s)
    whole = run(case, tmp_path / "whole")
    assert summary(whole)["monitor"]["shortened_intervals"] > 0
    often = run(case, tmp_path / "often", f"output.interval_s={round(output * interval_s, 9)!r}")
    first = run(case, tmp_path / "first", f"duration_s={round(end * interval_s, 9)!r}")
    assert launch.resume(first, [f"duration_s={case['duration_s']!r}"]) in (0, 5)
    for other in (often, first):
        assert differences(physics(whole), physics(other)) == []
