"""Who ran what, where and with which versions."""

from __future__ import annotations

import os
import platform
import socket
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from orchestrator.case.distributions import debian_version, departures, distributions

PACKAGES = ("flipflow", "numpy", "scipy", "pydantic", "exudyn", "fenics-dolfinx", "mpi4py", "h5py")


def provenance(ranks: int) -> dict[str, Any]:
    """What a run folder says of where it comes from."""
    found = distributions()
    return {
        "command": sys.argv,
        "started": datetime.now(UTC).isoformat(timespec="seconds"),
        "host": socket.gethostname(),
        "machine": f"{platform.machine()}, {os.cpu_count()} processors",
        "system": platform.platform(),
        "python": platform.python_version(),
        "ranks": ranks,
        "versions": versions(),
        "commit": commit(),
        "distributions": {name: str(one) for name, one in found.items()},
        "not_as_pinned": departures(),
    }


def versions() -> dict[str, str | None]:
    """Of this program and of what it stands on; None where it is not installed."""
    found = distributions()
    return {
        **{name: found[name].version if name in found else None for name in PACKAGES},
        "libliggghts3": debian_version("libliggghts3"),  # LIGGGHTS does not tell its own version
    }


def commit() -> str | None:
    """The commit of the checkout that this program runs from, with "+" for local changes."""
    here = Path(__file__).parent
    try:
        commit = _git(here, "rev-parse", "HEAD")
        return commit + ("+" if _git(here, "status", "--porcelain", "-uno") else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def _git(folder: Path, *words: str) -> str:
    return _said("git", "-C", str(folder), *words)


def _said(*command: str) -> str:
    """What a command prints.  Raises OSError or CalledProcessError."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
