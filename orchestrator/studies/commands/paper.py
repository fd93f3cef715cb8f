"""``flipflow study paper``: a comparison of a case with the numbers of its paper."""

from __future__ import annotations

from orchestrator.studies.commands.sweep import write_sweep
from orchestrator.studies.options import StudyOutput
from orchestrator.studies.points import CaseStudy
from orchestrator.studies.verdicts import case_criteria, verdict_table, write_verdicts


def command(study: CaseStudy) -> StudyOutput:
    """Compare a case with the paper it comes from: printed value, computed value, and error.

    The case's criteria.toml has the paper's values, their acceptance bands, and the runs that they
    need; finished runs are not made again.  Values to which the case was fitted are marked: they
    prove nothing.  The folder gets paper.csv and paper.md, and sweep.csv and sweep.png of every
    varied key.

    Exit code 4: a run failed, or a value that was not fitted is out of its band.
    """
    paper = case_criteria(study)
    yield from study.run(paper.points)
    results = paper.results()
    yield verdict_table(paper.criteria.source, results)
    for name, runs in paper.runs.items():
        if runs.vary:
            yield from write_sweep(runs.vary, runs.points, study.folder / name)
    yield from write_verdicts(results, study.folder, "paper")
    return all(result.is_good for result in results)
