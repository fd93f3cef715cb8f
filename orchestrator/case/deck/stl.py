"""A reader of STL files, binary or text.

It reads text strictly.  Libraries skip lines that they do not know, and their answers about an empty
file depend on the version.
"""

from __future__ import annotations

import re
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
DECIMAL_COMMA = re.compile(rb"\d,\d")
WORDS_BETWEEN = (b"outer", b"endloop")  # In a text these stand around the corners of each facet.
BOM, PADDING = b"\xef\xbb\xbf", b"\0\x1a \t\r\n"  # what editors put before a text, and disks behind it
TAIL_BYTES = 400  # The end of a text has room for the solid's name after its last word.


class UnreadableSurface(Exception):
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
    """Read the STL file of this name in the case's ``folder``.  Raises UnreadableSurface."""
    return read_file(find_file(folder, name))


def read_file(file: Path) -> Facets:
    """Read an STL file.  Raises UnreadableSurface."""
    try:
        if (count := _binary_count(file)) is not None:
            normal, corner_m = _binary(file, count)
        elif not _ends(file):
            raise UnreadableSurface("is cut off, or no STL file: it does not end with endsolid")
        else:
            normal, corner_m = _text(file)
    except OSError as error:
        raise UnreadableSurface(f"cannot be read ({error.strerror})") from None
    if len(normal) == 0:
        raise UnreadableSurface("has no triangles")
    if not np.isfinite(corner_m).all():
        raise UnreadableSurface("has coordinates that are not numbers")
    return Facets(*each_corner_once(corner_m), normal)


def _binary(file: Path, count: int) -> tuple[Array, Array]:
    """Read the normals (n, 3) and the corners (3 n, 3) of all ``count`` triangles in a binary file."""
    triangles = np.fromfile(file, dtype=BINARY_TRIANGLE, offset=BINARY_HEAD.size, count=count)
    return triangles["normal"].astype(float), triangles["corners"].reshape(-1, 3).astype(float)


def _text(file: Path) -> tuple[Array, Array]:
    """Read the normals (n, 3) and the corners (3 n, 3) of all triangles in a text file.

    Raises UnreadableSurface, which names the first line that does not belong into an STL file.
    """
    normal, corner_m = array("d"), array("d")
    inside = False  # This is true between the words solid and endsolid.
    with file.open("rb") as lines:
        for number, line in enumerate(lines, start=1):
            words = line.removeprefix(BOM).strip(PADDING).split()
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
                comma = "; write points for decimal commas" if DECIMAL_COMMA.search(line) else ""
                raise UnreadableSurface(f"is not an STL file (line {number}: {shown!r}){comma}") from None
    if len(corner_m) != 3 * len(normal):
        raise UnreadableSurface("is not an STL file (its last triangle lacks a corner)")
    return np.array(normal).reshape(-1, 3), np.array(corner_m).reshape(-1, 3)


def _three_numbers(words: list[bytes]) -> list[float]:
    """Return the numbers that three words stand for.  Raises ValueError."""
    x, y, z = words
    return [float(x), float(y), float(z)]


def each_corner_once(corner_m: Array) -> tuple[Array, Indices]:
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

    Raises UnreadableSurface.
    """
    file = folder / name
    try:
        if not file.is_file():
            raise UnreadableSurface("no such file")
        if all(is_outside(file, each) for each in case_folders(folder)):
            raise UnreadableSurface("is outside of the case's folder: copy it there")
        if file.stat().st_size > LARGEST_BYTES:
            raise UnreadableSurface(f"is larger than {LARGEST_BYTES} bytes")
    except (OSError, ValueError):  # The name is too long, or it contains a NUL.
        raise UnreadableSurface("is not a name of a file") from None
    return file


def _binary_count(file: Path) -> int | None:
    """Return the number of triangles that the head of a binary file states; None for a text.

    The first words do not decide it: text may begin with anything, and binary files with "solid".  A file is
    binary if it is as long as its head requires.  Some programs append data of their own: a longer file is
    binary if its head has characters that no text has.
    """
    with file.open("rb") as opened:
        head = opened.read(BINARY_HEAD.size)
    if len(head) < BINARY_HEAD.size:
        return None
    (count,) = BINARY_HEAD.unpack(head)
    size: int = BINARY_HEAD.size + BINARY_TRIANGLE.itemsize * count
    found = file.stat().st_size
    no_text = any(byte < 9 for byte in head)
    return count if size == found or (count and size < found and no_text) else None


def _ends(file: Path) -> bool:
    """Return whether a text ends with endsolid, as it must."""
    with file.open("rb") as opened:
        opened.seek(max(0, file.stat().st_size - TAIL_BYTES))
        return b"endsolid" in opened.read().lower()
