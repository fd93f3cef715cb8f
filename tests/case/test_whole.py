"""The things that a file may take the place of."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from orchestrator.case.file.whole import written_whole
from orchestrator.output.records.run_folder import write_page


def test_a_file_takes_the_place_of_a_file_only(tmp_path: Path) -> None:
    """A device or a pipe would be replaced by a file of its name."""
    pipe, folder, file = tmp_path / "pipe", tmp_path / "folder", tmp_path / "file"
    os.mkfifo(pipe)
    folder.mkdir()
    file.write_text("old")
    for target in (pipe, folder):
        with pytest.raises(OSError, match="exists already and is not a file"), written_whole(target):
            pass
    with written_whole(file) as aside:
        aside.write_text("new")
    assert file.read_text() == "new"
    assert pipe.is_fifo()
    assert sorted(tmp_path.iterdir()) == [file, folder, pipe]


def test_nothing_beside_a_file_is_followed(tmp_path: Path) -> None:
    """Nobody can foresee the name that is written to, and a link in the file's place is replaced."""
    mine, file = tmp_path / "mine", tmp_path / "file"
    mine.write_text("mine")
    for link in (file, tmp_path / ".file"):
        link.symlink_to(mine)
    names = []
    for _ in range(2):
        with written_whole(file) as aside:
            names.append(aside.name)
            assert aside.is_file()
            aside.write_text("new")
    assert len({*names, ".file"}) == 3
    assert mine.read_text() == "mine"
    assert file.read_text() == "new"
    assert not file.is_symlink()
    assert sorted(tmp_path.iterdir()) == [tmp_path / ".file", file, mine]


def test_a_page_takes_the_place_of_a_page_only(tmp_path: Path) -> None:
    case, page = tmp_path / "case.toml", tmp_path / "page.html"
    case.write_text("title = 'mine'")
    with pytest.raises(OSError, match="is not a page"):
        write_page(case, "<html>")
    assert case.read_text() == "title = 'mine'"
    for text in ("<html>", "<html></html>"):
        write_page(page, text)
        assert page.read_text() == text
