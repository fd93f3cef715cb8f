"""Cases over other cases: ``base = "../other"`` in case.toml names the folder of the case below.

The tables of the base come first, and the tables of the case are laid over them by the rules of levels
(``layers.py``).  A base may have a base of its own.  Names of files in a base are rewritten, so that a file
is found in the folder in which its name was written.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchestrator.case.file.bushing_curve import read_curve_files
from orchestrator.case.file.characteristic import read_characteristic_files
from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean, show_value
from orchestrator.case.file.layers import Layers, read_toml
from orchestrator.case.file.nested import nested, value_at
from orchestrator.case.file.sieve_analysis import read_sieve_analyses

CASE_FILE = "case.toml"
BASE = "base"
BEDS = (("bed", "table"), ("bed", "from_run"))
"""Keys of beds that a case takes over, which are found from the case's folder or the working directory."""
IN_SCREEN = (
    *(("surfaces", key) for key in ("file", "stl")),
    *((kind, "apertures", "file") for kind in ("panels", "decks")),
)
"""Keys of files in the rows of tables of ``[screen]``: the table, and the key in a row."""


@dataclass(frozen=True)
class CaseFile:
    """A case.toml of a chain of cases.

    ``table`` is its content without the key ``base``, ``base`` is the value of that key ("" without it), and
    ``source`` is the name of the file in messages.
    """

    folder: Path
    source: str
    base: str
    table: Mapping[str, Any]


def read_chain(file: Path) -> tuple[CaseFile, ...]:
    """Return a case.toml and those of its bases; the case itself comes first.

    Raises CaseError for a file that cannot be read, a base that is no case, and bases in a circle.
    """
    file = file.resolve()
    chain: list[CaseFile] = []
    folder = here = file.parent
    source = file.name
    while True:
        table = read_toml(here / CASE_FILE, here) if chain else read_toml(file)
        table = read_data_files(table, here, source)
        base = table.pop(BASE, "")
        chain.append(CaseFile(here, source, base, with_files_at(table, here, folder)))
        if base == "":
            return tuple(chain)
        here = _base_folder(base, here, source)
        if here in (each.folder for each in chain):
            circle = " -> ".join([*(each.folder.name for each in chain), here.name])
            raise CaseError([CaseProblem((BASE,), f"the bases form a circle: {circle}", file=source)])
        source = str(Path(os.path.relpath(here, folder)) / CASE_FILE)


def read_data_files(table: dict[str, Any], folder: Path, source: str) -> dict[str, Any]:
    """Return a case's table with what stands in the files of data that it names in a folder.

    Raises CaseError with all mistakes in the files.
    """
    table = deepcopy(table)
    readers = (read_curve_files, read_characteristic_files, read_sieve_analyses)
    if problems := [problem for read in readers for problem in read(table, folder, source)]:
        raise CaseError(problems)
    return table


def case_folders(folder: Path) -> tuple[Path, ...]:
    """Return the folder of a case and the folders of its bases; other folders stand alone."""
    if not (folder / CASE_FILE).is_file():
        return (folder,)
    return tuple(each.folder for each in read_chain(folder / CASE_FILE))


def lay_chain(chain: tuple[CaseFile, ...]) -> Layers:
    """Return the tables of a chain of cases, laid over each other.  Raises CaseError."""
    layers = Layers({}, chain[0].source)
    for each in reversed(chain):
        layers.lay(each.table, each.source)
    return layers


def find_level(folder: Path, name: str) -> Path:
    """Return the file of a level, of the case in a folder or of the nearest base that has it.

    A name that ends in ".toml" is the path of any TOML file.  Where no case has the level, the path is that
    in the case's own folder.  Raises CaseError.
    """
    if name.endswith(".toml"):
        return Path(name)
    files = [each / "levels" / f"{name}.toml" for each in case_folders(folder)]
    return next((file for file in files if file.is_file()), files[0])


def read_level(folder: Path, name: str) -> tuple[dict[str, Any], str]:
    """Return the table of a level of the case in a folder, and the name of its file in messages.

    Raises CaseError.
    """
    file = find_level(folder, name)
    if file == Path(name):
        return read_data_files(read_toml(file), folder, name), name
    written, source = file.parents[1], os.path.relpath(file, folder)
    table = read_data_files(read_toml(file, written), written, source)
    return with_files_at(table, written.resolve(), folder.resolve()), source


def level_names(folder: Path) -> list[str]:
    """Return the names of the levels of a case and of its bases.  Raises CaseError."""
    return sorted({file.stem for each in case_folders(folder) for file in (each / "levels").glob("*.toml")})


def with_files_at(table: Mapping[str, Any], written: Path, folder: Path) -> dict[str, Any]:
    """Return a table that was written in one folder with names of files as seen from another folder.

    Beds may also be found from the working directory; a name of a bed that is not there keeps its meaning.
    """
    if written == folder:
        return dict(table)
    at = Layers(table, "")
    for key in _file_keys(table):
        file = written / value_at(table, key)
        if key not in BEDS or file.exists():
            at.lay(nested(key, os.path.relpath(file, folder)), "")
    return at.merged


def _file_keys(table: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the keys in a case's table whose values are names of files."""
    keys = [*BEDS]
    for kind, *inner in IN_SCREEN:
        rows = value_at(table, ("screen", kind))
        keys += [("screen", kind, name, *inner) for name in (rows if isinstance(rows, Mapping) else ())]
    return [key for key in keys if isinstance(value_at(table, key), str)]


def _base_folder(base: Any, folder: Path, source: str) -> Path:
    """Return the folder of a base that the case.toml in a folder names.  Raises CaseError."""
    hint = f'for example {BASE} = "../ffs0827-empty"'
    if not isinstance(base, str) or not base.isprintable() or Path(base).is_absolute():
        what = f"must be the folder of another case, seen from this one, not {show_value(base)}"
        raise CaseError([CaseProblem((BASE,), what, hint, source, kind="wrong-type")])
    found = (folder / base).resolve()
    if not (found / CASE_FILE).is_file():
        beside = sorted(each.parent.name for each in found.parent.glob(f"*/{CASE_FILE}"))
        hint = did_you_mean(found.name, beside, say="cases there") if beside else hint
        what = f"{show_value(base)} is not a case: there is no {CASE_FILE}"
        raise CaseError([CaseProblem((BASE,), what, hint, source, kind="file")])
    return found
