"""Reading STL files, read by meshio."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from pathlib import Path

import meshio
import numpy as np

from orchestrator.casefile.toml_file import is_outside
from orchestrator.ports import Array, Indices

LARGEST_BYTES = 200_000_000  # four million triangles
BINARY_HEAD = struct.Struct("<80xI")  # words, then the number of triangles
BINARY_TRIANGLE_BYTES = 50
TAIL_BYTES = 400  # of a text, with room for the solid's name after its last word


class Unreadable(Exception):
    """The file is missing, empty or no STL; the message says which."""


@dataclass(frozen=True)
class Facets:
    """``position_m`` (n, 3) each corner once, ``triangles`` (m, 3), ``normal`` (m, 3) as the
    file states them (zero where it states none)."""

    position_m: Array
    triangles: Indices
    normal: Array


def read(folder: Path, name: str) -> Facets:
    """The file of this name in the case's ``folder``.  Raises Unreadable."""
    file = found(folder, name)
    try:
        if not _is_whole(file):
            raise Unreadable("is cut off, or no STL file: it does not end with endsolid")
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


def found(folder: Path, name: str) -> Path:
    """A file that is really in ``folder``.  Raises Unreadable."""
    file = folder / name
    try:
        if not file.is_file():
            raise Unreadable("no such file")
        if is_outside(file, folder):
            raise Unreadable("is outside of the case's folder: copy it there")
        if file.stat().st_size > LARGEST_BYTES:
            raise Unreadable(f"is larger than {LARGEST_BYTES} bytes")
    except (OSError, ValueError):  # a name that is too long, or has a NUL
        raise Unreadable("is no name of a file") from None
    return file


def _is_whole(file: Path) -> bool:
    """Whether a binary file is as long as it says, or a text ends as it must."""
    size = file.stat().st_size
    with file.open("rb") as opened:
        head = opened.read(BINARY_HEAD.size)
        if len(head) == BINARY_HEAD.size:
            (count,) = BINARY_HEAD.unpack(head)
            if size == BINARY_HEAD.size + BINARY_TRIANGLE_BYTES * count:
                return True
        opened.seek(max(0, size - TAIL_BYTES))
        return b"endsolid" in opened.read()
