"""Exit code 3: a solver is not installed; and what is not called for is never imported."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.runs.outside import QUICK, flipflow, run_words, said_plainly

BRIDGE, DOLFINX, EXUDYN = "adapters.particles._liggghts", "dolfinx", "exudyn"
SOLVERS = (BRIDGE, DOLFINX, EXUDYN, "petsc4py", "ufl", "basix", "ffcx", "mpi4py")
PICTURES = ("matplotlib", "PIL", "jinja2", "gmsh")
FEW = '["frame-dynamics", "frame-motion", "panel-motion", "sliding-friction"]'
KERNEL = "adapters.panel._kernel"


def forbidden(*packages: str) -> str:
    """Return code that makes an import of one of these packages end the program."""
    return f"""
import os, sys

class Forbidden:
    def find_spec(self, name, path=None, target=None):
        if any((name + ".").startswith(one + ".") for one in {packages}):
            print("imported:", name, file=sys.stderr, flush=True)
            os._exit(99)

sys.meta_path.insert(0, Forbidden())
"""


def without(*packages: str) -> str:
    return f"import sys\nfor name in {packages}: sys.modules[name] = None"


@pytest.mark.parametrize(
    ("package", "key", "wanted"),
    [
        (EXUDYN, "frames.solver=exudyn", "need Exudyn, which docker/setup.sh installs"),
        (DOLFINX, "panel.solver=sheet", "python3-dolfinx"),
        (DOLFINX, "panel.solver=solid", "python3-dolfinx"),
        (KERNEL, "panel.solver=sheet", "docker/setup.sh"),
        (KERNEL, "panel.solver=strip", "docker/setup.sh"),
        (BRIDGE, "particles.solver=liggghts", "by LIGGGHTS need their compiled part, which docker/setup.sh"),
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
    assert "warning: the exudyn frames need Exudyn, which docker/setup.sh installs" in done.stdout


def test_who_imports_what_is_forbidden_is_caught(tmp_path: Path) -> None:
    sets = [*QUICK, "frames.solver=exudyn"]
    done = flipflow(*run_words("quickstart", tmp_path / "run", sets), before=forbidden(EXUDYN))
    assert done.returncode == 99
    assert "imported: exudyn" in done.stderr


@pytest.mark.parametrize(
    ("case", "sets"),
    [
        ("empty-machine", []),
        ("panel-cycle", []),
        ("panel-cycle", ["panel.solver=rigid"]),
        ("ball-on-panel", []),
        ("bushing-hysteresis", []),
        ("quickstart", ["panel.solver=rigid"]),
        ("quickstart", ["effects=auto"]),
        ("empty-machine", ['effects=["frame-dynamics", "frame-motion"]']),
        ("ffs0827-empty", ["panel.solver=rigid", "frames.solver=two-mass"]),
    ],
)
def test_a_run_imports_only_what_it_calls_for(tmp_path: Path, case: str, sets: list[str]) -> None:
    """pyvista is for particles, which must not start inside walls, and for pictures."""
    particles = case in ("ball-on-panel", "quickstart")
    allowed = {BRIDGE, "mpi4py"} if particles else set()
    blocked = [*(set(SOLVERS) - allowed), *PICTURES, *([] if particles else ["pyvista", "vtkmodules"])]
    sets = [*QUICK, "duration_s=0.002", *sets]
    done = flipflow(*run_words(case, tmp_path / "run", sets), before=forbidden(*blocked))
    assert done.returncode == 0, done.stderr


@pytest.mark.solver
@pytest.mark.parametrize(
    ("case", "solvers", "blocked"),
    [
        ("empty-machine", ["frames.solver=exudyn"], (BRIDGE, DOLFINX, "petsc4py", "ufl")),
        ("panel-cycle", ["panel.solver=sheet", "panel.cells=[8, 3]"], (BRIDGE, EXUDYN)),
        ("ball-on-panel", ["particles.solver=liggghts"], (DOLFINX, EXUDYN, "petsc4py", "ufl")),
        (
            "quickstart",
            ["particles.solver=liggghts", "frames.solver=exudyn", "panel.solver=sheet", f"effects={FEW}"],
            (DOLFINX, EXUDYN, "petsc4py", "ufl", "gmsh"),
        ),
    ],
)
def test_each_solver_runs_without_the_others(
    tmp_path: Path, case: str, solvers: list[str], blocked: tuple[str, ...]
) -> None:
    """The ``effects`` of the last case leave out what calls for two of them."""
    sets = [*QUICK, "duration_s=0.002", *solvers]
    done = flipflow(*run_words(case, tmp_path / "run", sets), before=forbidden(*blocked))
    assert done.returncode == 0, done.stderr
