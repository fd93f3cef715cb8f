"""Opening a machine: solvers that are open are closed when a later one fails."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from orchestrator.case import solvers
from orchestrator.coupling.build import build
from orchestrator.coupling.metered import Stopwatch
from orchestrator.ports.plans import SolverFailed
from tests.cases import load_case
from tests.coupled.screen import CASE

CHEAP = ("panel.solver=rigid", "frames.solver=two-mass", "particles.solver=spheres")


def test_a_solver_that_fails_closes_those_before(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, closed = solvers.open_solver, []

    def opened(port: str, solver: str, plan: Any) -> Any:
        if port == "frames":
            raise SolverFailed("no frames today")
        made = real(port, solver, plan)
        close = made.close
        monkeypatch.setattr(made, "close", lambda: (closed.append(port), close()))
        return made

    monkeypatch.setattr(solvers, "open_solver", opened)
    loaded = load_case(tmp_path, CASE, CHEAP)
    with pytest.raises(SolverFailed, match="no frames"):
        build(loaded, loaded.folder, None, Stopwatch())
    assert closed[0] == "particles"  # the last one opened
    assert closed.count("panel") == 2
