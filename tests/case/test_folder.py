"""The contents that the folder of a run or study may have, and how its files are opened."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.case.bed.carry import read_run
from orchestrator.case.bed.saved_bed import UnreadableBed
from orchestrator.case.file import folder as folders
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable, UnreadableFile, admit, open_hdf5, read_json
from orchestrator.output.report.rendering import snapshots
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.level_file import write_level
from orchestrator.studies.design.trials import Journal
from orchestrator.views.page import CheckFindings, Views
from tests.cases import LEVEL, case_folder

PVD = '<VTKFile type="Collection"><Collection><DataSet timestep="0" file="{}"/></Collection></VTKFile>'


def test_a_folder_of_own_files_is_admitted_also_by_a_link(tmp_path: Path) -> None:
    (tmp_path / "run/particles").mkdir(parents=True)
    (tmp_path / "run/particles/particles_00000.vtu").touch()
    (tmp_path / "link").symlink_to("run")
    for place in (tmp_path / "run", tmp_path / "link", tmp_path / "nowhere"):
        assert admit(place) == place


@pytest.mark.parametrize(
    "make",
    [
        lambda file: file.symlink_to("/etc/passwd"),
        lambda file: file.symlink_to("nowhere"),
        lambda file: file.symlink_to(".."),
        os.mkfifo,
    ],
    ids=["file", "nowhere", "folder", "pipe"],
)
def test_foreign_things_are_named(tmp_path: Path, make: Callable[[Path], None]) -> None:
    (tmp_path / "checkpoints").mkdir()
    make(tmp_path / "checkpoints/x")
    with pytest.raises(FolderUnusable, match=f"{tmp_path}/checkpoints/x"):
        admit(tmp_path)


def test_of_many_foreign_things_some_are_named(tmp_path: Path) -> None:
    for number in range(40):
        (tmp_path / f"{number:02d}").symlink_to("x")
    with pytest.raises(FolderUnusable, match=r"\b30\b") as refused:
        admit(tmp_path)
    assert str(refused.value).count(str(tmp_path)) == 11  # the folder, and ten of its links


def test_a_large_folder_is_looked_through_quickly_and_a_huge_one_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """2000 files take 1 ms where nothing else runs."""
    (tmp_path / "particles").mkdir()
    for number in range(2_000):
        (tmp_path / f"particles/{number}.vtu").touch()
    began_s = time.process_time()
    admit(tmp_path)
    assert time.process_time() - began_s < 0.1
    monkeypatch.setattr(folders, "MOST_ENTRIES", 1_900)
    with pytest.raises(FolderUnusable, match="more than 1900 files"):
        admit(tmp_path)


def test_a_folder_without_end_is_refused(tmp_path: Path) -> None:
    (tmp_path / "/".join("x" * 30)).mkdir(parents=True)
    with pytest.raises(FolderUnusable):
        admit(tmp_path)


def test_json_is_read_from_files_alone(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "cut").write_text('{"a": [1, 2')
    (tmp_path / "deep").write_text("[" * 200_000)
    (tmp_path / "rather-deep").write_text("[" * 30 + "]" * 30)
    (tmp_path / "bytes").write_bytes(b"\xff")
    for name in ("pipe", "cut", "deep", "rather-deep", "bytes"):
        with pytest.raises(UnreadableFile, match=name):
            read_json(tmp_path / name)
    with pytest.raises(UnreadableFile, match="is not a file"):
        read_json(Path("/dev/zero"))
    (tmp_path / "good").write_text('{"a": [1, 2]}')
    assert read_json(tmp_path / "good") == {"a": [1, 2]}


def _dataset(file: h5py.File) -> None:
    file["a/b"] = np.arange(4.0)


def _link(file: h5py.File) -> None:
    file["a/b"] = h5py.ExternalLink("other.h5", "/x")


def _soft_link(file: h5py.File) -> None:
    file["a/b"] = h5py.SoftLink("/x")


def _raw_data(file: h5py.File) -> None:
    file.create_dataset("a/b", (4,), float, external=[("other.raw", 0, 32)])


def _virtual(file: h5py.File) -> None:
    layout = h5py.VirtualLayout((4,), float)
    layout[:] = h5py.VirtualSource("other.h5", "x", (4,))
    file.create_virtual_dataset("a/b", layout)


@pytest.mark.parametrize("make", [_link, _soft_link, _raw_data, _virtual])
def test_all_of_an_hdf5_file_lies_in_itself(tmp_path: Path, make: Callable[[h5py.File], None]) -> None:
    for name, content in (("own.h5", _dataset), ("foreign.h5", make)):
        with h5py.File(tmp_path / name, "w") as file:
            content(file)
    with open_hdf5(tmp_path / "own.h5") as own:
        assert own["a/b"][:].tolist() == [0.0, 1.0, 2.0, 3.0]
    with pytest.raises(UnreadableFile, match=r"a/b is a link or lies elsewhere"):
        open_hdf5(tmp_path / "foreign.h5")
    os.mkfifo(tmp_path / "pipe.h5")
    with pytest.raises(UnreadableFile, match="is not a file"):
        open_hdf5(tmp_path / "pipe.h5")


@pytest.mark.parametrize("name", ["/dev/stdin", "../other/particles_00000.vtu"])
def test_a_series_names_files_of_its_run_alone(tmp_path: Path, name: str) -> None:
    for file in ("case.toml", "provenance.json"):
        (tmp_path / file).touch()
    (tmp_path / "particles.pvd").write_text(PVD.format(name))
    with pytest.raises(UnreadableBed, match="elsewhere"):
        read_run(tmp_path, None)
    with pytest.raises(UnreadableFile, match="elsewhere"):
        snapshots(tmp_path, "particles")


@pytest.mark.parametrize("text", ["[1]", "{}", "[" * 200_000])
def test_a_damaged_trial_of_a_study_is_refused(tmp_path: Path, text: str) -> None:
    (tmp_path / "0001.trial.json").write_text(text)
    with pytest.raises((FolderUnusable, UnreadableFile), match="0001"):
        Journal(tmp_path).read()


def test_drawings_do_not_follow_links(tmp_path: Path) -> None:
    mine, out = tmp_path / "mine", tmp_path / "machine"
    mine.write_text("mine")
    out.mkdir()
    (out / "side.png").symlink_to(mine)
    views = Views(load_judged(case_folder(tmp_path / "case")))
    with pytest.raises(FolderUnusable, match="is a link"):
        views.write(out, CheckFindings([], []))
    assert mine.read_text() == "mine"


def test_a_planned_level_does_not_follow_links(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.mkdir()
    folder = case_folder(tmp_path / "case", draft=LEVEL)
    (folder / "levels/planned.toml").symlink_to(mine / "planned.toml")  # which does not exist
    loaded = load_judged(folder, "draft")
    with pytest.raises(CaseError, match="outside of the case's folder"):
        write_level(loaded, "planned", [], "planned")
    assert not list(mine.iterdir())
