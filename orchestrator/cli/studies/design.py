"""``flipflow study design``: the planned runs of a design study."""

from __future__ import annotations

from typing import Annotated

import typer

from orchestrator.cli.options import Out, StudyOutput, StudyPath, WriteJobs
from orchestrator.output.tables import console_table
from orchestrator.preflight.cost import in_words
from orchestrator.studies import jobs
from orchestrator.studies.design.campaign import planned_settings
from orchestrator.studies.design.page import hours_in_words
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import Crew


def command(
    study: StudyPath,
    crew: Crew,
    out: Out = None,
    dry: Annotated[bool, typer.Option("--dry", help="list the runs, predict their time, and stop")] = False,
    write_jobs: WriteJobs = False,
) -> StudyOutput:
    """Run the plan of a design study: the centre, then settings over the ranges of all factors.

    The centre and all corners are checked first; the rest runs if the centre has all responses.  Called
    again, only missing runs are made.  The results are those of flipflow study fit.

    Exit code 4: a run is no data.
    """
    design = DesignStudy(read_study(study), crew, out)
    if dry:
        yield from _foretell(design)
        return True
    if write_jobs:
        yield from jobs.write_jobs(design.planned_points(), design.folder)
        return True
    yield from design.run(search=False)
    yield from design.write()
    return all(outcome.is_data for outcome in design.campaign.outcomes)


def _foretell(design: DesignStudy) -> StudyOutput:
    """Check the corners, list the planned settings, and predict the time of those that are left."""
    design.check()
    design.load_finished()
    campaign, file = design.campaign, design.study.file
    settings = planned_settings(design.study)
    rows = [
        [str(number), *(f"{value:.4g}" for value in design.study.actual(setting).values())]
        for number, setting in enumerate(settings, start=2)
    ]
    yield "planned settings, after the centre:"
    yield console_table("", ["run", *file.factors], rows)
    each_s = campaign.mean_wall_s() or design.runs.centre.predicted_s
    left, count = campaign.planned_left, len(settings) + file.plan.centres
    sides = design.runs.side_by_side
    source = f"the mean of {len(campaign.outcomes)}" if campaign.outcomes else "predicted from the case"
    runs = f"{left} runs" if left == count else f"{left} of {count} runs are left,"
    all_s = left * each_s / sides
    yield f"{runs} of {in_words(each_s)} each, {source}, on {sides} workers: {in_words(all_s)}"
    if beyond := campaign.beyond_hours(each_s):
        yield (
            f"{beyond} of them will not be made: they do not fit into {hours_in_words(campaign)}; "
            "give more hours"
        )
    elif file.hours is not None:
        more = int(3600 * file.hours * sides / each_s) - count
        yield f"{max(more, 0)} more fit into {file.hours:g} h"
    return True
