"""The flipping of a run's mats, from its recorded cycles."""

from __future__ import annotations

import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.output.results.mats import mat_turns, why_not_settled
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.preflight.mats.regime import repeats_after
from tests.results.synthetic import folder_of

CYCLES = 40


def read(folder: Path, least_m: Array, most_m: Array) -> RunReader:
    """A run whose panel deck-1 has these lowest and highest middles in its last cycles."""
    made = folder_of(folder, particles=False, cycles=CYCLES)
    with h5py.File(made / "history.h5", "a") as history:
        for name, group in history["panel_cycles"].items():
            for column, values in (("middle_least_m", least_m), ("middle_most_m", most_m)):
                group[column][:] = 0.0
                if name == "deck-1":
                    group[column][-len(values) :] = values
    return RunReader(made)


def span(run: RunReader, turns: int) -> tuple[float, float]:
    return float(run.edges_s[-1 - turns]), float(run.edges_s[-1])


def test_turns_up_and_turns_after_which_a_mat_repeats_itself(tmp_path: Path) -> None:
    up = np.tile([True, False], 10)
    run = read(tmp_path / "run", np.where(up, -0.002, -0.028), np.where(up, 0.031, 0.003))
    assert mat_turns(run, "deck-1", *span(run, 20)) == (0.5, 2)
    assert mat_turns(run, "deck-2", *span(run, 20)) == (0.0, 1)
    assert why_not_settled(run, *span(run, 20)) == ""


def test_a_mat_that_begins_to_arch_up_has_not_settled(tmp_path: Path) -> None:
    """2 of 15 turns against 13 of 15: Fisher's exact test gives 1.3e-4, below a hundredth of four mats."""
    up = np.array([True] * 2 + [False] * 13 + [False] * 2 + [True] * 13)
    run = read(tmp_path / "run", np.where(up, -0.002, -0.03), np.where(up, 0.03, 0.002))
    reason = why_not_settled(run, *span(run, 30))
    assert "deck-1" in reason
    assert re.findall(r"\b\d+\b", reason.partition("deck-1")[2]) == ["2", "15", "13", "15"]


def test_a_mat_whose_range_grows_has_not_settled(tmp_path: Path) -> None:
    least_m = -np.repeat([0.02, 0.025], 10) - 1e-4 * np.tile([0.0, 1.0], 10)
    run = read(tmp_path / "run", least_m, np.full(20, 0.002))
    assert {"deck-1", "23%"} <= {*re.findall(r"[\w%-]+", why_not_settled(run, *span(run, 20)))}


def test_chance_is_no_change(tmp_path: Path) -> None:
    """Mats whose sides change without order: of thirty such runs none is called unsettled."""
    rng = np.random.default_rng(5)
    for number in range(30):
        up = rng.random(30) < 0.5
        far_m = rng.uniform(0.02, 0.035, 30)
        run = read(tmp_path / f"run-{number}", np.where(up, -0.002, -far_m), np.where(up, far_m, 0.002))
        assert why_not_settled(run, *span(run, 30)) == ""


@pytest.mark.parametrize(("turns", "after"), [(3, 3), (9, None)])
def test_motions_repeat_themselves_after_up_to_eight_turns(turns: int, after: int | None) -> None:
    heights_m = np.linspace(0.01, 0.04, turns)
    rows = np.column_stack([-np.tile(heights_m, 6), np.tile(heights_m, 6)])
    assert repeats_after(rows) == after
