"""A process of its own that draws, or reads what may crash the reader."""

from __future__ import annotations

import ctypes
import signal
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context

PR_SET_PDEATHSIG = 1  # of Linux's <sys/prctl.h>


def worker(method: str = "fork") -> ProcessPoolExecutor:
    """Return a process that takes work, started with a ``method`` of multiprocessing.

    It is killed when this process dies.
    """
    return ProcessPoolExecutor(1, get_context(method), _end_with_parent)


def _end_with_parent() -> None:
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
