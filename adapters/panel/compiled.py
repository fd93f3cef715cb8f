"""Forms and expressions compiled for this processor.

Optimised code halves the time of an assembly (measured, docs/theory/panel_sheet.md).  It must not
run on another kind of processor, so each kind has a cache folder of its own.

The cache is shared by all processes.  FFCx marks what is being compiled by its C file alone: a
process that is killed meanwhile would leave a mark on which all later ones wait in vain.  So one
process at a time compiles, under a lock that ends with it, and what it finds half made is removed.
"""

from __future__ import annotations

import fcntl
import hashlib
import logging
import os
import platform
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

from cffi import VerificationError
from dolfinx import fem
from ffcx.parameters import FFCX_DEFAULT_PARAMETERS

from orchestrator.plans import SolverFailed
from orchestrator.ports import Array

COMPILE_TIMEOUT_S = 120  # for others to compile, on a file system without locks

# FFCx would take what is not given from a file in the folder that the program is started in
CODE = {name: value for name, (value, _) in FFCX_DEFAULT_PARAMETERS.items()}


def _processor() -> str:
    """What ``-march=native`` depends on: the processor's model and its instruction sets."""
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
        "timeout": COMPILE_TIMEOUT_S,
    }


@contextmanager
def _compiling() -> Iterator[None]:
    """Quietly: the compiler of DOLFINx 0.5 leaves a file open for Python to close, which Python
    reports, and logs its command lines.  Raises SolverFailed where nothing can be compiled."""
    cache: Path = _options()["cache_dir"]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        logging.disable(logging.INFO)
        try:
            with _alone(cache):
                yield
        except (OSError, ImportError, VerificationError) as error:
            raise SolverFailed(f"a panel's form cannot be compiled in {cache}: {error}") from error
        finally:
            logging.disable(logging.NOTSET)


@contextmanager
def _alone(cache: Path) -> Iterator[None]:
    """No other process works on the cache meanwhile, and nothing in it is half made."""
    cache.mkdir(parents=True, exist_ok=True)
    with (cache / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX)
        except OSError:  # no locks on this file system: FFCx waits by its own means
            yield
            return
        for source in cache.glob("*.c"):
            if not source.with_suffix(".c.cached").exists():
                source.unlink()
        yield


def form(integral: Any) -> Any:
    """The compiled form of a UFL integral."""
    with _compiling():
        return fem.form(integral, form_compiler_params=CODE, jit_params=_options())


def expression(value: Any, points: Array) -> Any:
    """The compiled UFL expression at reference ``points`` (n, cell dimension) of each cell."""
    with _compiling():
        return fem.Expression(value, points, CODE, _options())


def function_space(mesh: Any, element: Any) -> Any:
    """The finite-element space of a UFL element on a mesh."""
    with _compiling():
        return fem.FunctionSpace(mesh, element, None, CODE, _options())
