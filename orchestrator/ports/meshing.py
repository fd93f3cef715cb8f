"""A session of gmsh that makes one mesh."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from itertools import pairwise
from threading import Lock
from typing import Any

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.failures import SolverMissing

# gmsh keeps one model in a process, and the cases of a study are checked on several threads.
ONE_MODEL = Lock()


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """Yield the module ``gmsh``, quiet and on one thread; other threads wait until the session ends.

    Raises SolverMissing where gmsh is not installed.
    """
    try:
        import gmsh
    except (ImportError, OSError) as missing:
        raise SolverMissing(
            f"panels with apertures need gmsh, which docker/setup.sh installs: {missing}"
        ) from missing
    with ONE_MODEL:
        gmsh.initialize(readConfigFiles=False, interruptible=False)
        try:
            gmsh.option.setNumber("General.Terminal", 0)
            gmsh.option.setNumber("General.NumThreads", 1)
            yield gmsh
        finally:
            gmsh.finalize()


def closed_line(model: Any, outline_m: Array) -> int:
    """Return the number of the loop of straight lines through points (n, 2) in a geometry of gmsh's."""
    points = [model.addPoint(x, y, 0.0) for x, y in outline_m]
    lines = [model.addLine(start, end) for start, end in pairwise([*points, points[0]])]
    return int(model.addCurveLoop(lines))


def made_triangles(gmsh: Any) -> tuple[Array, Indices]:
    """Return the points (n, 2) of the mesh that gmsh has made, and its triangles (m, 3)."""
    tags, places, _ = gmsh.model.mesh.getNodes()
    _, _, corners = gmsh.model.mesh.getElements(2)
    order = np.argsort(tags)
    triangles = np.searchsorted(tags[order], corners[0].reshape(-1, 3))
    return places.reshape(-1, 3)[order, :2], triangles.astype(np.int64)
