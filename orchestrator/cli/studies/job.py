"""``flipflow study job``: one run of a study, for a scheduler of a cluster."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.options import StudyOutput
from orchestrator.studies.points import CaseStudy, run_points
from orchestrator.workbench import CaseError, CaseProblem


def command(
    study: CaseStudy,
    folder: Annotated[str, typer.Option("--folder", help="name of the run's folder in the study's folder")],
) -> StudyOutput:
    """Make one run of a study, as --write-jobs of a study lists them, unless it is done.

    The study, called again, finds the run.

    Exit code 0: done, doubtful or incomplete; 4: it failed.
    """
    if Path(folder).name != folder:
        raise CaseError([CaseProblem((), "is not a name of a folder", file=f"--folder {folder}")])
    point = study.point(folder)
    yield from run_points([point], study.crew)
    return point.run.came_to_its_end()
