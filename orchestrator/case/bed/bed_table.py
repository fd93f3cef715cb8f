"""Tables of particles, as users and other programs give them, of any size, with one row per particle.

The names of columns are those of flipflow, or those that EDEM, Rocky, LIGGGHTS, LAMMPS, YADE and ParaView
use.  Columns without a unit are in SI units where the kind of file is one that a particle code writes; of any
other file it is asked.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.bed.saved_bed import UnreadableBed
from orchestrator.case.file.data_file import answers_in
from orchestrator.case.file.data_table import (
    IGNORE,
    Answers,
    Column,
    DataTable,
    TableError,
    answer,
    decode,
    read_text,
    split_head,
)
from orchestrator.case.file.errors import did_you_mean, show_value
from orchestrator.case.file.particle_files import (
    BY_CODE,
    LISTS,
    VTK,
    is_data_file,
    is_dump,
    read_data_file,
    read_dump,
    read_vtk,
)
from orchestrator.case.file.plausible import RANGES
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import unit_of
from orchestrator.ports import Array
from orchestrator.ports.grains import Grain, ShapeTable

PLACES = ("x_m", "y_m", "z_m")
VELOCITIES = ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s")
SPINS = ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s")
SIZE, RADIUS, DENSITY = "sieve_size_m", "radius_m", "density_kg_per_m3"
MEASURED = {*PLACES, *VELOCITIES, *SPINS, SIZE, RADIUS, DENSITY}
KNOWN = (*PLACES, SIZE, *VELOCITIES, *SPINS, "material", "id")
SMALLEST_M, LARGEST_M = RANGES[SIZE]
PLACE = "coordinates?|coords?|position|pos|centre|center|centroid|points"
VELOCITY = "velocity|vel|v|linvelvec|linvel"
SPIN = "angular velocity|omega|spin|angvelvec|angvel"


def _of_axis(axis: str, number: int) -> dict[str, str]:
    """Return the patterns of the names of columns that belong to one axis."""
    here, whose = f"(?:{axis}|{number})", "(?:particles? )?"
    return {
        f"{axis}_m": rf"{whose}(?:{axis}u?|(?:{PLACE}) {here}|{axis} (?:{PLACE})|(?:pos|coord){axis})",
        f"v{axis}_m_per_s": rf"{whose}(?:translational )?"
        rf"(?:v{axis}|vel{axis}|(?:{VELOCITY}) {here}|{axis} (?:{VELOCITY}))",
        f"w{axis}_rad_per_s": rf"{whose}(?:w ?{axis}|omega{axis}|(?:{SPIN}) {here}|{axis} (?:{SPIN}))",
    }


MEANINGS = {
    **_of_axis("x", 0),
    **_of_axis("y", 1),
    **_of_axis("z", 2),
    # Rocky's size is a sieve's
    SIZE: "sieve size|particle size|(?:particle |sphere )?(?:diameter|dia|d)|durchmesser|ø",
    RADIUS: "(?:particle |sphere )?(?:radius|radii|rad|r)",
    DENSITY: "(?:particle )?(?:density|rho)|dichte",
    "material": "(?:particle )?material(?: name)?|mat|werkstoff",
    "type": "(?:particle |atom )?type|mat(?:erial)? ?ids?",
    "id": "(?:particle |atom )?ids?",
}
"""The names, in small letters, of each column that a table of particles may have."""
NEEDLESS = r"index|no|nr|number|mol|proc|i[xyz]|(?:particle )?(?:mass|volume)"
"""The names of columns that say nothing that is missing."""


def read_table(path: Path, case: Case) -> CarriedBed:
    """Read the table of particles of a case; a missing column of a velocity or spin counts as 0.

    Raises UnreadableBed with all that is wrong in the table, or what it leaves open.
    """
    try:
        return _particles(_read(path, answers_in(dict(case.bed))), path, case)
    except TableError as error:
        raise UnreadableBed(f"{path}: {error}") from None


def _read(path: Path, answers: Answers) -> DataTable:
    """Return the columns of a file.  Raises TableError."""
    if path.exists() and not path.is_file():  # a pipe would be waited for
        raise TableError("is not a file")
    kind = path.suffix.lower()
    try:
        if kind == ".parquet":
            return _renamed(_parquet(path), answers)
        if kind in LISTS:
            raise TableError(f"names other files; give one of these ({', '.join(VTK)})")
        if kind in VTK:
            return _renamed(read_vtk(path), answers)
        text = decode(path.read_bytes())
    except OSError as error:
        raise TableError(f"cannot be read: {error.strerror or error}") from None
    if is_dump(text):
        return _renamed(read_dump(text), answers)
    if is_data_file(text):
        return _renamed(read_data_file(text), answers)
    table = read_text(text, answers)
    of_paraview = any(column.name == "points 0" for column in table.columns)
    return replace(table, form=BY_CODE) if of_paraview else table


def _parquet(path: Path) -> DataTable:
    import pandas as pd  # It is imported here because most cases have no table of particles.

    try:
        frame = pd.read_parquet(path)
    except (ValueError, ImportError) as error:
        raise TableError(f"cannot be read: {str(error).splitlines()[0]}") from None
    lines, names = range(1, len(frame) + 1), [*map(str, frame.columns)]
    return DataTable(
        tuple(Column(name, *split_head(name), _cells(frame[name]), lines) for name in names if name in frame)
    )


def _cells(values: Any) -> Any:
    """Return a column of pandas as numbers, or as texts with "" for what is missing."""
    if values.dtype.kind in "iuf":
        return values.to_numpy()
    return ["" if value is None or value != value else str(value) for value in values.tolist()]


def _renamed(table: DataTable, answers: Answers) -> DataTable:
    """Return a table whose columns have the names that a user gives them.  Raises TableError."""
    answers.check([column.head for column in table.columns])
    renamed = []
    for column in table.columns:
        as_if = answers.columns.get(column.head)
        if as_if is not None:
            name, unit = split_head(as_if)
            column = replace(column, name=name, unit=unit or column.unit)
        if as_if != IGNORE:
            renamed.append(column)
    return replace(table, columns=tuple(renamed))


def _particles(table: DataTable, path: Path, case: Case) -> CarriedBed:
    """Return the particles in a table.  Raises TableError."""
    known, others = table.meanings(MEANINGS)
    if wrong := [*_open_questions(known, others, table)]:
        raise TableError(*wrong)
    faults: list[str] = []
    count = len(table)

    def numbers(key: str) -> Array:
        try:
            if key in known:
                return known[key].numbers(key, unit_of(key))
        except TableError as error:
            faults.extend(error.reasons)
        return np.zeros(count)

    size = RADIUS if RADIUS in known else SIZE
    sizes_m = numbers(size) * (2 if size == RADIUS else 1)
    place_m, velocity_m_per_s, spin_rad_per_s = (
        np.column_stack([*map(numbers, keys)]) for keys in (PLACES, VELOCITIES, SPINS)
    )
    density = numbers(DENSITY) if DENSITY in known else np.full(count, np.nan)
    given, note = _materials(known, case, count, faults)
    faults += _implausible(sizes_m, known[size]) if not faults else []
    if faults:
        raise TableError(*faults)
    names, material = np.unique(np.array(given, dtype=str), return_inverse=True)
    shape, spheres = np.zeros(count, dtype=np.int64), ShapeTable.of([solvers.shape("sphere")])
    in_si = "in SI units, as such files are" if not known["x_m"].unit else ""
    return CarriedBed(
        materials=tuple(names.tolist()),
        position_m=place_m,
        velocity_m_per_s=velocity_m_per_s,
        spin_rad_per_s=spin_rad_per_s,
        grains=Grain(sizes_m, density, material, shape, spheres),
        time_s=np.nan,
        coarse_graining=np.nan,
        source=str(path),
        note=", ".join(part for part in (table.note, in_si, note) if part),
    )


def _open_questions(known: dict[str, Column], others: list[Column], table: DataTable) -> Iterator[str]:
    """Yield what is missing in a table's head, and what it leaves open."""
    sizes = [column for column in others if {"size", "s"} & {*column.name.split()}]
    for column in sizes:
        diameter = answer(column.head, "diameter / mm")
        yield f'is {show_value(column.head)} a radius or a diameter? {diameter} or "radius / mm"'
    wanted = [*PLACES, *([SIZE] if RADIUS not in known and not sizes else [])]
    for key in (key for key in wanted if key not in known):
        hint = "have it written, too"
        if others and table.form != BY_CODE:
            name = f"{split_head(key)[0]} / {others[0].unit or 'm'}"
            hint = f"{answer(others[0].head, name)} would name it"
        yield f'there is no column "{key}"; {hint}'
    if SIZE in known and RADIUS in known:
        yield f"has a radius and a diameter; {answer(known[RADIUS].head, IGNORE)} leaves one out"
    clumps = [column for column in others if column.name in ("clumpid", "clump id")]
    if any(float(cell) >= 0 for column in clumps for cell in column.texts if cell.lstrip("-").isdigit()):
        yield "has clumps, and spheres are wanted"
    if table.form == BY_CODE:  # such files have many columns more
        return
    for column in others:
        if column not in sizes and not re.fullmatch(NEEDLESS, column.name):
            hint, leave_out = did_you_mean(column.head, KNOWN), answer(column.head, IGNORE)
            yield f"the column {show_value(column.head)} is unknown ({hint}); {leave_out} leaves it out"
    if bare := [column.head for key, column in known.items() if key in MEASURED and not column.unit]:
        columns = ", ".join(map(show_value, bare[:8]))
        yield f"in which unit are {columns}: m or mm? {answer(bare[0], f'{bare[0]} / m')} and so on"


def _materials(known: dict[str, Column], case: Case, count: int, faults: list[str]) -> tuple[list[str], str]:
    """Return the material of each particle, and in words where it comes from if not from the table.

    Types are numbers of another program, whose materials only the user knows, unless the case has one
    material for particles: that which has a contact with itself.
    """
    told, alone = case.bed.material, [a for a, b in (row.between for row in case.contacts) if a == b]
    column = known.get("material", known.get("type"))
    texts = column.texts if column is not None else []
    kinds = sorted({*texts})
    if isinstance(told, dict):
        if missing := sorted({*kinds} - {*told}) if texts else ["no type"]:
            faults.append(f"bed.material lacks {missing[0]}; the table has {', '.join(kinds) or 'no types'}")
        return [told.get(text, "") for text in texts], ""
    if column is not None and "material" in known and not all(text.isdigit() for text in texts):
        if "" in texts:
            faults.append(f"line {column.lines[texts.index('')]} has no material")
        return texts, ""
    if told is not None:
        return [told] * count, ""
    if len(alone) == 1 and len(kinds) < 2:
        return alone * count, f"all of {alone[0]}"
    example = f'"{(alone or ["..."])[0]}"'
    if len(kinds) > 1:
        example = f"{{{', '.join(f'{kind} = {example}' for kind in kinds[:3])}}}"
    faults.append(f"of which material are they? No column says it; bed.material = {example} answers it")
    return [], ""


def _implausible(sizes_m: Array, column: Column) -> Iterator[str]:
    """Yield a text for sizes that no particle has, with the unit that they perhaps are in."""
    wrong = (sizes_m < SMALLEST_M) | (sizes_m > LARGEST_M)
    if wrong.any():
        row = int(np.argmax(wrong))
        others = f" ({wrong.sum() - 1} more)" if wrong.sum() > 1 else ""
        in_mm = f"; is it in mm? {answer(column.head, f'{column.name} / mm')}"
        what = f"line {column.lines[row]}: {column.head} = {column.texts[row]} is not a plausible size"
        yield f"{what}{others}{in_mm if sizes_m[row] > LARGEST_M else ''}"
