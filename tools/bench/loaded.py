"""The solvers and large packages that a case loads.

``python -m tools.bench.loaded CASE LEVEL [KEY=VALUE ...]`` prints them; it needs a process of its own.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from orchestrator.coupling.build import build
from orchestrator.coupling.metered import Stopwatch
from orchestrator.coupling.schemes.scheme import initial_state
from orchestrator.ports.clock import Interval
from orchestrator.preflight.judge import load_judged

LARGE = ("dolfinx", "petsc4py", "ufl", "exudyn", "mpi4py", "gmsh", "pyvista", "matplotlib")


def loaded_by(case: Path, level: str, overrides: Sequence[str]) -> frozenset[str]:
    """Return the adapters and large packages that are in memory after a case's first sync interval."""
    words = [sys.executable, "-m", "tools.bench.loaded", str(case), level, *overrides]
    printed = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    return frozenset(printed.splitlines()[-1].split())


def _main(case: str, level: str, *overrides: str) -> None:
    loaded = load_judged(Path(case), level or None, overrides)
    with tempfile.TemporaryDirectory(prefix="flipflow-loaded-") as scratch:
        machine = build(loaded, Path(scratch), None, Stopwatch())
        first = Interval(0, loaded.case.coupling.sync_interval_s)
        machine.scheme.advance(machine.solvers, first, initial_state(machine.solvers))
        machine.close()
    adapters = {name.removeprefix("adapters.") for name in sys.modules if name[:9] == "adapters."}
    print(*sorted(adapters | (set(LARGE) & sys.modules.keys())))


if __name__ == "__main__":
    _main(*sys.argv[1:])
