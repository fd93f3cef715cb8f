"""Forms and expressions compiled for this processor.

Optimised code halves the time of an assembly.  It must not
run on another kind of processor, so each kind has a cache folder of its own.

The cache is shared by all processes of a home.  What is in it is loaded without asking anybody.
FFCx marks what is being compiled by its C file alone: a process that is killed meanwhile would
leave a mark on which all later ones wait in vain.  So one process at a time compiles, under a lock
that ends with it, and what it finds half made is removed.  Who has to wait for another process says
so, and gives up when that one takes longer than any form does: it may have been stopped.
"""

from __future__ import annotations

import fcntl
import hashlib
import logging
import os
import platform
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache, partial
from pathlib import Path
from typing import IO, Any

import dolfinx.fem.petsc as fem_petsc
import ufl
from cffi import VerificationError
from dolfinx import fem, mesh
from ffcx.codegeneration import jit
from mpi4py import MPI
from scipy.sparse import csr_matrix

from adapters.panel.finite_element import dolfinx_versions
from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import SolverFailed

COMPILE_TIMEOUT_S = 120  # for others to compile, on a file system without locks
SAID_AFTER_S = 3.0  # of waiting
GIVEN_UP_AFTER_S = 180.0  # that one process has compiled one form: of 152 the longest took 6 s

_given_up: set[str] = set()  # holders of the lock that this process has waited for in vain


def _processor() -> str:
    """Return a checksum of the processor's model and instruction sets, on which ``-march=native`` depends."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = [platform.processor()]
    kept = {line for line in lines if line.startswith(("model name", "flags", "Features"))}
    return hashlib.sha256("\n".join(sorted(kept)).encode()).hexdigest()[:12]


@cache
def _options() -> dict[str, Any]:
    home = Path(os.getenv("XDG_CACHE_HOME") or Path.home() / ".cache")
    return {
        "cache_dir": home / "fenics" / f"{platform.machine()}-{_processor()}",
        "cffi_extra_compile_args": ["-O3", "-march=native", "-ffast-math", "-g0"],
        "cffi_libraries": ["m"],
        "cffi_debug": False,
        "cffi_verbose": False,
        "timeout": COMPILE_TIMEOUT_S,
    }


@contextmanager
def _compiling() -> Iterator[None]:
    """Compile quietly, with the lock of the cache where it is needed.

    The compiler of DOLFINx 0.5 leaves a file open for Python to close, which Python reports, and logs its
    command lines.  Raises SolverFailed where nothing can be compiled.
    """
    cache: Path = _options()["cache_dir"]
    look_up = jit.get_cached_module
    with warnings.catch_warnings(), ExitStack() as alone:
        warnings.simplefilter("ignore", ResourceWarning)
        logging.disable(logging.INFO)
        jit.get_cached_module = _locked(look_up, cache, alone)
        try:
            yield
        except (OSError, ImportError, VerificationError) as error:
            raise SolverFailed(f"a panel's form cannot be compiled in {cache}: {error}") from error
        finally:
            jit.get_cached_module = look_up
            logging.disable(logging.NOTSET)


def _locked(look_up: Callable[..., Any], cache: Path, alone: ExitStack) -> Callable[..., Any]:
    """Return FFCx's ``look_up`` of a module in the cache, which compiles missing modules under the lock.

    ``alone`` holds the lock until the module has been compiled.
    """

    def looked_up(module: str, *more: Any) -> Any:
        source = cache / f"{module}.c"

        def ready() -> bool:
            return source.exists() and source.with_suffix(".c.cached").exists()

        if not ready():
            alone.enter_context(_alone(cache, ready))
        return look_up(module, *more)

    return looked_up


@contextmanager
def _alone(cache: Path, ready: Callable[[], bool]) -> Iterator[None]:
    """Hold the lock of the cache, so that no other process works on it and nothing in it is half made.

    The lock is not taken where another process has made the wanted module, which is then ``ready``.  Raises
    SolverFailed where another process takes too long.
    """
    cache.mkdir(parents=True, exist_ok=True)
    with (cache / "lock").open("a+") as lock:
        try:
            mine = _waited_for(lock, ready)
        except OSError:  # no locks on this file system: FFCx waits by its own means
            yield
            return
        if mine:
            lock.truncate(0)
            lock.write(f"process {os.getpid()} on {platform.node()} since {time.ctime()}")
            lock.flush()
            for source in cache.glob("*.c"):
                if not source.with_suffix(".c.cached").exists():
                    source.unlink()
        yield


def _waited_for(lock: IO[str], ready: Callable[[], bool]) -> bool:
    """Wait for the lock; return True with the lock, or False as soon as the wanted module is ``ready``.

    Raises OSError on a file system without locks, and SolverFailed where one process has held the lock for
    too long.
    """
    holder, since_s, reported = "", time.monotonic(), False
    while not ready():
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            pass
        else:
            return True
        lock.seek(0)
        before, holder = holder, lock.read() or "another process"
        waited_s = time.monotonic() - since_s
        if holder in _given_up or (holder == before and waited_s > GIVEN_UP_AFTER_S):
            _given_up.add(holder)
            raise SolverFailed(
                f"a panel's form is not compiled: {holder} has held {lock.name} for more than "
                f"{GIVEN_UP_AFTER_S:g} s.  Is it stopped (kill -CONT lets it go on)?  "
                "XDG_CACHE_HOME may name another folder for compiled forms"
            )
        if holder != before:
            since_s = time.monotonic()
        elif waited_s > SAID_AFTER_S and not reported:
            reported = True
            print(
                f"waiting for {holder}: it compiles a panel's form ({lock.name})", file=sys.stderr, flush=True
            )
        time.sleep(0.05)
    return False


def form(integral: Any) -> Any:
    """Return the compiled form of a UFL integral."""
    with _compiling():
        return fem.form(integral, **dolfinx_versions.compiling(_options()))


def expression(value: Any, points: Array, domain: Any) -> Callable[..., Array]:
    """Return the function that evaluates a UFL expression on the mesh ``domain``.

    Its arguments are numbers of cells, and an array to write to if there is one. It returns the values
    (cells, points * components) at the reference ``points`` (n, cell dimension) of each cell.
    """
    with _compiling():
        compiled = fem.Expression(value, points, **dolfinx_versions.compiling(_options()))
    return partial(dolfinx_versions.evaluated, compiled, domain)


def function_space(domain: Any, family: str, degree: int, size: int = 0) -> Any:
    """Return the finite-element space of a family on a mesh: of scalars, or of vectors with ``size``
    components."""
    element = dolfinx_versions.element(domain.ufl_cell().cellname(), family, degree, size)
    with _compiling():
        return dolfinx_versions.space(domain, element, dolfinx_versions.compiling(_options()))


def linear_mesh(cell: str, points_m: Array, cells: Indices) -> Any:
    """Return the mesh of ``cells`` (cells, corners) of one kind between points (n, cell dimension)."""
    linear = ufl.Mesh(dolfinx_versions.element(cell, "Lagrange", 1, points_m.shape[1]))
    return mesh.create_mesh(MPI.COMM_SELF, cells, points_m, linear)


def assembled_matrix(integral: Any) -> csr_matrix:
    """Return the assembled matrix of a UFL bilinear form."""
    matrix = fem_petsc.assemble_matrix(form(integral))
    matrix.assemble()
    starts, columns, values = matrix.getValuesCSR()
    matrix.destroy()
    return csr_matrix((values, columns, starts))
