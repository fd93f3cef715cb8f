"""Imports are those that docker/ names for this Debian, and pins from PyPI, no more."""

from __future__ import annotations

import json
import subprocess
import sys
import sysconfig
from functools import cache
from importlib import metadata
from pathlib import Path

import pytest

from orchestrator.case import provenance as known
from orchestrator.case.provenance import DEBIAN, PYPI, Distribution, departures, provenance, versions

CHECKOUT = Path(__file__).parents[1]
# Imports every module of the project, and tells the files of all that came with them.
IMPORT_ALL = """
import json, pkgutil, sys
import pyvista
import adapters, meshes, orchestrator

for folder in (orchestrator, adapters, meshes):
    for module in pkgutil.walk_packages(folder.__path__, folder.__name__ + "."):
        if not module.name.endswith("__main__"):
            __import__(module.name)
import distributed, exudyn, gmsh, pyarrow  # which functions import where they need them
files = {getattr(module, "__file__", None) for module in sys.modules.values()}
print(json.dumps([file for file in files if file]))
"""


def test_the_environment_is_the_pinned_one() -> None:
    distributions = dict(known.distributions())
    print("\n".join(f"{name} {distribution}" for name, distribution in distributions.items()))
    assert departures(distributions) == []


@pytest.mark.process
@pytest.mark.solver
def test_every_imported_module_belongs_to_a_pinned_distribution() -> None:
    """Modules imported at the bottom of something else count, too, and those that have no metadata at all."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", IMPORT_ALL],
        capture_output=True,
        encoding="utf-8",
        check=True,
        cwd=CHECKOUT,
    )
    files = [Path(file) for file in json.loads(done.stdout)]
    strange = [file for file in files if not of_python(file) and owner(file) is None]
    assert strange == []
    imported = {owner(file) for file in files}
    print(sorted(name for name in imported if name))
    assert {"numpy", "scipy", "mpi4py", "petsc4py", "h5py", "cffi", "fenics-dolfinx"} <= imported
    assert {"exudyn", "gmsh", "pyarrow", "distributed", "meshio", "vtk", "flipflow"} <= imported


def of_python(file: Path) -> bool:
    """Return whether a module is of Python's own library, or of this checkout, but not of what is installed
    beside it."""
    if Path(sys.prefix) in file.parents:
        return False
    own = Path(sys.base_prefix) / "lib" in file.parents or CHECKOUT in file.parents
    return own and not {"dist-packages", "site-packages"} & set(file.parts)


def owner(file: Path) -> str | None:
    """The distribution of a module in one of the two folders of the environment."""
    for folder in (Path(sys.prefix) / "debian", Path(sysconfig.get_path("purelib"))):
        if folder in file.parents:
            return owners().get(file.relative_to(folder).parts[0].split(".")[0])
    return None


@cache
def owners() -> dict[str, str]:
    """The distribution of every name at the top of the two folders."""
    return {
        name: known.normalise(distribution.metadata["Name"])
        for distribution in metadata.distributions()
        for name in (
            *(file.parts[0].split(".")[0] for file in distribution.files or ()),
            *(distribution.read_text("top_level.txt") or "").split(),
        )
    }


def test_the_provenance_of_a_run_tells_the_same() -> None:
    record = provenance(1)
    assert record["distributions"] == {
        n: str(distribution) for n, distribution in known.distributions().items()
    }
    numpy = known.pins()[DEBIAN, "numpy"]
    assert record["distributions"]["numpy"].startswith(f"{numpy} from Debian, python3-numpy 1:{numpy}")
    assert record["distributions"]["meshio"] == "5.3.5 from PyPI"
    assert record["not_as_pinned"] == []
    assert None not in versions().values()


@pytest.mark.parametrize(
    ("distribution", "pinned"),
    [
        (Distribution("meshio", "5.0.0", PYPI), "5.3.5"),
        (Distribution("meshio", "5.3.5", "/usr/lib/python3/dist-packages"), ""),
        (Distribution("pandas", "1.5.3", DEBIAN, "python3-pandas 1.5.3-1"), ""),
        (Distribution("numpy", "1.26.4", PYPI), ""),
    ],
)
def test_what_is_not_as_pinned_is_said(distribution: Distribution, pinned: str) -> None:
    (sentence,) = departures(known.distributions() | {distribution.name: distribution})
    assert {distribution.name, distribution.version} <= {*sentence.split()}
    assert pinned in sentence


def test_what_is_not_there_is_said() -> None:
    distributions = dict(known.distributions())
    distributions.pop("petsc4py")
    (sentence,) = departures(distributions)
    assert {"petsc4py", f"docker/{known.debian_pins()}"} <= {*sentence.split()}


@pytest.mark.process
def test_what_setuptools_brings_along_belongs_to_it() -> None:
    """On Debian 13 setuptools, which compiles forms, adds a folder of its own to the path."""
    code = "import setuptools; from orchestrator.case.provenance import departures; print(departures())"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", cwd=CHECKOUT)
    assert done.stdout == "[]\n"


def test_a_folder_on_the_path_does_not_go_unsaid(tmp_path: Path) -> None:
    """PYTHONPATH brings a distribution that nobody pinned: a run says it."""
    info = tmp_path / "pandas-1.5.3.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: pandas\nVersion: 1.5.3\n")
    code = "from orchestrator.case.provenance import warnings; print(warnings())"
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        encoding="utf-8",
        check=True,
        env={"PYTHONPATH": str(tmp_path)},
    )
    assert f"not the program that was tested: pandas is 1.5.3 from {tmp_path}" in done.stdout
    assert known.warnings() == []
