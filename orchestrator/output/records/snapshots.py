"""Snapshots of the surface and the particles, which ParaView opens as an animation.

``surface.pvd`` and ``particles.pvd`` list one VTU file for each output time; rigid surfaces stand in one
file, as they are drawn.  Where particles are made of several spheres, ``spheres.pvd`` has each of these.
``paraview_state.py`` opens them all in ParaView, in colours.
"""

from __future__ import annotations

import errno
import os
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import numpy.typing as npt

from orchestrator.case.file.whole import write_text
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot, Saved
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.grains import placed_spheres

HEAD = '<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n<Collection>\n'
TAIL = "</Collection>\n</VTKFile>\n"
STATE = "paraview_state.py"


class Series:
    """A ParaView series: ``<name>.pvd`` beside the folder ``<name>/`` with a file for each time.

    With ``moves`` False there are no such files.  Each row lists the file ``beside``, too, if there is one.
    """

    def __init__(self, folder: Path, name: str, beside: str = "", moves: bool = True) -> None:
        self._folder, self._name, self._list = folder, name, folder / f"{name}.pvd"
        self._beside, self._moves = beside, moves
        self._time_s: list[float] = []
        (folder / name).mkdir(exist_ok=True)

    def add(self, time_s: float, mesh: meshio.Mesh) -> None:
        """Write the snapshot of a time, and its row of the list."""
        number = len(self._time_s)
        file = self._folder / self._file(number)
        try:
            if self._moves:
                write_mesh(file, mesh)
            self._time_s.append(time_s)
            if number and self._list.exists():
                self._extend_list(self._row(number))
            else:
                self._write_list()
        except OSError:  # half a file would not open
            file.unlink(missing_ok=True)
            raise

    def save(self) -> Saved:
        """Return the times so far for a checkpoint."""
        return {"time_s": np.array(self._time_s)}

    def restore(self, saved: Saved) -> None:
        """Go on after the saved times, and remove the files of later times."""
        self._time_s = saved["time_s"].tolist()
        current = {self._folder / self._file(number) for number in range(len(self._time_s))}
        for file in (self._folder / self._name).glob("*.vtu"):
            if file not in current:
                file.unlink()
        self._write_list()

    def _file(self, number: int) -> str:
        return f"{self._name}/{self._name}_{number:05d}.vtu"

    def _row(self, number: int) -> str:
        files = [*([self._file(number)] if self._moves else []), *([self._beside] if self._beside else [])]
        time = f'timestep="{self._time_s[number]!r}"'
        rows = (f'<DataSet {time} part="{n}" file="{escape(file)}"/>\n' for n, file in enumerate(files))
        return "".join(rows)

    def _write_list(self) -> None:
        rows = "".join(map(self._row, range(len(self._time_s))))
        write_text(self._list, HEAD + rows + TAIL)

    def _extend_list(self, row: str) -> None:
        """Write a row before the list's end, so that ParaView can open the series of a run that goes on.

        To write the whole list aside takes a hundred times as long, since a file that replaces another waits
        for the disk.
        """
        with self._list.open("r+b", buffering=0) as opened:
            end = opened.seek(-len(TAIL), os.SEEK_END)
            try:
                if opened.write((row + TAIL).encode()) < len(row + TAIL):
                    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(self._list))
            except OSError:
                opened.truncate(end)
                opened.seek(end)
                opened.write(TAIL.encode())
                raise


def write_state(folder: Path) -> None:
    """Write the script by which ParaView shows what a run's folder has: panels, walls and particles."""
    write_text(folder / STATE, Path(__file__).with_name("paraview_state.txt").read_text(encoding="utf-8"))


def write_mesh(file: Path, mesh: meshio.Mesh) -> None:
    """Write a mesh as VTU, with real numbers of 4 bytes."""
    meshio.write(file, in_single_precision(mesh), compression=None)


def in_single_precision(mesh: meshio.Mesh) -> meshio.Mesh:
    """Return the mesh with real numbers of 4 bytes, which are as small as compressed ones of 8 bytes.

    Compressing them would take ten to twenty times as long as writing them.
    """

    def single(values: Array) -> npt.NDArray[Any]:
        return values.astype(np.float32) if values.dtype == np.float64 else values

    point_data = {name: single(values) for name, values in mesh.point_data.items()}
    cell_data = {name: [single(part) for part in parts] for name, parts in mesh.cell_data.items()}
    return meshio.Mesh(single(mesh.points), mesh.cells, point_data, cell_data)


def surface_mesh(
    surface: Motion,
    triangles: Indices,
    panel: Indices,
    at_points: Mapping[str, Array],
    of_triangles: Mapping[str, Array],
) -> meshio.Mesh:
    """Return the mesh of the triangles (n, 3), with the number of the ``panel`` (n,) in each cell.

    Its points have their velocity and the fields ``at_points``, by name; its cells have the fields
    ``of_triangles``.  Points without a triangle (probes) are left out: they would enlarge a viewer's view.
    """
    points, corners = np.unique(triangles, return_inverse=True)
    return meshio.Mesh(
        surface.position_m[points],
        [("triangle", corners.reshape(triangles.shape))],
        point_data={
            "velocity_m_per_s": surface.velocity_m_per_s[points],
            **{name: values[points] for name, values in at_points.items()},
        },
        cell_data={"panel": [panel], **{name: [values] for name, values in of_triangles.items()}},
    )


def walls_mesh(surface: TriangleSurface, of_vertices: Mapping[str, Array]) -> meshio.Mesh:
    """Return the mesh of the rigid surfaces as they are drawn, with fields ``of_vertices`` by name."""
    assert surface.panel is not None, "a machine's surface knows its panels"
    triangles = surface.triangles[surface.panel < 0]
    vertices, corners = np.unique(triangles, return_inverse=True)
    return meshio.Mesh(
        surface.vertices_m[vertices],
        [("triangle", corners.reshape(triangles.shape))],
        point_data={name: values[vertices] for name, values in of_vertices.items()},
    )


def particle_mesh(particles: ParticleSnapshot) -> meshio.Mesh:
    """Return a mesh with a vertex for each particle, with its id, size, motion, density, material, shape and
    orientation, a quaternion w, x, y, z.

    It has the force on it, and the number of other particles that it touches, where the solver tells them.
    """
    count = len(particles.id)
    told = {"force_N": particles.force_N, "contacts": particles.contacts}
    return meshio.Mesh(
        particles.position_m.reshape(count, 3),
        [("vertex", np.arange(count).reshape(count, 1))],
        point_data={
            "id": particles.id,
            "sieve_size_m": particles.grains.sieve_size_m,
            "equivalent_diameter_m": particles.grains.equivalent_diameter_m,
            "speed_m_per_s": np.linalg.norm(particles.velocity_m_per_s, axis=1),
            "velocity_m_per_s": particles.velocity_m_per_s,
            "spin_rad_per_s": particles.spin_rad_per_s,
            "density_kg_per_m3": particles.grains.density_kg_per_m3,
            "material": particles.grains.material,
            "shape": particles.grains.shape,
            "orientation": particles.orientation,
            **{name: values for name, values in told.items() if values is not None},
        },
    )


def sphere_mesh(particles: ParticleSnapshot) -> meshio.Mesh:
    """Return a mesh with a vertex for each sphere of which particles are made, with its diameter and the
    particle's id, speed, material and shape."""
    of, center_m, radius_m = placed_spheres(particles.grains, particles.position_m, particles.orientation)
    count = len(of)
    speed_m_per_s = np.linalg.norm(particles.velocity_m_per_s, axis=1)
    return meshio.Mesh(
        center_m.reshape(count, 3),
        [("vertex", np.arange(count).reshape(count, 1))],
        point_data={
            "id": particles.id[of],
            "diameter_m": 2.0 * radius_m,
            "speed_m_per_s": speed_m_per_s[of],
            "material": particles.grains.material[of],
            "shape": particles.grains.shape[of],
        },
    )
