"""Who ran what, where and with which versions."""

from __future__ import annotations

import json
import os
import platform
import re
import socket
import subprocess
import sys
from dataclasses import dataclass
from datetime import UTC, datetime
from functools import cache
from importlib import metadata
from pathlib import Path
from typing import Any

PINS = Path(__file__).parents[2] / "docker"
DEBIAN, PYPI, CHECKOUT = "Debian", "PyPI", "this checkout"


@dataclass(frozen=True)
class Distribution:
    """``name`` in lower case with dashes; ``origin``: Debian, PyPI, this checkout, or the folder
    of one that was neither linked by set-up nor installed by pip; ``debian_package`` of those
    from Debian, else empty."""

    name: str
    version: str
    origin: str
    debian_package: str = ""

    def __str__(self) -> str:
        return ", ".join(filter(None, (f"{self.version} from {self.origin}", self.debian_package)))


@cache
def distributions() -> dict[str, Distribution]:
    """Every distribution on the import path, by name; of two with one name, the one that Python
    imports."""
    found: dict[str, Distribution] = {}
    for one in metadata.distributions():
        name = normalise(one.metadata["Name"] or "")
        found.setdefault(name, Distribution(name, one.version, *_origin(one)))
    return dict(sorted(found.items()))


def normalise(name: str) -> str:
    """Python's packaging rules: letters' case, dots, dashes and underscores make no difference."""
    return re.sub(r"[-_.]+", "-", name).lower()


def _origin(one: metadata.Distribution) -> tuple[str, str]:
    """The origin, and the Debian package with its version where it is Debian's."""
    package = one.read_text("debian-package")
    if package is not None:
        return DEBIAN, f"{package.strip()} {debian_version(package.strip()) or 'not installed'}"
    direct = json.loads(one.read_text("direct_url.json") or "{}")
    if direct.get("dir_info", {}).get("editable"):
        return CHECKOUT, ""
    if (one.read_text("INSTALLER") or "").strip() == "pip":
        return PYPI, ""
    return str(one.locate_file("")), ""


def debian_version(package: str) -> str | None:
    """As Debian calls it; None where it is not installed, or where there is no dpkg."""
    return _debian_versions().get(package)


@cache
def _debian_versions() -> dict[str, str]:
    """Of all packages; asking for each one takes ten times as long."""
    try:
        said = _output("dpkg-query", "-W", "-f", "${Package} ${Version}\n")
    except (OSError, subprocess.CalledProcessError):
        return {}
    return dict(line.split() for line in said.splitlines() if line.count(" ") == 1)


def pins() -> dict[tuple[str, str], str]:
    """The versions that are meant, by origin and name; empty where no checkout says them."""
    return {
        (origin, normalise(name)): version
        for origin, file in ((DEBIAN, PINS / "debian.txt"), (PYPI, PINS / "constraints.txt"))
        if file.is_file()
        for name, version in re.findall(r"^([\w.-]+)==(\S+)", file.read_text(), re.MULTILINE)
    }


def departures(found: dict[str, Distribution] | None = None) -> list[str]:
    """What is not as it is pinned, one sentence each; ``found``: by default, what is there."""
    found = distributions() if found is None else found
    pinned = pins()
    if not pinned:
        return []
    said = [
        f"{one.name} is {one}, "
        + (f"but {version} is pinned" if version else "and no pin of docker/ names it from there")
        for one in found.values()
        if one.origin != CHECKOUT and (version := pinned.get((one.origin, one.name))) != one.version
    ]
    missing = [name for origin, name in pinned if origin == DEBIAN and name not in found]
    return said + [f"{name} is not there, docker/debian.txt names it" for name in missing]


def warnings() -> list[str]:
    """One line for a user, where anything is not as it is pinned."""
    said = departures()
    if not said:
        return []
    more = f", and {len(said) - 1} more (provenance.json has them)" if len(said) > 1 else ""
    return [f"not the program that was tested: {said[0]}{more}; bash docker/setup.sh mends it"]


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
    git = ("git", "-C", str(Path(__file__).parent))
    try:
        commit = _output(*git, "rev-parse", "HEAD")
        return commit + ("+" if _output(*git, "status", "--porcelain", "-uno") else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def _output(*command: str) -> str:
    """What a command prints.  Raises OSError or CalledProcessError."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
