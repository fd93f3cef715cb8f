"""Reading STL files, read by meshio."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from orchestrator.ports import Array, Indices


class Unreadable(Exception):
    """The file is missing, empty or no STL; the message says which."""


@dataclass(frozen=True)
class Facets:
    """``position_m`` (n, 3) each corner once, ``triangles`` (m, 3), ``normal`` (m, 3) as the
    file states them (zero where it states none)."""

    position_m: Array
    triangles: Indices
    normal: Array


def read(file: Path) -> Facets:
    """Raises Unreadable."""
    if not file.is_file():
        raise Unreadable("no such file")
    try:
        mesh = meshio.stl.read(file)
    except (meshio.ReadError, ValueError, IndexError, OSError, AttributeError) as error:
        raise Unreadable(f"is no STL file ({error})") from None
    triangles = np.asarray(mesh.cells_dict.get("triangle", np.empty((0, 3))), dtype=np.int64)
    if len(triangles) == 0:
        raise Unreadable("has no triangles")
    position_m = np.asarray(mesh.points, dtype=float)
    if not np.isfinite(position_m).all():
        raise Unreadable("has coordinates that are no numbers")
    normals = mesh.cell_data.get("facet_normals", [np.zeros((len(triangles), 3))])
    return Facets(position_m, triangles, np.asarray(normals[0], dtype=float))
