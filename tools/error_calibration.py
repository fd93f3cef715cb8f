"""How true stated errors are: ``python -m tools.error_calibration OUT [CASE ...]``.

Each small problem is studied with three values of each parameter.  The truth is a run with all parameters two
halvings finer than the finest of the study.  Two things are compared with it: the error that the study states
of its reference, and the settings that it recommends for 1, 5 and 10 %.  The rows go to OUT/calibration.csv.
Measured figures: docs/measured/accuracy.md, "Stated and true errors".
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.output.tables import Cell, write_csv
from orchestrator.studies.accuracy.combinations import EXACT, TOGETHER, Combination, StudyRequest, errors
from orchestrator.studies.accuracy.study import RECOMMENDED, AccuracyStudy, run_study
from orchestrator.studies.points import CaseStudy, Crew

CASES = Path(__file__).parents[1] / "cases"
STUDIED, TRUE = 3, 7  # numbers of values: the finest is halved once, and three times
BUDGET_S = 600.0
TRUTHFUL = (0.5, 3.0)  # stated over true error


@dataclass(frozen=True)
class Problem:
    """A small problem without chance: a case with overlays, and what is varied and judged."""

    case: str
    sets: tuple[str, ...]
    parameters: tuple[str, ...]
    quantities: tuple[str, ...]

    @property
    def name(self) -> str:
        """Its name among the problems."""
        return f"{self.case}-{[*filter(lambda each: each.case == self.case, PROBLEMS)].index(self)}"


LOW, BOUNCE = "bed.particles.ball.position_m=[0.152, 0.10, 0.014]", "contacts.0.restitution=1.0"
BALL, PANEL = ("sync", "panel-mesh", "particle-step"), ("panel-mesh", "panel-step")
PROBLEMS = (
    Problem("ball-on-panel", (LOW, BOUNCE, "duration_s=0.05"), BALL, ("deflection_m",)),
    Problem("ball-on-panel", (LOW, "duration_s=0.05"), BALL, ("deflection_m", "clamp_rms_N")),
    Problem("ball-on-panel", ("duration_s=0.16",), (*BALL, "stiffness"), ("deflection_m",)),
    Problem("panel-cycle", (), PANEL, ("deflection_m", "clamp_rms_N")),
    Problem("panel-cycle", ("screen.panels.deck.tension_m=0.007",), PANEL, ("clamp_rms_N", "middle_rms_g")),
    Problem("empty-machine", (), ("sync", "panel-mesh"), ("frame_half_range_m",)),
    Problem("empty-machine", ("duration_s=0.8",), ("sync", "panel-mesh"), ("deflection_m", "clamp_rms_N")),
    Problem("empty-machine", ("frames.solver=exudyn",), ("sync", "panel-mesh"), ("frame_half_range_m",)),
    Problem("crank-link-panel", (), ("sync", "panel-mesh"), ("deflection_m", "clamp_rms_N")),
    Problem("shear-spring", (), ("sync",), ("frame_half_range_m",)),
)


def main(out: Path, cases: Annotated[list[str] | None, typer.Argument()] = None) -> None:
    """Study the problems of these cases, by default all, and print and write what came of it."""
    rows: list[dict[str, Cell]] = []
    for problem in PROBLEMS:
        if not cases or problem.case in cases:
            study, truth = measure(problem, out / problem.name)
            rows += compared(problem, study, truth)
            write_csv(rows, out / "calibration.csv")
    stated = [row for row in rows if row["what"] == "reference" and row["ratio"] is not None]
    true = sum(TRUTHFUL[0] <= float(row["ratio"] or 0.0) <= TRUTHFUL[1] for row in stated)
    print(f"stated over true error of references within {TRUTHFUL}: {true} of {len(stated)}")
    kept = [row["is_kept"] for row in rows if row["what"] != "reference" and row["is_kept"] is not None]
    print(f"recommendations within their tolerance: {sum(map(bool, kept))} of {len(kept)}")


def measure(problem: Problem, out: Path) -> tuple[AccuracyStudy, Combination]:
    """Make the study of a problem and the run that counts as the truth, and return both."""
    where = CaseStudy(CASES / problem.case, "draft", problem.sets, out, Crew(1))
    request = StudyRequest(where, problem.parameters, STUDIED, 1, BUDGET_S, problem.quantities)
    study = _ended(run_study(request))
    finer = study.loaded.refined(problem.parameters, TRUE)
    finest = {series.axis: series.settings[-1] for series in finer.series}
    truth = study.combine(TOGETHER, finest)
    if not truth.runs:  # the finest mesh wants a shorter step than that of the series
        truth = study.combine(TOGETHER, {axis: each for axis, each in finest.items() if axis != "panel-step"})
    return study, _ended(study.run([truth])).measured[truth.name]


def _ended(steps: Iterator[str]) -> AccuracyStudy:
    while True:
        try:
            print(next(steps), flush=True)
        except StopIteration as end:
            study: AccuracyStudy = end.value
            return study


def compared(problem: Problem, study: AccuracyStudy, truth: Combination) -> Iterator[dict[str, Cell]]:
    """Yield the rows of a problem: its reference, and what it recommends for each tolerance."""

    def error_of(point: Combination) -> float:
        true = errors(point, truth, EXACT)
        return max(true[name].value for name in study.judged_by)

    reference = study.measured[study.reference]
    stated, true = study.reference_error, error_of(reference)
    row: dict[str, Cell] = {"problem": problem.name, "what": "reference", "settings": reference.label}
    yield row | {"stated": stated, "true": true, "ratio": stated / true if stated else None, "is_kept": None}
    for tolerance in RECOMMENDED:
        recommended = study.recommend(tolerance).row
        row = {"problem": problem.name, "what": f"{100 * tolerance:g} %", "stated": tolerance, "ratio": None}
        if recommended is None:
            yield row | {"settings": "none", "true": None, "is_kept": None}
            continue
        true = error_of(recommended.point)
        yield row | {"settings": recommended.point.label, "true": true, "is_kept": true <= tolerance}


if __name__ == "__main__":
    typer.run(main)
