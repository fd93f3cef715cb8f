"""``flipflow study paper``: a comparison of cases with the numbers of the papers that they come from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.options import StudyOutput
from orchestrator.studies.paper import find_papers, recorded_results, write_paper
from orchestrator.studies.points import CaseStudy
from orchestrator.studies.sweep import write_sweep
from orchestrator.studies.verdicts import verdict_table
from orchestrator.workbench import StudyFolder


def command(
    study: CaseStudy,
    dry: Annotated[bool, typer.Option("--dry", help="make no run, judge those there")] = False,
    recorded: Annotated[
        Path | None, typer.Option("--recorded", help="make no run, take numbers from this paper.csv")
    ] = None,
) -> StudyOutput:
    """Compare cases with the papers they come from: printed number, computed number, and distance.

    criteria.toml of a case, or of the cases of a folder that name a source, has the numbers, bands and
    runs.  Called again, only missing runs are made.  A number that is fitted, published or assumed proves
    nothing and is marked so. paper.html shows all.

    Exit code 4: a run failed, or a predicted number is out of its band.
    """
    papers = find_papers(study)
    if recorded is not None:
        results = recorded_results([paper for paper, _ in papers], recorded)
    else:
        if not dry:
            yield from study.run([point for paper, _ in papers for point in paper.points])
        results = [(paper, paper.results()) for paper, _ in papers]
    for paper, of_case in results:
        yield verdict_table(f"{paper.name}: {paper.criteria.source}", of_case)
    with StudyFolder(study.folder).lock():
        for paper, folder in papers:
            for name, runs in paper.runs.items():
                if runs.vary and not dry and recorded is None:
                    yield from write_sweep(runs.vary, runs.points, folder / name)
        every = [result for _, of_case in results for result in of_case]
        yield StudyFolder(study.folder).write_csv("paper.csv", [each.cells for each in every])
        yield from write_paper(results, study, recorded)
    return all(result.is_good for result in every)
