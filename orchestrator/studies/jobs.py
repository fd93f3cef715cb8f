"""The runs of a study as jobs for a scheduler of a cluster: a list of commands, and a script for Slurm."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path

from orchestrator.studies.points import Point
from orchestrator.workbench import StudyFolder

JOBS, SCRIPT = "jobs.txt", "job.sh"
SLURM = """#!/bin/bash
# The runs of a study, one in each task: sbatch {script}
# Then call the command of the study again, without --write-jobs, for its tables.
#SBATCH --job-name=flipflow
#SBATCH --array=1-{count}
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --time=24:00:00
#SBATCH --output=%x-%A-%a.log

eval "$(sed -n "${{SLURM_ARRAY_TASK_ID}}p" {jobs})"
"""


def write_jobs(points: Sequence[Point], folder: Path) -> list[Path]:
    """Write the commands of points, one a line, and a script that makes each line a task; return the files.

    A command makes the run of its point.  It does nothing where the run is done, and makes a run again that
    was ended too early.
    """
    lines = dict.fromkeys(shlex.join(point.job) for point in points)  # a plan may have a point twice
    at = StudyFolder(folder)
    script, jobs = ((folder / name).resolve() for name in (SCRIPT, JOBS))
    text = SLURM.format(count=len(lines), script=shlex.quote(str(script)), jobs=shlex.quote(str(jobs)))
    folder.mkdir(parents=True, exist_ok=True)
    return [at.write_text(JOBS, "\n".join([*lines, ""])), at.write_text(SCRIPT, text)]
