"""The cache of compiled forms: shared by processes that start together, and none the worse for one
that is killed while it compiles."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

pytestmark = [pytest.mark.solver, pytest.mark.process, pytest.mark.slow]
ROOT = Path(__file__).parents[2]
TOGETHER_S = 90  # FFCx's own waiting would take 120
# the integral of x^2 y over the unit square, 1/6, and a form whose code takes some seconds
PROGRAM = """
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI
from adapters.panel.finite_element.compiled import form, function_space
square = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
space = function_space(square, "Lagrange", 3, 2)
u, v, w = fem.Function(space), ufl.TestFunction(space), ufl.TrialFunction(space)
gradient = ufl.Identity(2) + ufl.grad(u)
energy = ufl.exp(ufl.inner(gradient, gradient)) * ufl.det(gradient)
form(ufl.derivative(ufl.derivative(energy * ufl.dx, u, v), u, w))
x = ufl.SpatialCoordinate(square)
print(fem.assemble_scalar(form(x[0] ** 2 * x[1] * ufl.dx)))
"""


def started(cache: Path, program: str = PROGRAM) -> subprocess.Popen[str]:
    """The program, in a process group of its own, which the compiler belongs to."""
    own = {"XDG_CACHE_HOME": str(cache), "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(
        [sys.executable, "-c", program],
        cwd=ROOT,
        env=os.environ | own,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        start_new_session=True,
    )


def compiled(program: subprocess.Popen[str]) -> None:
    output, errors = program.communicate(timeout=TOGETHER_S)
    assert program.returncode == 0, errors
    assert float(output) == pytest.approx(1 / 6, rel=1e-12)


def files(cache: Path, pattern: str) -> list[Path]:
    return sorted((cache / "fenics").glob(f"*/{pattern}"))


def all_ready(cache: Path) -> bool:
    """Return whether at least two forms, and all that is begun, are ready; UFL may name one form differently
    in two processes."""
    sources, ready = files(cache, "*.c"), files(cache, "*.c.cached")
    forms = files(cache, "libffcx_forms_*.c")
    return len(forms) >= 2 and [f.stem for f in ready] == [f.name for f in sources]


def wait_for(cache: Path, pattern: str) -> None:
    end = time.monotonic() + TOGETHER_S
    while not files(cache, pattern):
        assert time.monotonic() < end, f"no {pattern}"
        time.sleep(0.01)


def test_two_processes_compile_into_a_cold_cache(tmp_path: Path) -> None:
    for program in [started(tmp_path), started(tmp_path)]:
        compiled(program)
    assert all_ready(tmp_path)


@pytest.mark.parametrize("moment", ["libffcx_forms_*.c", "libffcx_forms_*.o"])
def test_one_that_is_killed_while_it_compiles(tmp_path: Path, moment: str) -> None:
    """The process is killed when its C file appears, empty, and when the compiler has written its object."""
    killed = started(tmp_path)
    wait_for(tmp_path, moment)
    os.killpg(killed.pid, signal.SIGKILL)
    killed.communicate()
    assert not all_ready(tmp_path)
    compiled(started(tmp_path))
    assert all_ready(tmp_path)


def test_a_cache_that_cannot_be_written(tmp_path: Path) -> None:
    (tmp_path / "fenics").write_text("in the way")
    program = started(tmp_path)
    errors = program.communicate(timeout=TOGETHER_S)[1]
    assert "SolverFailed:" in errors.splitlines()[-1]
    assert str(tmp_path / "fenics") in errors.splitlines()[-1]


@contextmanager
def stopped_while_it_compiles(cache: Path) -> Iterator[subprocess.Popen[str]]:
    """A process that holds the lock and does nothing more, like one at a shell's Ctrl-Z."""
    stopped = started(cache)
    wait_for(cache, "libffcx_forms_*.c")
    os.killpg(stopped.pid, signal.SIGSTOP)
    try:
        yield stopped
    finally:
        os.killpg(stopped.pid, signal.SIGKILL)
        stopped.communicate()


def test_what_is_in_the_cache_waits_for_nobody(tmp_path: Path) -> None:
    """The elements and one form are there; another process is stopped over the other form."""
    in_cache = PROGRAM.replace("form(ufl.derivative", "(ufl.derivative")
    compiled(started(tmp_path, in_cache))
    known = set(files(tmp_path, "libffcx_forms_*.c"))
    stopped = started(tmp_path)
    while set(files(tmp_path, "libffcx_forms_*.c")) == known:
        time.sleep(0.01)
    os.killpg(stopped.pid, signal.SIGSTOP)
    try:
        begun_s = time.monotonic()
        program = started(tmp_path, in_cache)
        output, errors = program.communicate(timeout=TOGETHER_S)
        assert float(output) == pytest.approx(1 / 6, rel=1e-12)
        assert "waiting" not in errors
        assert time.monotonic() - begun_s < 30
    finally:
        os.killpg(stopped.pid, signal.SIGKILL)
        stopped.communicate()


def test_who_waits_for_a_stopped_process_says_so_and_gives_up(tmp_path: Path) -> None:
    """The second form is not waited for again: the same process still holds the lock."""
    patience = (
        "import adapters.panel.finite_element.compiled as compiled\n"
        "compiled.SAID_AFTER_S, compiled.GIVEN_UP_AFTER_S = 1.0, 2.0\n"
    )
    with stopped_while_it_compiles(tmp_path) as stopped:
        errors = started(tmp_path, patience + PROGRAM).communicate(timeout=TOGETHER_S)[1]
        assert f"waiting for process {stopped.pid} on " in errors
        assert f"SolverFailed: a panel's form is not compiled: process {stopped.pid} on" in errors
        assert "for more than 2 s.  Is it stopped (kill -CONT" in errors
        assert str(tmp_path) in errors.splitlines()[-1]


def test_who_waits_goes_on_with_the_process_that_it_waits_for(tmp_path: Path) -> None:
    with stopped_while_it_compiles(tmp_path) as stopped:
        waiting = started(tmp_path)
        time.sleep(5)
        os.killpg(stopped.pid, signal.SIGCONT)
        compiled(waiting)
        # the other process may still compile the form that UFL names differently there
        end = time.monotonic() + TOGETHER_S
        while not all_ready(tmp_path):
            assert time.monotonic() < end
            time.sleep(0.1)
