"""A session of gmsh that makes one mesh."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Any

from orchestrator.ports.failures import SolverMissing

ONE_MODEL = (
    Lock()
)  # gmsh keeps one model in a process, and the cases of a study are checked on several threads.


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
