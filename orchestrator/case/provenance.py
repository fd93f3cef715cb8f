"""The provenance of a run: its command, its machine and the versions of all software."""

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

from orchestrator.case.file.folder import UnreadableFile, read_json

PINS = Path(__file__).parents[2] / "docker"
DEBIAN, PYPI, CHECKOUT = "Debian", "PyPI", "this checkout"


@dataclass(frozen=True)
class Distribution:
    """A Python distribution on the import path; its ``name`` is in lower case with dashes.

    ``origin`` is Debian, PyPI, this checkout, or the folder of a distribution that neither the set-up
    linked nor pip installed.  ``debian_package`` is the package with its version, empty for all
    distributions that are not from Debian.
    """

    name: str
    version: str
    origin: str
    debian_package: str = ""

    def __str__(self) -> str:
        return ", ".join(filter(None, (f"{self.version} from {self.origin}", self.debian_package)))


@cache
def distributions() -> dict[str, Distribution]:
    """Return every distribution on the import path, by name.

    If two have the same name, the distribution that Python imports is returned.  What setuptools brings along
    in a folder of its own, which it adds to the path when it is imported, is part of setuptools.
    """
    known: dict[str, Distribution] = {}
    path = [folder for folder in sys.path if not folder.endswith("setuptools/_vendor")]
    for installed in metadata.distributions(path=path):
        about = installed.metadata  # read from its file each time
        name = normalise(about["Name"] or "")
        known.setdefault(name, Distribution(name, about["Version"], *_origin(installed)))
    return dict(sorted(known.items()))


def normalise(name: str) -> str:
    """Return a distribution's name in the normal form of Python's packaging rules.

    Upper and lower case are equal in these rules, and so are dots, dashes and underscores.
    """
    return re.sub(r"[-_.]+", "-", name).lower()


def _origin(distribution: metadata.Distribution) -> tuple[str, str]:
    """Return the origin, and the Debian package with its version or an empty string."""
    package = distribution.read_text("debian-package")
    if package is not None:
        return DEBIAN, f"{package.strip()} {debian_version(package.strip()) or 'not installed'}"
    direct = json.loads(distribution.read_text("direct_url.json") or "{}")
    if direct.get("dir_info", {}).get("editable"):
        return CHECKOUT, ""
    if (distribution.read_text("INSTALLER") or "").strip() == "pip":
        return PYPI, ""
    return str(distribution.locate_file("")), ""


def debian_version(package: str) -> str | None:
    """Return Debian's version of a package; None if the package or dpkg itself is not installed."""
    return _debian_versions().get(package)


@cache
def _debian_versions() -> dict[str, str]:
    """Return the versions of all Debian packages; a query for each package takes ten times as long."""
    try:
        output = _output("dpkg-query", "-W", "-f", "${Package} ${Version}\n")
    except (OSError, subprocess.CalledProcessError):
        return {}
    return dict(line.split() for line in output.splitlines() if line.count(" ") == 1)


def debian_pins() -> str:
    """Return the name of the file in ``docker/`` that pins the distributions of this release of Debian."""
    return f"debian{_release()}.txt"


@cache
def _release() -> str:
    """Return the number of this release of Debian, or an empty string elsewhere."""
    try:
        return platform.freedesktop_os_release().get("VERSION_ID", "")
    except OSError:
        return ""


def pins() -> dict[tuple[str, str], str]:
    """Return the pinned versions, by origin and name; nothing outside of a checkout."""
    of_pypi = ("constraints.txt", f"constraints{_release()}.txt")
    return {
        (origin, normalise(name)): version
        for origin, files in ((DEBIAN, (debian_pins(),)), (PYPI, of_pypi))
        for file in (PINS / name for name in files)
        if file.is_file()
        for name, version in re.findall(r"^([\w.-]+)==(\S+)", file.read_text(), re.MULTILINE)
    }


def departures(known: dict[str, Distribution] | None = None) -> list[str]:
    """Return a sentence for each departure of ``known`` distributions from the pinned versions.

    By default, ``known`` are all distributions on the import path.
    """
    known = distributions() if known is None else known
    pinned = pins()
    if not pinned:
        return []
    sentences = [
        f"{one.name} is {one}, "
        + (f"but {version} is pinned" if version else "and no pin of docker/ names it from there")
        for one in known.values()
        if one.origin != CHECKOUT and (version := pinned.get((one.origin, one.name))) != one.version
    ]
    missing = [name for origin, name in pinned if origin == DEBIAN and name not in known]
    return sentences + [f"{name} is not there, docker/{debian_pins()} names it" for name in missing]


def warnings() -> list[str]:
    """Return a warning for the user in one line if any version departs from its pin, else no line."""
    sentences = departures()
    if not sentences:
        return []
    more = f", and {len(sentences) - 1} more (provenance.json has them)" if len(sentences) > 1 else ""
    return [f"not the program that was tested: {sentences[0]}{more}; bash docker/setup.sh mends it"]


PACKAGES = ("flipflow", "numpy", "scipy", "pydantic", "exudyn", "fenics-dolfinx", "mpi4py", "h5py")


def provenance(ranks: int) -> dict[str, Any]:
    """Return the content of ``provenance.json`` for a run on so many ranks."""
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
        "distributions": {name: str(one) for name, one in distributions().items()},
        "not_as_pinned": departures(),
    }


def read_provenance(folder: Path) -> dict[str, Any]:
    """Return the table of ``provenance.json`` in the folder of a run.  Raises OSError or UnreadableFile."""
    file = folder / "provenance.json"
    try:
        table: dict[str, Any] | None = read_json(file)
    except UnreadableFile:
        table = None
    parts = {"bed": dict, "resumed": list}
    if not isinstance(table, dict) or not all(isinstance(table.get(k, t()), t) for k, t in parts.items()):
        raise UnreadableFile(f"{file}: is damaged; it is written when a run begins, and cannot be made again")
    return table


def versions() -> dict[str, str | None]:
    """Return the versions of this program and of its main libraries; None for one not installed."""
    known = distributions()
    return {
        **{name: known[name].version if name in known else None for name in PACKAGES},
        "liggghts": debian_version("liggghts"),  # it does not tell its own version
    }


def commit() -> str | None:
    """Return the commit of the checkout that this program runs from, with "+" for local changes.

    Returns None outside of a checkout or without git.
    """
    git = ("git", "-C", str(Path(__file__).parent))
    try:
        commit = _output(*git, "rev-parse", "HEAD")
        return commit + ("+" if _output(*git, "status", "--porcelain", "-uno") else "")
    except (OSError, subprocess.CalledProcessError):
        return None


def _output(*command: str) -> str:
    """Return the output of a command.  Raises OSError or CalledProcessError."""
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
