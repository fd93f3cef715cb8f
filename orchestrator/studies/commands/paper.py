"""``flipflow study paper``: a case against the numbers that are known of it from elsewhere."""

from __future__ import annotations

from orchestrator.output.records.run_folder import study_folder
from orchestrator.studies.commands.sweep import write_sweep
from orchestrator.studies.criteria import criteria_runs, judge, read_criteria, verdict_table, write_verdicts
from orchestrator.studies.options import (
    CasePath,
    Level,
    Out,
    Overrides,
    Scheduler,
    Told,
    Workers,
    crew,
    folder_of,
)
from orchestrator.studies.points import run_points


def command(
    case: CasePath,
    level: Level = None,
    out: Out = None,
    workers: Workers = None,
    scheduler: Scheduler = "",
    overrides: Overrides = None,
) -> Told:
    """Compare a case with the paper it comes from: what is printed there, ours, and the error.

    The case's criteria.toml has the paper's values, their acceptance bands, and the runs they need;
    finished runs are not run again.  What the case was fitted to is marked: it proves nothing.  The
    folder gets paper.csv and paper.md, and sweep.csv and sweep.png of every key that is varied.

    Exit code 4: a run failed, or a value that was not fitted is out of its band.
    """
    folder = folder_of(case, "paper", out)
    criteria = read_criteria(case)
    runs = criteria_runs(criteria, case, level, overrides or [], folder)
    with study_folder(folder):
        yield from run_points([p for each in runs.values() for p in each.points], crew(workers, scheduler))
    results = [judge(case.resolve().name, row, runs) for row in criteria.criteria]
    yield verdict_table(criteria.source, results)
    for name, each in runs.items():
        if each.vary:
            yield from write_sweep(each.vary, each.points, folder / name)
    yield from write_verdicts(results, folder, "paper")
    return all(result.is_good for result in results)
