"""The files of a run: one reader, a version and a written schema each."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from orchestrator.output import checkpoints
from orchestrator.output.records.history import COLUMNS, History
from orchestrator.output.records.run_folder import OtherFormat
from orchestrator.output.results.run_reader import RunReader
from tests.results.synthetic import folder_of
from tests.runs.test_manual import MANUAL

ROOT = Path(__file__).parents[2]
FILES = {"history.h5", "summary.json"}
NAMING = "orchestrator/output/records/run_folder.py"
OPENER = "orchestrator/case/file/folder.py"
WRITERS = {"orchestrator/output/records/history.py", "orchestrator/output/records/summary.py"}
BEDS = "orchestrator/case/bed/saved_bed.py"
CARRIER = "orchestrator/case/bed/carry.py"
"""It asks the summary of a run, below the reader's floor, whether its bed can be trusted."""
OWN_JSON = {"orchestrator/case/provenance.py", "orchestrator/preflight/judgement/pair.py"}
"""Readers of files that this program or an installer has written on this machine."""


def product() -> dict[str, ast.Module]:
    files = [*ROOT.glob("orchestrator/**/*.py"), *ROOT.glob("adapters/**/*.py")]
    return {str(file.relative_to(ROOT)): ast.parse(file.read_text()) for file in files}


def test_nobody_but_the_reader_opens_a_run() -> None:
    """HDF5 is used by the opener of files, the writer and saved beds alone, and nobody but the
    opener reads JSON of a folder that another may have filled."""
    for file, tree in product().items():
        names = {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)}
        texts = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant)}
        allowed = file in {OPENER, BEDS, *WRITERS}
        assert "h5py" not in names or allowed, f"{file} uses HDF5: RunReader reads a run"
        assert not FILES & texts or file in {NAMING, CARRIER}, f"{file} names a file that RunReader reads"
        calls = {ast.unparse(node) for node in ast.walk(tree) if isinstance(node, ast.Attribute)}
        assert not {"json.load", "json.loads"} & calls or file in {OPENER, *OWN_JSON}, file


def test_the_manual_has_the_schema_of_the_history() -> None:
    documented: dict[str, set[str]] = {}
    by_the_case = ("energy", "energy_cycles", "results")  # what they hold depends on the case
    section = MANUAL.split("## `history.h5`\n", 1)[1].split("\n## ", 1)[0]
    for kind, names in re.findall(r"^\|`([a-z_]+)[^`]*` \|(.*?) \|", section, flags=re.M):
        documented[kind] = set(re.findall(r"`([^`]+)`", names)) - {"time_s"}
    assert {kind: set(names) for kind, names in COLUMNS.items()} == {
        kind: names for kind, names in documented.items() if kind not in by_the_case
    }


def test_what_is_not_in_the_schema_is_not_written(tmp_path: Path) -> None:
    history = History(tmp_path / "history.h5")
    history.add("bed", 0.0, {"mas_kg": 1.0})
    with pytest.raises(KeyError, match="bed/mas_kg"):
        history.flush()


@pytest.mark.parametrize("version", [None, 1, 99])
@pytest.mark.parametrize("name", sorted(FILES))
def test_another_version_of_a_runs_file_is_refused(tmp_path: Path, name: str, version: int | None) -> None:
    folder = folder_of(tmp_path / "run", particles=False, cycles=2)
    _set_version(folder / name, version)
    with RunReader(folder) as run, pytest.raises(OtherFormat, match=rf"{name}:.*\b{version}\b"):
        getattr(run, "history" if name == "history.h5" else "summary")


def _set_version(file: Path, version: int | None) -> None:
    if file.suffix == ".json":
        table: dict[str, Any] = json.loads(file.read_text())
        del table["format_version"]
        file.write_text(json.dumps(table if version is None else table | {"format_version": version}))
        return
    with h5py.File(file, "a") as history:
        del history.attrs["format_version"]
        if version is not None:
            history.attrs["format_version"] = version


def _write_checkpoint(folder: Path, sync_points: int, good: int) -> None:
    provenance = dict.fromkeys(checkpoints.ORIGIN_KEYS, 1)
    about = {
        "name": "x",
        "level": "",
        "case": {},
        "files": {},
        "left_out": {},
        "provenance": provenance,
        "good": good,
    }
    about |= {"sync_points": sync_points, "progress": {"figures": {"simulated_s": 0.1}}}
    checkpoints.write(folder, {"place_m": np.zeros(3)}, [], about, None)


def test_the_last_two_checkpoints_and_the_last_without_trouble_stay(tmp_path: Path) -> None:
    for sync_points, good in ((10, 10), (20, 20), (30, 20), (40, 20), (50, 20)):
        _write_checkpoint(tmp_path, sync_points, good)
    left = {n: checkpoints.find_at_sync_point(tmp_path, n) is not None for n in range(10, 60, 10)}
    assert left == {10: False, 20: True, 30: False, 40: True, 50: True}


def test_another_version_of_a_checkpoint_is_refused(tmp_path: Path) -> None:
    _write_checkpoint(tmp_path, 3, 3)
    checkpoint = checkpoints.find_newest(tmp_path)
    assert checkpoint is not None
    assert checkpoints.array_names(checkpoint.state(None)) == {"place_m"}
    _set_version(checkpoint.folder / checkpoints.ABOUT, 1)
    with pytest.raises(OtherFormat, match=r"checkpoint\.json: has format 1; this flipflow reads format"):
        checkpoints.find_newest(tmp_path)
