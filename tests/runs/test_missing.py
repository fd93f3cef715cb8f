"""Exit code 3: a solver is not installed; and what is not called for is never imported."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.runs.outside import QUICK, flipflow, run_words, said_plainly

BRIDGE, DOLFINX, EXUDYN = "adapters.particles._liggghts", "dolfinx", "exudyn"
KERNEL = "adapters.panel._kernel"


def without(*packages: str) -> str:
    return f"import sys\nfor name in {packages}: sys.modules[name] = None"


@pytest.mark.parametrize(
    ("package", "key", "wanted"),
    [
        (EXUDYN, "frames.solver=exudyn", "pip install exudyn==1.13.6"),
        (DOLFINX, "panel.solver=sheet", "python3-dolfinx"),
        (DOLFINX, "panel.solver=solid", "python3-dolfinx"),
        (KERNEL, "panel.solver=sheet", "docker/setup.sh"),
        (BRIDGE, "particles.solver=liggghts", "libliggghts-dev"),
    ],
)
def test_what_to_install_is_said_and_no_folder_is_left(
    tmp_path: Path, package: str, key: str, wanted: str
) -> None:
    sets = [*QUICK, key]
    done = flipflow(*run_words("quickstart", tmp_path / "run", sets), before=without(package))
    assert done.returncode == 3, done.stderr
    said_plainly(done)
    assert wanted in done.stderr.splitlines()[-1]
    assert list(tmp_path.iterdir()) == []


def test_check_warns_of_a_missing_solver() -> None:
    done = flipflow("check", "cases/quickstart", "--level", "default", before=without(EXUDYN))
    assert done.returncode == 0, done.stderr
    assert "warning: the exudyn frames need: pip install exudyn==1.13.6" in done.stdout


@pytest.mark.parametrize(
    ("case", "sets"),
    [
        ("empty-machine", []),
        ("panel-cycle", []),
        ("panel-cycle", ["panel.solver=rigid"]),
        ("ball-on-panel", []),
        ("quickstart", ["panel.solver=rigid"]),
    ],
)
def test_a_run_imports_only_what_it_calls_for(tmp_path: Path, case: str, sets: list[str]) -> None:
    blocked = without(BRIDGE, DOLFINX, KERNEL, EXUDYN, "petsc4py", "mpi4py")
    done = flipflow(
        *run_words(case, tmp_path / "run", [*QUICK, "duration_s=0.002", *sets]), before=blocked
    )
    assert done.returncode == 0, done.stderr


@pytest.mark.solver
@pytest.mark.parametrize(
    ("case", "solvers", "blocked"),
    [
        ("empty-machine", ["frames.solver=exudyn"], (BRIDGE, DOLFINX)),
        ("panel-cycle", ["panel.solver=sheet", "panel.cells=[8, 3]"], (BRIDGE, EXUDYN)),
        ("ball-on-panel", ["particles.solver=liggghts"], (DOLFINX, EXUDYN)),
    ],
)
def test_each_solver_runs_without_the_others(
    tmp_path: Path, case: str, solvers: list[str], blocked: tuple[str, ...]
) -> None:
    sets = [*QUICK, "duration_s=0.002", *solvers]
    done = flipflow(*run_words(case, tmp_path / "run", sets), before=without(*blocked))
    assert done.returncode == 0, done.stderr
