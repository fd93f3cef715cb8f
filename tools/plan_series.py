"""The accuracy of the predictions of ``flipflow plan``: ``python -m tools.plan_series CASE LEVEL STUDY``.

The tool takes the unchanged case of the study and the settings that the study would choose for 20, 10, 5 and
2 %, at half, once and one and a half times the study's duration.  For each of them it makes a short run, as
``plan`` does, and then the run itself.  The wall times are meaningful only on a machine without other work.
Measured figures: docs/measured/accuracy.md, "Predicted and measured times".
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from statistics import median

import typer

from orchestrator.cli.planning import time_by_study, time_run
from orchestrator.preflight.judge import load_judged
from orchestrator.studies.accuracy.stored import Candidate, StoredStudy, find_study
from orchestrator.workbench import Case

TOLERANCES = (0.2, 0.1, 0.05, 0.02)
SHARES_OF_DURATION = (0.5, 1.0, 1.5)


def main(case: Path, level: str, file: Path) -> None:
    """Print the table of predicted and measured wall times."""
    study = find_study(Case(load_judged(case, level)), file)
    assert study is not None
    ratios = []
    print("| settings | simulated / s | wall time, predicted / s | taken / s | ratio |")
    print("| --- | --- | --- | --- | --- |")
    for label, duration_s, predicted_s, measured_s in series(case, level, study):
        ratios.append(predicted_s / measured_s)
        figures = f"{duration_s:.3g} | {predicted_s:.1f} | {measured_s:.1f} | {ratios[-1]:.2f}"
        print(f"| {label} | {figures} |", flush=True)
    print(f"median {median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}")


def series(case: Path, level: str, study: StoredStudy) -> Iterator[tuple[str, float, float, float]]:
    """Make the runs, and yield the label, duration, predicted and measured wall time of each, times in s."""
    given = [*study.table["sets"], *study.table["shared"]]
    for share in SHARES_OF_DURATION:
        duration_s = share * study.table["base"]["simulated_s"]
        for one in candidates(study):
            timing = time_by_study(study, case, level)
            run = time_run(case, level, [*given, *one.sets, f"duration_s={duration_s:.6g}"])
            measured_s = sum(run["wall_by_part_s"].values())
            yield one.label, duration_s, timing.wall_s(one.processor_s, duration_s), measured_s


def candidates(study: StoredStudy) -> list[Candidate]:
    """Return the unchanged case and the cheapest settings for each tolerance, without repetition."""
    wanted = [one for one in study.measured_candidates if not one.sets]
    wanted += [one for each in TOLERANCES if (one := study.recommend(each)) is not None]
    return list({one.sets: one for one in wanted}.values())


if __name__ == "__main__":
    typer.run(main)
