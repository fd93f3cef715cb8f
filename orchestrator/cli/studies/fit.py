"""``flipflow study fit``: surrogates of a study's data, or of a table."""

from __future__ import annotations

from orchestrator.cli.options import Out, StudyOutput, StudyPath
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import Crew


def command(study: StudyPath, out: Out = None) -> StudyOutput:
    """Fit surrogates to the runs of a study that have ended, or to a table; nothing is run.

    The folder gets points, fits, sensitivities, trade-off, best settings, pictures and design.html.
    """
    design = DesignStudy(read_study(study), Crew(), out)
    design.load_finished()
    yield from design.write()
    return True
