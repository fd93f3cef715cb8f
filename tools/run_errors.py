"""Stated and true errors of runs: ``python -m tools.run_errors CASE LEVEL STUDY OUT RUNS KEY=VALUE ...``.

The tool draws combinations of a study's options that the study did not run, with random numbers that are
always the same, and makes so many ``RUNS`` and a fine one, which has the settings at the end.  The stated
error of a run is what ``summary.json`` says by the study, and the true error is against the fine run.
Measured figures: docs/measured/accuracy.md, "Errors of runs".
"""

from __future__ import annotations

import random
import shlex
from collections.abc import Sequence
from itertools import product
from pathlib import Path

import typer

from orchestrator.figures.accuracy import Accuracy
from orchestrator.studies.accuracy.nearest import accuracy_of
from orchestrator.studies.accuracy.stored import StoredStudy, find_study
from orchestrator.workbench import Case, Run

SEED = 0


def main(case: Path, level: str, file: Path, out: Path, runs: int, fine: list[str]) -> None:
    """Print the table of stated and true errors, and in how many runs the true error is within the stated."""
    study = find_study(Case.load(case, level), file)
    assert study is not None, "a given file has a study, or is refused"
    judged = study.table["judged_by"]
    truth = values(case, level, [*given(study), *fine], out / "fine")
    held, pairs = [], []
    heads = [f"{name}: stated, true" for name in (*judged, "largest")]
    print(f"| settings | {' | '.join(heads)} | within |")
    print("| --- |" + " --- |" * (len(judged) + 2))
    for number, sets in enumerate(combinations(study)[:runs], 1):
        found = stated(case, level, [*given(study), *sets], file)
        ours = values(case, level, [*given(study), *sets], out / f"run-{number}")
        told = [found.errors[name].value + (found.errors[name].half_width or 0.0) for name in judged]
        true = [abs(ours[name] - truth[name]) / abs(truth[name]) for name in judged]
        pairs += [is_true <= is_told for is_told, is_true in zip(told, true, strict=True)]
        held.append(max(true) <= max(told))
        cells = [f"{100 * one:.2g}, {100 * other:.2g} %" for one, other in zip(told, true, strict=True)]
        largest = f"{100 * max(told):.2g}, {100 * max(true):.2g} %"
        print(
            f"| {' '.join(sets)} | {' | '.join(cells)} | {largest} | {'yes' if held[-1] else 'no'} |",
            flush=True,
        )
    print(f"largest true error within the largest stated: {sum(held)} of {len(held)} runs")
    print(f"true error of a quantity within the stated: {sum(pairs)} of {len(pairs)}")


def given(study: StoredStudy) -> list[str]:
    """Return the overlays that all runs of the study share."""
    return [*study.table["sets"], *study.table["shared"]]


def combinations(study: StoredStudy) -> list[tuple[str, ...]]:
    """Return the combinations of at least two options that the study has not run, shuffled."""
    run = {frozenset(shlex.split(one["sets"])) for one in study.table["points"]}
    every = list(product(*([tuple(one["sets"]) for one in each] for each in study.table["options"].values())))
    joint = [tuple(word for sets in each for word in sets) for each in every if sum(map(bool, each)) > 1]
    new = [sets for sets in joint if frozenset(sets) not in run]
    random.Random(SEED).shuffle(new)
    return new


def stated(case: Path, level: str, sets: Sequence[str], file: Path) -> Accuracy:
    """Return what the study says about a run that is not in it."""
    found = accuracy_of(Case.load(case, level, sets), [file])
    assert found.basis == "predicted", found.why
    return found


def values(case: Path, level: str, sets: Sequence[str], folder: Path) -> dict[str, float]:
    """Make a run, unless it is there, and return the values of its quantities."""
    run = Run(folder)
    if not run.came_to_its_end():
        folder.parent.mkdir(parents=True, exist_ok=True)
        with folder.with_suffix(".log").open("w") as log:
            Run.carry_out(run.command(case, level, sets), log)
    ended = Run(folder)
    assert ended.is_trusted, f"{folder}: {ended.status}"
    return ended.metrics().values


if __name__ == "__main__":
    typer.run(main)
