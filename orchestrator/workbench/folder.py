"""The folder of a study, in which its runs lie and into which it writes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

from orchestrator.case.file.folder import FolderUnusable, admit, read_json
from orchestrator.case.file.whole import write_json, write_text
from orchestrator.output.records.run_folder import study_folder
from orchestrator.output.tables import Cell, write_csv, write_parquet
from orchestrator.views.style import data_uri, fill_template


@dataclass(frozen=True)
class StudyFolder:
    """The folder of a study.  Its files are written whole or not at all, and each call returns the file."""

    path: Path
    known_by: ClassVar[Mapping[str, str]] = {
        "case.toml": "",
        "accuracy.csv": "accuracy",
        "sweep.csv": "sweep job",
        "corners.csv": "corners",
        "paper.csv": "paper",
        "stability.html": "stability",
        "points.csv": "design fit optimise",
    }
    """Files by which the folder of a case, a run or a study is known, each with the studies that write it."""

    def admit(self, study: str = "") -> Path:
        """Return the path.

        Raises FolderUnusable where it holds links, pipes or devices, and where it is the folder of a case, of
        a run or of another ``study``, if that is given.
        """
        admit(self.path)
        for file, studies in self.known_by.items() if study else ():
            if (self.path / file).exists() and study not in studies.split():
                what = f"has {file}, of a case, a run or another study; give another folder with --out"
                raise FolderUnusable(f"{self.path}: {what}")
        return self.path

    def lock(self) -> AbstractContextManager[None]:
        """Make the folder, and keep other studies out of it.  Raises FolderUnusable if one works there."""
        return study_folder(self.path)

    def write_csv(self, name: str, rows: Sequence[Mapping[str, Cell]]) -> Path:
        """Write rows, whose columns may differ, as CSV."""
        return write_csv(rows, self.path / name)

    def write_parquet(self, name: str, rows: Sequence[Mapping[str, Cell]]) -> Path:
        """Write rows as Parquet, whose columns have types."""
        return write_parquet(rows, self.path / name)

    def write_text(self, name: str, text: str) -> Path:
        """Write a text."""
        write_text(self.path / name, text)
        return self.path / name

    def write_json(self, name: str, table: Any) -> Path:
        """Write a table as JSON."""
        write_json(self.path / name, table)
        return self.path / name

    def read_json(self, name: str) -> Any:
        """Return the content of a JSON file.  Raises OSError, and ValueError for another kind of file."""
        return read_json(self.path / name)

    def write_page(self, name: str, template: str, **values: Any) -> Path:
        """Fill a template with values, and write the page.

        ``template`` is its path in ``studies/``; it extends ``studies/page.html`` and may embed the picture
        in a file by ``picture(file)``.
        """
        values["picture"] = lambda image: data_uri(image.read_bytes(), "image/png")
        return self.write_text(name, fill_template(f"studies/{template}", **values))
