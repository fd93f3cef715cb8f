"""Files of rigid surfaces in any format: found, read, brought to metres and deck axes, and healed."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from orchestrator.case.deck import stl
from orchestrator.case.deck.stl import Facets, UnreadableSurface, each_corner_once, find_file
from orchestrator.case.tables.screen import Surface

if TYPE_CHECKING:
    from orchestrator.case.deck.heal import Healed

WITH_UNIT = (".step", ".stp", ".iges", ".igs")
"""Endings of files that say their unit."""
ENDINGS = (".stl", ".obj", ".ply", ".vtk", ".msh", *WITH_UNIT)
"""Endings of all files that a surface may name as ``file``."""
UNITS_M = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
MOST_TRIANGLES = 4_000_000
TOLERANCE_M = 1e-4  # distance between a curved face of CAD and its triangles
LONGEST_S = 120.0  # time that a library may take for a file


def read_surface(surface: Surface, folder: Path) -> Healed:
    """Return the healed surface of a file that a table names, in m and deck axes.

    Raises UnreadableSurface, whose message has the cause and a remedy.
    """
    name = surface.file if surface.file is not None else surface.stl
    assert name is not None, "plates have no file"
    file = find_file(folder, name)
    unit = surface.unit or ("m" if surface.stl is not None else None)
    about = file.stat()
    return _read(
        file.resolve(),
        (about.st_mtime_ns, about.st_size),
        ".stl" if surface.stl is not None else file.suffix.lower(),
        unit,
        surface.scale or 1.0,
        surface.rotation_deg or (0.0, 0.0, 0.0),
        surface.move_m or (0.0, 0.0, 0.0),
        surface.tolerance_m or TOLERANCE_M,
    )


@lru_cache(maxsize=16)
def _read(
    file: Path,
    _state: tuple[int, int],
    ending: str,
    unit: str | None,
    scale: float,
    rotation_deg: tuple[float, float, float],
    move_m: tuple[float, float, float],
    tolerance_m: float,
) -> Healed:
    """Read a file once, as long as its ``_state``, the time and size of its last change, stays."""
    if ending not in ENDINGS:
        raise UnreadableSurface(f"is of no known format: export it as one of {', '.join(ENDINGS)}")
    if ending in WITH_UNIT and unit is not None:
        raise UnreadableSurface("says its unit itself: leave out unit, or give scale")
    if ending not in WITH_UNIT and unit is None:
        raise UnreadableSurface(f"does not say its unit: give unit, one of {', '.join(UNITS_M)}")
    factor = scale * (UNITS_M[unit] if unit else 1.0)
    facets = stl.read_file(file) if ending == ".stl" else _by_library(file, ending, tolerance_m / scale)
    if len(facets.triangles) > MOST_TRIANGLES:
        what = f"has {len(facets.triangles)} triangles, more than {MOST_TRIANGLES}"
        raise UnreadableSurface(f"{what}: give a larger tolerance_m, or export it coarser")
    # these imports take long, and few commands read a surface
    from scipy.spatial.transform import Rotation

    from orchestrator.case.deck.heal import heal

    turned = Rotation.from_euler("xyz", rotation_deg, degrees=True)
    position_m, normal = facets.position_m * factor, facets.normal
    if any(rotation_deg):
        position_m, normal = turned.apply(position_m), turned.apply(normal)
    return heal(Facets(position_m + np.array(move_m), facets.triangles, normal))


def _by_library(file: Path, ending: str, tolerance_m: float) -> Facets:
    """Return what a library reads, in a process of its own, which a damaged file may break.

    Raises UnreadableSurface.
    """
    with tempfile.TemporaryDirectory() as place:
        out = Path(place) / "triangles.npy"
        words = [str(file), ending, str(out), repr(tolerance_m)]
        command = [sys.executable, "-m", "orchestrator.case.deck.library_reader", *words]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, errors="replace", timeout=LONGEST_S, check=False
            )
        except subprocess.TimeoutExpired:
            what = f"took longer than {LONGEST_S:g} s to read"
            raise UnreadableSurface(f"{what}: give a larger tolerance_m, or export it again") from None
        if done.returncode or not out.is_file():
            said = done.stderr.strip().splitlines()[-1:]
            why = said[0].removeprefix("refused: ") if said and said[0].startswith("refused: ") else ""
            raise UnreadableSurface(why or f"is damaged, or no {ending[1:].upper()} file: export it again")
        corners = np.load(out)
    if len(corners) == 0:
        raise UnreadableSurface("has no triangles")
    if not np.isfinite(corners).all():
        raise UnreadableSurface("has coordinates that are not numbers")
    position, triangles = each_corner_once(corners.reshape(-1, 3))
    return Facets(position, triangles, np.zeros((len(triangles), 3)))
