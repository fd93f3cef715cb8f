"""A program that reads one file of a surface by a library, and writes its triangles (m, 3, 3) as .npy.

    python -m orchestrator.case.deck.library_reader FILE ENDING OUT TOLERANCE_M

Libraries crash, hang, or take all memory for damaged files.  So they run in this process, with limits.
STEP and IGES, which say their unit, become metres; all other files keep their numbers.
"""

from __future__ import annotations

import re
import resource
import sys
from pathlib import Path

import numpy as np

from orchestrator.ports import Array, Indices

MEMORY_BYTES = 8_000_000_000
CPU_S = 120
ANGLE = 6.3  # rad; so large that the distance alone decides how many triangles a curve gets
CORNERS = {"triangle": 3, "triangle6": 3, "triangle7": 3, "quad": 4, "quad8": 4, "quad9": 4}
IGES_UNITS = {"1", "2", "4", "6", "10"}  # in, mm, ft, m, cm
HOLLERITH = re.compile(r"(\d+)H")


class Refused(Exception):
    """An error whose message is for the user."""


def main() -> None:
    """Read the file that the command line names."""
    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    name, ending, out, tolerance_m = sys.argv[1:]
    try:
        if ending in (".obj", ".ply", ".vtk"):
            corners = _by_meshio(name, ending)
        else:
            corners = _by_gmsh(Path(name), ending, float(tolerance_m))
        np.save(out, corners)
    except Refused as why:
        print(f"refused: {why}", file=sys.stderr)
        raise SystemExit(2) from None


def _by_meshio(name: str, ending: str) -> Array:
    """Return the triangles of polygons in a file of meshes."""
    import meshio

    mesh = meshio.read(name, file_format=ending[1:])
    points = np.asarray(mesh.points, dtype=float)
    if points.ndim != 2 or points.shape[1] != 3:
        raise Refused("has points that are not of three coordinates")
    parts: list[Array] = [np.empty((0, 3, 3))]
    for block in mesh.cells:
        if block.type in ("vertex", "line", "line3"):
            continue
        if block.type not in CORNERS and not block.type.startswith("polygon"):
            raise Refused(f"has cells of the kind {block.type}: export its surface alone")
        rows = np.asarray(block.data, dtype=np.int64)
        rows = rows[:, : CORNERS.get(block.type, rows.shape[1])]
        if len(rows) and (rows.min() < 0 or rows.max() >= len(points)):
            raise Refused("has faces with points that it lacks: export it again, with absolute numbers")
        parts.append(_fan(points[rows]))
    return np.concatenate(parts)


def _fan(polygons: Array) -> Array:
    """Return the triangles (m, 3, 3) of convex polygons (n, k, 3).  Raises Refused for others."""
    triangles = np.stack([polygons[:, [0, k, k + 1]] for k in range(1, polygons.shape[1] - 1)], axis=1)
    normal = np.cross(triangles[:, :, 1] - triangles[:, :, 0], triangles[:, :, 2] - triangles[:, :, 0])
    along = np.einsum("nki,ni->nk", normal, normal.sum(axis=1))
    if polygons.shape[1] > 3 and (along < -1e-9 * np.abs(along).max(initial=0.0)).any():
        raise Refused("has polygons with a dent: export it in triangles")
    return np.asarray(triangles.reshape(-1, 3, 3))


def _by_gmsh(file: Path, ending: str, tolerance_m: float) -> Array:
    """Return the triangles of a mesh of gmsh's, or those that OpenCASCADE puts on the faces of CAD."""
    import gmsh

    if ending in (".step", ".stp"):
        _ask_for_unit_of_step(file)
    elif ending in (".iges", ".igs"):
        _ask_for_unit_of_iges(file)
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("General.NumThreads", 1)
    per_m = 1000.0 if ending in (".iges", ".igs") else 1.0  # IGES comes in mm, whatever is asked for
    if ending in (".step", ".stp"):
        gmsh.option.setString("Geometry.OCCTargetUnit", "M")
    gmsh.option.setNumber("Mesh.StlLinearDeflection", tolerance_m * per_m)
    gmsh.option.setNumber("Mesh.StlLinearDeflectionRelative", 0)
    gmsh.option.setNumber("Mesh.StlAngularDeflection", ANGLE)
    gmsh.merge(str(file))
    if ending != ".msh":
        if not gmsh.model.getEntities(2):
            raise Refused("has no faces: export the body or its faces, no curves alone")
        gmsh.model.mesh.importStl()
    tags, places, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    places = places.reshape(-1, 3)[order] / per_m
    kinds, _, nodes = gmsh.model.mesh.getElements(2)
    parts: list[Array] = [np.empty((0, 3, 3))]
    for kind, row in zip(kinds, nodes, strict=True):
        _, _, _, count, _, corners = gmsh.model.mesh.getElementProperties(kind)
        rows: Indices = np.searchsorted(tags[order], row.reshape(-1, count)[:, :corners])
        parts.append(_fan(places[rows]))
    if len(parts) == 1 and ending == ".msh":
        raise Refused("has no triangles or quadrangles: mesh its surface (gmsh -2)")
    return np.concatenate(parts)


def _ask_for_unit_of_step(file: Path) -> None:
    """Refuse a STEP file that does not say its unit of length."""
    text = file.read_text(errors="replace")
    if not text.lstrip("\ufeff \r\n").startswith("ISO-10303-21"):
        raise Refused("is not a STEP file: it does not begin with ISO-10303-21")
    if "END-ISO-10303-21" not in text[-400:]:
        raise Refused("is cut off: it does not end with END-ISO-10303-21")
    if not re.search(r"[^_A-Z]LENGTH_UNIT\s*\(", text):
        raise Refused("does not say its unit of length: export it with one")


def _ask_for_unit_of_iges(file: Path) -> None:
    """Refuse an IGES file that does not say its unit, the 14th value of its global section."""
    lines = file.read_text(errors="replace").splitlines()
    if not lines or not any(line[72:73] == "T" for line in lines[-2:]):
        raise Refused("is cut off, or no IGES file: its last line is not of section T")
    text = "".join(line[:72].ljust(72) for line in lines if line[72:73] == "G")
    values: list[str] = []
    at, comma = 0, text[2] if text[:2] == "1H" else ","
    while at < len(text) and len(values) < 15:
        held = HOLLERITH.match(text, at)
        end = held.end() + int(held[1]) if held else at
        end = min(place for place in (text.find(comma, end), len(text)) if place >= 0)
        values.append(text[held.end() : end] if held else text[at:end].strip())
        at = end + 1
    if len(values) < 14 or values[13] not in IGES_UNITS:
        raise Refused("does not say its unit of length: export it with one")


if __name__ == "__main__":
    main()
