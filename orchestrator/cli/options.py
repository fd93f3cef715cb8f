"""What the commands of ``flipflow`` take alike."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

CasePath = Annotated[Path, typer.Argument(metavar="CASE", help="folder of the case")]
RunPath = Annotated[Path, typer.Argument(metavar="RUN", help="folder of a run")]
Level = Annotated[
    str | None, typer.Option("--level", help="one of the case's levels [default: the case's default_level]")
]
Overrides = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="gives a key another value, for example panel.solver=rigid; may be repeated",
    ),
]
