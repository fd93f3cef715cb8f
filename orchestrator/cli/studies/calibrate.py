"""``flipflow study calibrate``: factors at which measured targets are met."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.options import StudyOutput, shipped_or_own
from orchestrator.studies.design.calibration import calibrate
from orchestrator.studies.design.calibration_report import tell, write_calibration
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import Crew
from orchestrator.workbench import StudyFolder


def command(
    studies: Annotated[
        list[Path], typer.Argument(metavar="STUDY...", help="study.toml of design studies, or their folders")
    ],
    out: Annotated[
        Path | None, typer.Option("--out", help="folder of the calibration [default: runs/calibration]")
    ] = None,
) -> StudyOutput:
    """Find the factors at which the targets of design studies are met, with intervals; nothing is run.

    A factor of one name is one factor in all studies: a heap, a shear box and a bulk density together tell
    what none of them tells alone.  The folder gets calibration.csv and calibration.png.

    Exit code 4: no setting meets the targets, or a factor is not found.
    """
    designs = []
    for path in map(shipped_or_own, studies):
        designs.append(DesignStudy(read_study(path), Crew(), path if path.is_dir() else None))
        designs[-1].load_finished()
    folder = StudyFolder(out or Path("runs") / "calibration").admit()
    found = calibrate([design.campaign for design in designs])
    yield from write_calibration(found, folder)
    yield from tell(found)
    return not found.missed() and all(factor.is_found for factor in found.factors())
