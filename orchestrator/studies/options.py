"""What the commands take alike: the case with its level and overlays, and how a study is run."""

from __future__ import annotations

from collections.abc import Generator
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Table

from orchestrator.studies.workers import Crew, workers_that_fit

Told = Generator[str | Table | Path, None, bool]
"""What a study's command yields to be said, files that it wrote among it; it returns whether all is
well."""

CasePath = Annotated[Path, typer.Argument(metavar="CASE", help="folder of the case")]
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
Out = Annotated[Path | None, typer.Option("--out", help="folder of the study [default: runs/<case>-<study>]")]
Workers = Annotated[
    int | None,
    typer.Option("--workers", "--jobs", min=1, help="runs at a time [default: as the machine bears]"),
]
Scheduler = Annotated[
    str, typer.Option("--scheduler", help="address of a Dask scheduler with workers elsewhere")
]


def crew(workers: int | None, scheduler: str) -> Crew:
    """Returns the workers that were asked for; by default as many as the machine bears."""
    return Crew(workers or workers_that_fit(), scheduler)


def folder_of(case: Path, study: str, out: Path | None) -> Path:
    """Returns where a study of a case is kept."""
    return out or Path("runs") / f"{case.resolve().name}-{study}"
