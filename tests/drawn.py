"""Drawings that a test writes: panels with openings as DXF files."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import ezdxf
import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.geometry import AperturePattern, Rectangle


def new_drawing(unit: int = 4) -> Any:
    """Return an empty drawing; ``unit`` is its $INSUNITS: 4 mm, 6 m, 0 none."""
    drawing = ezdxf.new("R2010")
    drawing.units = unit
    return drawing


def write_drawing(
    file: Path, outlines: Iterable[Array], sheet: tuple[float, float] | None = None, unit: int = 4
) -> Path:
    """Write closed polylines, and around them the outline of a panel of these sides; returns the file."""
    drawing = new_drawing(unit)
    space = drawing.modelspace()
    if sheet is not None:
        space.add_lwpolyline([(0, 0), (sheet[0], 0), sheet, (0, sheet[1])], close=True)
    for outline in outlines:
        space.add_lwpolyline([*map(tuple, outline)], close=True)
    drawing.saveas(file)
    return file


def draw_pattern(file: Path, pattern: AperturePattern, panel: Rectangle) -> Path:
    """Write a panel with a pattern in m, clamped strips included; returns the file."""
    outlines_m = (outline + np.array([panel.clamp_m, 0.0]) for outline in pattern.outlines_m(panel))
    return write_drawing(file, outlines_m, (panel.length_m + 2 * panel.clamp_m, panel.width_m), unit=6)
