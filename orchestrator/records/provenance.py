"""Who ran what, where and with which versions."""

from __future__ import annotations

import os
import platform
import socket
import subprocess
import sys
from datetime import UTC, datetime
from importlib import metadata
from pathlib import Path
from typing import Any

import h5py

PACKAGES = ("flipflow", "numpy", "scipy", "pydantic", "exudyn", "fenics-dolfinx", "mpi4py")


def provenance(ranks: int) -> dict[str, Any]:
    """What a run folder says of where it comes from."""
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
    }


def versions() -> dict[str, str | None]:
    """Of this program and of what it stands on; None where it is not installed."""
    return {
        **{name: _version(name) for name in PACKAGES},
        "h5py": h5py.__version__,
        "libliggghts3": _debian_version("libliggghts3"),
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _debian_version(package: str) -> str | None:
    """LIGGGHTS does not tell its own version; Debian knows it."""
    try:
        return _said("dpkg-query", "-W", "-f", "${Version}", package)
    except (OSError, subprocess.CalledProcessError):
        return None


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
