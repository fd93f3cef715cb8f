"""Files of particles that particle codes and ParaView write, as tables: dumps and data files of LIGGGHTS and
LAMMPS, and VTK files.

Formats: LAMMPS documentation, ``dump`` (style custom) and ``read_data`` (atom style sphere); LIGGGHTS calls
that style granular, too.
"""

from __future__ import annotations

import re
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from orchestrator.case.file.data_table import Column, DataTable, TableError, split_head
from orchestrator.ports import Array

VTK = (".vtk", ".vtu", ".vtp")
LONGEST_S = 120.0  # time that reading a VTK file may take
LISTS = (".pvd", ".pvtu", ".pvtp", ".vtm", ".series")
BY_CODE = "particles"
SPHERES = ("id", "type", "diameter", "density", "x", "y", "z")
SPHERE_STYLES = ("sphere", "granular")
MOTIONS = ("vx", "vy", "vz", "omegax", "omegay", "omegaz")
SHAPED = {"quatw", "shapex", "c_quat[1]"}
CGS = {"x": "cm", "y": "cm", "z": "cm", "xu": "cm", "yu": "cm", "zu": "cm", "radius": "cm", "diameter": "cm"}
CGS |= {"vx": "cm/s", "vy": "cm/s", "vz": "cm/s", "density": "g/cm3"}


def is_dump(text: str) -> bool:
    """Return whether a text is a dump of LIGGGHTS or LAMMPS."""
    return text.lstrip().startswith("ITEM:")


def is_data_file(text: str) -> bool:
    """Return whether a text is a data file of LIGGGHTS or LAMMPS."""
    return bool(re.search(r"^\s*\d+\s+atoms\s*$", text[:5000], re.MULTILINE))


def read_dump(text: str) -> DataTable:
    """Return the particles of the last time step of a dump.  Raises TableError."""
    parts = re.split(r"^ITEM: *", text.replace("\r", ""), flags=re.MULTILINE)
    begins = [place for place, part in enumerate(parts) if part.startswith("TIMESTEP")]
    last = parts[begins[-1] :] if begins else []
    frame = {re.match(r"[A-Z ]*", part)[0].strip(): part for part in last}  # type: ignore[index]
    if missing := [name for name in ("NUMBER OF ATOMS", "ATOMS") if name not in frame]:
        raise TableError(f"is not a whole dump of particles: there is no ITEM: {missing[0]}")
    names = frame["ATOMS"].split("\n", 1)[0].split()[1:]
    before = sum(part.count("\n") for part in parts[: parts.index(frame["ATOMS"])]) + 1
    rows = [
        (before + n, line.split()) for n, line in enumerate(frame["ATOMS"].split("\n")[1:], 1) if line.strip()
    ]
    told = frame["NUMBER OF ATOMS"].split()[-1]
    if told != str(len(rows)):
        raise TableError(f"is not a whole dump: it has {len(rows)} of {told} particles in its last time step")
    units = next((part.split()[-1] for part in parts if part.startswith("UNITS")), "si")
    if units not in ("si", "cgs"):
        raise TableError(f'is in the units "{units}", and those of "si" or "cgs" are wanted')
    if SHAPED & {*names}:
        raise TableError("has particles that are not spheres; give spheres")
    columns = _columns(names, rows, CGS if units == "cgs" else {})
    step = frame["TIMESTEP"].split()[-1]
    note = f"the last of {len(begins)} time steps, {step}" if len(begins) > 1 else ""
    return DataTable(_unscaled(columns, frame), BY_CODE, note)


def _unscaled(columns: Sequence[Column], frame: dict[str, str]) -> tuple[Column, ...]:
    """Return the columns with places in the box (xs or xsu) as places in the world.  Raises TableError."""
    scaled = {f"{axis}{end}": number for number, axis in enumerate("xyz") for end in ("s", "su")}
    if not scaled.keys() & {column.name for column in columns}:
        return tuple(columns)
    rows = [line.split() for line in frame.get("BOX BOUNDS", "").split("\n")[1:4]]
    try:
        low, high = np.array([[float(cell) for cell in row] for row in rows]).reshape(3, 2).T
    except ValueError:
        raise TableError("has scaled places (xs, ys, zs) in a box that is not a cuboid") from None
    return tuple(
        Column(
            column.head,
            column.name[0],
            column.unit,
            low[n] + column.numbers() * (high[n] - low[n]),
            column.lines,
        )
        if (n := scaled.get(column.name, -1)) >= 0
        else column
        for column in columns
    )


def read_data_file(text: str) -> DataTable:
    """Return the particles of a data file, whose atoms are of the style sphere.  Raises TableError."""
    lines = [re.sub(r"#.*", "", line).strip() for line in text.splitlines()]
    styles = re.findall(r"^\s*Atoms\s*(?:#\s*(\S+))?\s*$", text, re.MULTILINE)
    if len(styles) == 1 and styles[0] and styles[0] not in SPHERE_STYLES:
        raise TableError(f'has atoms of the style "{styles[0]}", and those of "sphere" are wanted')
    if len(styles) != 1 or not styles[0]:
        columns = ", ".join(SPHERES)
        raise TableError(f'does its section Atoms have {columns}? "Atoms # sphere" as its first line says so')
    rows = _section(lines, "Atoms")
    if wrong := [number for number, row in rows if len(row) not in (len(SPHERES), len(SPHERES) + 3)]:
        raise TableError(f"line {wrong[0]}: an atom of the style sphere has {len(SPHERES)} cells")
    told = next((line.split()[0] for line in lines if re.fullmatch(r"\d+\s+atoms", line)), "0")
    if told != str(len(rows)):
        raise TableError(f"is not whole: it has {len(rows)} of {told} particles")
    names = [*SPHERES]
    rows = [(number, row[: len(SPHERES)]) for number, row in rows]
    if moving := {row[0]: row[1:] for _, row in _section(lines, "Velocities")}:
        names += MOTIONS
        rows = [(number, [*row, *moving.get(row[0], ())]) for number, row in rows]
    return DataTable(_columns(names, rows, {}), BY_CODE)


def _section(lines: Sequence[str], name: str) -> list[tuple[int, list[str]]]:
    """Return the rows of a section of a data file, with their lines; none if it is not there."""
    rows = []
    begin = lines.index(name) + 1 if name in lines else len(lines)
    for number, line in enumerate(lines[begin:], begin + 1):
        if line and not re.match(r"[-+.\d]", line):
            break
        if line:
            rows.append((number, line.split()))
    return rows


def _columns(
    names: Sequence[str], rows: Sequence[tuple[int, list[str]]], units: dict[str, str]
) -> tuple[Column, ...]:
    """Return columns of these names.  Raises TableError for rows of another length."""
    if not rows:
        raise TableError("has no particles")
    if wrong := [(number, len(row)) for number, row in rows if len(row) != len(names)]:
        raise TableError(
            *(f"line {number}: {count} cells instead of {len(names)}" for number, count in wrong)
        )
    lines = [number for number, _ in rows]
    cells = [*zip(*(row for _, row in rows), strict=True)]
    return tuple(
        Column(name, split_head(name)[0], units.get(name, ""), cells[place], lines)
        for place, name in enumerate(names)
    )


def read_vtk(file: Path) -> DataTable:
    """Return the points of a VTK file with their arrays, of which vectors become columns "name:0" and so on.

    Raises TableError.
    """
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "points.npz"
        command = [sys.executable, "-m", "orchestrator.case.file.vtk_reader", str(file.resolve()), str(out)]
        try:
            subprocess.run(command, capture_output=True, timeout=LONGEST_S, check=True)
            with np.load(out) as stored:
                arrays = {name: stored[f"arr_{number}"] for number, name in enumerate(stored["names"])}
        except (subprocess.SubprocessError, OSError, ValueError):
            raise TableError("cannot be read: is it whole?") from None
    if not len(arrays["Points"]):
        raise TableError("has no particles")
    return DataTable(
        tuple(column for name, array in arrays.items() for column in _of_array(name, array)), BY_CODE
    )


def _of_array(name: str, array: Array) -> list[Column]:
    """Return a column for an array (n,), or one for each of its components (n, m)."""
    if array.ndim == 1:
        return [Column(name, *split_head(name), array, range(1, len(array) + 1))]
    heads = [f"{name}:{number}" for number in range(array.shape[1])]
    return [
        Column(head, *split_head(head), array[:, number], range(1, len(array) + 1))
        for number, head in enumerate(heads)
    ]
