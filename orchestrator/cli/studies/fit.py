"""``flipflow study fit``: surrogates of a study's data, or of a table."""

from __future__ import annotations

from orchestrator.cli.options import Out, StudyOutput, StudyPath
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import Crew


def command(study: StudyPath, out: Out = None) -> StudyOutput:
    """Fit surrogates to the runs of a study that have ended, or to a table.

    design.html has fits, sensitivities, trade-off and best settings.
    """
    design = DesignStudy(read_study(study), Crew(), out)
    design.load_finished()
    yield from design.write()
    return True
