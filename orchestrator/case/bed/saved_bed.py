"""The file ``bed.h5``: all particles of one instant, in full precision.

Every checkpoint has one, and so has the folder of a run that began with particles taken over.  The names
of its datasets and attributes are the fields of ``CarriedBed`` and of its grains.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.file.folder import open_hdf5
from orchestrator.case.file.whole import written_whole
from orchestrator.case.tables.carried_bed import PLACED, CarriedBed
from orchestrator.case.tables.quantities import unit_of
from orchestrator.ports import ParticleSnapshot
from orchestrator.ports.grains import Grain, Grains, ShapeTable

FORMAT = 3
"""Version of the file, in its attribute ``format_version``."""
BED = "bed.h5"
GRAINS = ("sieve_size_m", "density_kg_per_m3", "material", "shape")
"""The columns of grains in all recorded files; the names of their shapes and materials stand beside them."""


class UnreadableBed(Exception):
    """An error for particles that cannot be read; the message says what is wrong and what helps."""


def from_snapshot(
    snapshot: ParticleSnapshot, numbers: dict[str, int], time_s: float, coarse_graining: float
) -> CarriedBed:
    """Return the particles of an instant; ``numbers`` are the materials' numbers by name."""
    by_number = sorted(numbers, key=lambda name: numbers[name])
    columns: dict[str, Any] = {name: getattr(snapshot, name) for name in (*PLACED, "grains")}
    return keep_used_materials(
        CarriedBed(tuple(by_number), **columns, time_s=time_s, coarse_graining=coarse_graining, source="")
    )


def grains_of(columns: Mapping[str, Any], shapes: ShapeTable) -> Grains:
    """Return the grains of recorded columns, which have the names of ``GRAINS``."""
    return Grain(**{name: columns[name][:] for name in GRAINS}, shapes=shapes)


def shape_attributes(shapes: ShapeTable) -> dict[str, Any]:
    """Return the attributes by which recorded files know shapes: ``shapes``, their names, and one for each of
    their numbers, such as ``shape_volume`` (k,)."""
    numbers = {f"shape_{name}": values for name, values in vars(shapes).items() if name != "name"}
    return {"shapes": shapes.name.tolist(), **numbers}


def shapes_in(attributes: Mapping[str, Any]) -> ShapeTable:
    """Return the shapes that recorded attributes tell."""
    names = [field.name for field in fields(ShapeTable) if field.name != "name"]
    numbers = {name: np.asarray(attributes[f"shape_{name}"]) for name in names}
    return ShapeTable(name=np.array([str(name) for name in attributes["shapes"]], dtype=str), **numbers)


def keep_used_materials(bed: CarriedBed) -> CarriedBed:
    """Return the bed with the names of those materials only that one of its particles has."""
    used, material = np.unique(bed.grains.material, return_inverse=True)
    grains = replace(bed.grains, material=material)
    return replace(bed, materials=tuple(bed.materials[k] for k in used), grains=grains)


def write(path: Path, bed: CarriedBed) -> None:
    """Write a bed, either completely or not at all.  Raises OSError."""
    import h5py  # It is imported here because checks of cases without a saved bed do not need it.

    with written_whole(path) as aside, h5py.File(aside, "w") as file:
        file.attrs["format_version"] = FORMAT
        file.attrs["materials"] = list(bed.materials)
        file.attrs["time_s"] = bed.time_s
        file.attrs["coarse_graining"] = bed.coarse_graining
        file.attrs.update(shape_attributes(bed.grains.shapes))
        for owner, names in ((bed, PLACED), (bed.grains, GRAINS)):
            for name in names:
                file.create_dataset(name, data=getattr(owner, name)).attrs["unit"] = unit_of(name)


def read(path: Path) -> CarriedBed:
    """Read a bed.  Raises UnreadableBed."""
    try:
        with open_hdf5(path) as file:
            version = file.attrs.get("format_version")
            if version != FORMAT:
                raise UnreadableBed(
                    f"{path}: has format {version}; this flipflow reads {FORMAT}: run the case again"
                )
            motion: dict[str, Any] = {name: np.asarray(file[name][:]) for name in PLACED}
            return CarriedBed(
                materials=tuple(str(name) for name in file.attrs["materials"]),
                **motion,
                grains=grains_of(file, shapes_in(file.attrs)),
                time_s=float(file.attrs["time_s"]),
                coarse_graining=float(file.attrs["coarse_graining"]),
                source=str(path),
            )
    except (OSError, KeyError, ValueError) as error:
        raise UnreadableBed(f"{path}: is not a saved bed ({error})") from None


def read_time_s(path: Path) -> float | None:
    """Return the time of a saved bed; None if the file cannot be read."""
    try:
        with open_hdf5(path) as file:
            return float(file.attrs["time_s"])
    except (OSError, KeyError, ValueError):
        return None
