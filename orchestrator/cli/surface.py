"""The answer of ``flipflow surface``: what a surface in a file has, what was healed, and its picture."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from orchestrator.case.deck.heal import Healed
from orchestrator.case.deck.stl import UnreadableSurface
from orchestrator.case.deck.surface_file import read_surface
from orchestrator.case.file.errors import CaseError, CaseProblem, from_validation
from orchestrator.case.file.units import parse_quantity
from orchestrator.case.tables.screen import Surface
from orchestrator.cli.console import refuse
from orchestrator.ports import Array
from orchestrator.ports.geometry import area_vectors_m2


def surface_table(file: str, unit: str | None, scale: float | None, tolerance: str | None) -> Surface:
    """Return the table of a case that has these words; ends with a message if they are wrong."""
    keys = {"file": file, "unit": unit, "scale": scale, "frame": "ground", "material": "any"}
    try:
        tolerance_m = None if tolerance is None else parse_quantity(tolerance, "tolerance_m")
    except ValueError as error:
        refuse(f"--tolerance {tolerance}: {error}")
    try:
        return Surface.model_validate(keys | {"tolerance_m": tolerance_m})
    except ValidationError as error:
        raise CaseError([*from_validation(error, Surface)]) from None


def describe_file(surface: Surface, folder: Path, out: Path) -> Iterator[str]:
    """Read a surface's file in a folder, draw it into ``out``, and yield lines about it.

    Raises CaseError for a file that cannot be read.
    """
    try:
        healed = read_surface(surface, folder)
    except UnreadableSurface as error:
        raise CaseError([CaseProblem((), str(error), file=str(surface.file), kind="file")]) from None
    yield from _lines(healed)
    _draw(healed, f"{surface.file}: {len(healed.triangles)} triangles", out)
    yield f"written: {out}"


def _lines(healed: Healed) -> Iterator[str]:
    low_m, high_m = healed.position_m.min(axis=0), healed.position_m.max(axis=0)
    area_m2 = np.linalg.norm(area_vectors_m2(healed.position_m[healed.triangles]), axis=1).sum()
    yield f"{len(healed.triangles)} triangles, {len(healed.position_m)} corners"
    yield f"size: {_triple(high_m - low_m, ' x ')} m, from ({_triple(low_m)}) to ({_triple(high_m)})"
    closed = f"open: {healed.open_edges} edges belong to one triangle alone"
    if not healed.open_edges:
        closed = f"closed: {healed.volume_m3:.4g} m3 within"
    yield f"area: {area_m2:.4g} m2; {closed}"
    yield f"healed: {', '.join(healed.healed) or 'nothing'}"
    if healed.left:
        yield f"unusual, and stays: {', '.join(healed.left)}"


def _triple(values: Array, between: str = ", ") -> str:
    return between.join(f"{value:.4g}" for value in values)


def _draw(healed: Healed, title: str, out: Path) -> None:
    from orchestrator.views.style import save
    from orchestrator.views.surface import draw_surface

    try:
        save(draw_surface(healed, title), out)
    except (OSError, ValueError) as error:
        refuse(f"{out}: {error}")
