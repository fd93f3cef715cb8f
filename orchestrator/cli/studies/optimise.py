"""``flipflow study optimise``: the best setting of a design study, measured."""

from __future__ import annotations

from orchestrator.cli.options import Out, StudyOutput, StudyPath
from orchestrator.studies.design.findings import Findings
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import Crew


def command(study: StudyPath, crew: Crew, out: Out = None) -> StudyOutput:
    """Find the best setting of a design study, and measure it.

    After the plan each run is made where it promises most, within the study's hours or runs.  The best
    setting is run again with new random numbers, beside the centre and the best simpler design;
    recommended.toml has it as a level.  Called again, the study goes on.

    Exit code 4: no optimum can be stated, or it was not measured as predicted.
    """
    design = DesignStudy(read_study(study), crew, out)
    yield from design.run(search=True)
    yield from design.write()
    return Findings(design.campaign).is_confirmed()
