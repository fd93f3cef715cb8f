"""Forms and expressions compiled for this processor.

Optimised code halves the time of an assembly (measured, docs/theory/panel_sheet.md).  It must not
run on another kind of processor, so each kind has a cache folder of its own.
"""

from __future__ import annotations

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

from dolfinx import fem

from orchestrator.ports import Array

COMPILE_TIMEOUT_S = 120


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
    reports, and logs its command lines."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)
        logging.disable(logging.INFO)
        try:
            yield
        finally:
            logging.disable(logging.NOTSET)


def form(integral: Any) -> Any:
    """The compiled form of a UFL integral."""
    with _compiling():
        return fem.form(integral, jit_params=_options())


def expression(value: Any, points: Array) -> Any:
    """The compiled UFL expression at reference ``points`` (n, cell dimension) of each cell."""
    with _compiling():
        return fem.Expression(value, points, jit_params=_options())


def function_space(mesh: Any, element: Any) -> Any:
    """The finite-element space of a UFL element on a mesh."""
    with _compiling():
        return fem.FunctionSpace(mesh, element, jit_params=_options())
