"""How well ``flipflow plan`` predicts: ``python -m tools.plan_series CASE LEVEL STUDY``.

For the case as it was in the study and for what the study would take for 20, 10, 5 and 2 %, at
half, once and one and a half times the study's duration: a short run as ``plan`` makes it, and then
the run itself.  Wall times mean something only where nobody else is at work.  Measured figures:
docs/measured/accuracy.md, "Times".
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from statistics import median

from orchestrator.preflight.judge import load_judged
from orchestrator.studies.accuracy.plan import Candidate, StoredStudy, find_study, time_by_study, time_run

TOLERANCES = (0.2, 0.1, 0.05, 0.02)
OF_THE_STUDY = (0.5, 1.0, 1.5)


def main(case: Path, level: str, file: Path) -> None:
    study = find_study(load_judged(case, level), file)
    assert study is not None
    ratios = []
    print("| settings | simulated / s | wall time, predicted / s | taken / s | ratio |")
    print("| --- | --- | --- | --- | --- |")
    for label, duration_s, predicted_s, taken_s in series(case, level, study):
        ratios.append(predicted_s / taken_s)
        figures = f"{duration_s:.3g} | {predicted_s:.1f} | {taken_s:.1f} | {ratios[-1]:.2f}"
        print(f"| {label} | {figures} |", flush=True)
    print(f"median {median(ratios):.2f}, {min(ratios):.2f} to {max(ratios):.2f}")


def series(case: Path, level: str, study: StoredStudy) -> Iterator[tuple[str, float, float, float]]:
    """Settings, duration, wall time that was predicted, wall time that was taken."""
    given = [*study.table["sets"], *study.table["shared"]]
    for share in OF_THE_STUDY:
        duration_s = share * study.table["base"]["simulated_s"]
        for one in candidates(study):
            timing = time_by_study(study, case, level)
            run = time_run(case, level, [*given, *one.sets, f"duration_s={duration_s:.6g}"])
            taken_s = sum(run["wall_by_part_s"].values())
            yield one.label, duration_s, timing.wall_s(one.processor_s, duration_s), taken_s


def candidates(study: StoredStudy) -> list[Candidate]:
    """Each once."""
    found = [one for one in study.measured() if not one.sets]
    found += [one for each in TOLERANCES if (one := study.cheapest(each)) is not None]
    return list({one.sets: one for one in found}.values())


if __name__ == "__main__":
    main(Path(sys.argv[1]), sys.argv[2], Path(sys.argv[3]))
