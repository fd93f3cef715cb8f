"""``flipflow study calibrate``: factors at which measured targets are met."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.cli.options import StudyOutput, shipped_or_own
from orchestrator.studies.design.calibration import calibrate
from orchestrator.studies.design.calibration_report import tell, write_calibration
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import StudyError, read_study
from orchestrator.studies.design.surrogates import TooFewPoints
from orchestrator.studies.points import Crew
from orchestrator.workbench import CaseProblem, FolderUnusable, StudyFolder


def command(
    studies: Annotated[
        list[Path], typer.Argument(metavar="STUDY...", help="study.toml of design studies, or their folders")
    ],
    known: Annotated[
        list[str] | None,
        typer.Option("--known", metavar="FACTOR=VALUE", help="a factor that is not sought; may be repeated"),
    ] = None,
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
        designs[-1].check_data()
    folder = StudyFolder(out or Path("runs") / "calibration").admit()
    try:
        found = calibrate([design.campaign for design in designs], dict(map(_number, known or [])))
    except TooFewPoints as error:
        raise FolderUnusable(f"{error}; more runs are needed") from None
    yield from write_calibration(found, folder)
    yield from tell(found)
    return not found.missed() and all(factor.is_found for factor in found.factors())


def _number(text: str) -> tuple[str, float]:
    """Return the name and the value of a known factor.  Raises StudyError."""
    name, _, value = text.partition("=")
    try:
        return name.strip(), float(value)
    except ValueError:
        problem = CaseProblem((), f'"{text}" is not FACTOR=VALUE', "as bond=0", file="--known")
        raise StudyError([problem]) from None
