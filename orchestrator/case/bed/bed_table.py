"""Tables of particles, as users give them: CSV or Parquet files of any size, one row per particle."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.bed.saved_bed import UnreadableBed
from orchestrator.case.file.errors import did_you_mean
from orchestrator.case.file.plausible import RANGES
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.ports import Array
from orchestrator.ports.grains import Grain, ShapeTable

PLACES = ("x_m", "y_m", "z_m")
VELOCITIES = ("vx_m_per_s", "vy_m_per_s", "vz_m_per_s")
SPINS = ("wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s")
SIZE = "sieve_size_m"
NUMBERS = (*PLACES, SIZE, *VELOCITIES, *SPINS)
REQUIRED = (*PLACES, SIZE, "material")
SMALLEST_M, LARGEST_M = RANGES[SIZE]
KNOWN = (*NUMBERS, "material", "id")
"""All columns; ``id`` is allowed and not used, because ids are given anew."""


def read_table(path: Path) -> CarriedBed:
    """Read a table of particles; a missing column of a velocity or spin counts as 0.

    Raises UnreadableBed with all that is wrong in the table.
    """
    table = _read(path)
    if wrong := [*_wrong_columns(table), *_wrong_cells(table)]:
        raise UnreadableBed(f"{path}: " + "; ".join(wrong))
    names, material = np.unique(table["material"].to_numpy(str), return_inverse=True)
    count = len(table)

    def vectors(columns: tuple[str, ...]) -> Array:
        given = [table[name].to_numpy(float) if name in table else np.zeros(count) for name in columns]
        return np.column_stack(given)

    sizes_m, none = table[SIZE].to_numpy(float), np.full(count, np.nan)
    shape, spheres = np.zeros(count, dtype=np.int64), ShapeTable.of([solvers.shape("sphere")])
    return CarriedBed(
        materials=tuple(names.tolist()),
        position_m=vectors(PLACES),
        velocity_m_per_s=vectors(VELOCITIES),
        spin_rad_per_s=vectors(SPINS),
        grains=Grain(sizes_m, none, material, shape, spheres),
        time_s=np.nan,
        coarse_graining=np.nan,
        source=str(path),
    )


def _read(path: Path) -> Any:
    """Return the table as a DataFrame.  Raises UnreadableBed."""
    import pandas as pd  # It is imported here because most cases have no table of particles.

    read_csv = partial(pd.read_csv, comment="#", skipinitialspace=True)
    read = {".csv": read_csv, ".parquet": pd.read_parquet}.get(path.suffix.lower())
    if read is None:
        raise UnreadableBed(f'{path}: "{path.suffix}" is no kind of table; a .csv or .parquet file is wanted')
    if path.exists() and not path.is_file():
        raise UnreadableBed(f"{path}: is no file")
    try:
        return read(path)
    except (OSError, ValueError, ImportError) as error:
        raise UnreadableBed(f"{path}: cannot be read ({str(error).splitlines()[0]})") from None


def _wrong_columns(table: Any) -> Iterator[str]:
    """Yield a text for each column that is missing or unknown, and for a table without rows."""
    for name in REQUIRED:
        if name not in table:
            yield f'there is no column "{name}"'
    for name in table.columns:
        if name not in KNOWN:
            yield f'the column "{name}" is unknown ({did_you_mean(str(name), KNOWN)})'
    if not len(table):
        yield "there are no rows"


def _wrong_cells(table: Any) -> Iterator[str]:
    """Yield a text for each column with a cell that is not a finite number, or not a plausible size."""
    import pandas as pd

    for name in NUMBERS:
        if name not in table:
            continue
        values = pd.to_numeric(table[name], errors="coerce").to_numpy(float)
        wrong = ~np.isfinite(values)
        if name == SIZE:
            wrong |= (values < SMALLEST_M) | (values > LARGEST_M)
        if wrong.any():
            row = int(np.argmax(wrong))
            wanted = "a plausible size in m" if name == SIZE else "a number"
            others = f" ({wrong.sum() - 1} more)" if wrong.sum() > 1 else ""
            yield f"row {row + 1}: {name} = {table[name].iloc[row]!r} is not {wanted}{others}"
    if "material" in table and table["material"].isna().any():
        yield f"row {int(np.argmax(table['material'].isna())) + 1} has no material"
