"""What the commands of ``flipflow`` take alike."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from orchestrator.studies.options import CasePath, Level, Overrides

__all__ = ["CasePath", "Level", "Overrides", "RunPath"]

RunPath = Annotated[Path, typer.Argument(metavar="RUN", help="folder of a run")]
