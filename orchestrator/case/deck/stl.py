"""A reader of STL files, binary or text.

It reads text strictly.  Libraries skip lines that they do not know, and their answers about an empty
file depend on the version.
"""

from __future__ import annotations

import struct
from array import array
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from orchestrator.case.file.base import case_folders
from orchestrator.case.file.layers import is_outside
from orchestrator.ports import Array, Indices

LARGEST_BYTES = 200_000_000  # So many bytes are four million triangles.
BINARY_HEAD = struct.Struct("<80xI")  # The head has 80 characters of text and the number of triangles.
BINARY_TRIANGLE = np.dtype([("normal", "<f4", (3,)), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
WORDS_BETWEEN = (b"outer", b"endloop")  # In a text these stand around the corners of each facet.
TAIL_BYTES = 400  # The end of a text has room for the solid's name after its last word.


class UnreadableStl(Exception):
    """An error for a file that is missing, empty or no STL file; the message says which."""


@dataclass(frozen=True)
class Facets:
    """The content of an STL file.

    ``position_m`` (n, 3) has each corner once, and ``triangles`` (m, 3) has numbers of corners.
    ``normal`` (m, 3) has the normals that the file states; they are zero where it states none.
    """

    position_m: Array
    triangles: Indices
    normal: Array


def read(folder: Path, name: str) -> Facets:
    """Read the STL file of this name in the case's ``folder``.  Raises UnreadableStl."""
    file = find_file(folder, name)
    try:
        if _is_binary(file):
            normal, corner_m = _binary(file)
        elif not _ends(file):
            raise UnreadableStl("is cut off, or no STL file: it does not end with endsolid")
        else:
            normal, corner_m = _text(file)
    except OSError as error:
        raise UnreadableStl(f"cannot be read ({error.strerror})") from None
    if len(normal) == 0:
        raise UnreadableStl("has no triangles")
    if not np.isfinite(corner_m).all():
        raise UnreadableStl("has coordinates that are no numbers")
    return Facets(*_each_corner_once(corner_m), normal)


def _binary(file: Path) -> tuple[Array, Array]:
    """Read the normals (n, 3) and the corners (3 n, 3) of all triangles in a binary file."""
    triangles = np.fromfile(file, dtype=BINARY_TRIANGLE, offset=BINARY_HEAD.size)
    return triangles["normal"].astype(float), triangles["corners"].reshape(-1, 3).astype(float)


def _text(file: Path) -> tuple[Array, Array]:
    """Read the normals (n, 3) and the corners (3 n, 3) of all triangles in a text file.

    Raises UnreadableStl, which names the first line that does not belong into an STL file.
    """
    normal, corner_m = array("d"), array("d")
    inside = False  # This is true between the words solid and endsolid.
    with file.open("rb") as lines:
        for number, line in enumerate(lines, start=1):
            words = line.split()
            word = words[0].lower() if words else b""
            try:
                if word == b"vertex" and inside and len(corner_m) < 3 * len(normal):
                    corner_m.extend(_three_numbers(words[1:]))
                elif word == b"facet" and inside and words[1].lower() == b"normal":
                    normal.extend(_three_numbers(words[2:]))
                elif word in (b"solid", b"endsolid") and inside == (word == b"endsolid"):
                    inside = not inside
                elif word == b"endfacet" and len(corner_m) == 3 * len(normal):
                    continue
                elif word and not (word in WORDS_BETWEEN and inside):
                    raise ValueError
            except (ValueError, IndexError):
                shown = line[:80].decode(errors="replace").strip()
                raise UnreadableStl(f"is no STL file (line {number}: {shown!r})") from None
    if len(corner_m) != 3 * len(normal):
        raise UnreadableStl("is no STL file (its last triangle lacks a corner)")
    return np.array(normal).reshape(-1, 3), np.array(corner_m).reshape(-1, 3)


def _three_numbers(words: list[bytes]) -> list[float]:
    """Return the numbers that three words stand for.  Raises ValueError."""
    x, y, z = words
    return [float(x), float(y), float(z)]


def _each_corner_once(corner_m: Array) -> tuple[Array, Indices]:
    """Return each position (n, 3) once, in the order of its first appearance, and the triangles (m, 3)."""
    in_turn = np.lexsort(corner_m.T)  # keeps the order of equal ones, in half the time of np.unique
    is_new = np.ones(len(corner_m), dtype=np.bool_)
    is_new[1:] = (np.diff(corner_m[in_turn], axis=0) != 0.0).any(axis=1)
    which = np.empty(len(corner_m), dtype=np.int64)
    which[in_turn] = np.cumsum(is_new) - 1
    first = in_turn[is_new]
    order = np.argsort(first)
    return corner_m[first[order]], np.argsort(order)[which].reshape(-1, 3)


def find_file(folder: Path, name: str) -> Path:
    """Return the path of a file that is not too large and lies in a case's ``folder`` or that of a base.

    Raises UnreadableStl.
    """
    file = folder / name
    try:
        if not file.is_file():
            raise UnreadableStl("no such file")
        if all(is_outside(file, each) for each in case_folders(folder)):
            raise UnreadableStl("is outside of the case's folder: copy it there")
        if file.stat().st_size > LARGEST_BYTES:
            raise UnreadableStl(f"is larger than {LARGEST_BYTES} bytes")
    except (OSError, ValueError):  # The name is too long, or it contains a NUL.
        raise UnreadableStl("is no name of a file") from None
    return file


def _is_binary(file: Path) -> bool:
    """Return whether the file is as long as the number of triangles in its head requires.

    The first words do not decide it: text may begin with anything, and binary files with "solid".
    """
    with file.open("rb") as opened:
        head = opened.read(BINARY_HEAD.size)
    if len(head) < BINARY_HEAD.size:
        return False
    (count,) = BINARY_HEAD.unpack(head)
    size: int = BINARY_HEAD.size + BINARY_TRIANGLE.itemsize * count
    return file.stat().st_size == size


def _ends(file: Path) -> bool:
    """Return whether a text ends with endsolid, as it must."""
    with file.open("rb") as opened:
        opened.seek(max(0, file.stat().st_size - TAIL_BYTES))
        return b"endsolid" in opened.read().lower()
