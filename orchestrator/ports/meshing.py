"""A session of gmsh that makes one mesh."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from orchestrator.ports.failures import SolverMissing


@contextmanager
def gmsh_session() -> Iterator[Any]:
    """Yield the module ``gmsh``, quiet and on one thread; raise SolverMissing where it is not installed."""
    try:
        import gmsh
    except (ImportError, OSError) as missing:
        raise SolverMissing(
            f"panels with apertures need gmsh (pip install gmsh; Debian: libglu1-mesa): {missing}"
        ) from missing
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("General.NumThreads", 1)
        yield gmsh
    finally:
        gmsh.finalize()
