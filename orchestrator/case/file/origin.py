"""The origin of a case: everything that it was read from."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchestrator.case.file.base import find_level, read_level
from orchestrator.case.file.nested import leaves

CHEAP_LEVEL = "draft"
"""The level at which a case is tried out if it has a level of this name."""
FILES = (
    *(".stl", ".obj", ".ply", ".vtk", ".msh", ".step", ".stp", ".iges", ".igs", ".dxf"),
    *(".h5", ".csv", ".parquet"),
)
"""Endings of the files that a case may name."""
LONGEST_NAME = 200  # of a file
LAST_STATES = "checkpoints/[0-9]*/bed.h5"
OF_EFFECTS = ("effects", "effects_for")


@dataclass(frozen=True)
class Origin:
    """The origin of a case: its folder, its tables, its level ("" for none) and its overrides.

    ``given`` has the tables of case.toml, laid over those of its bases.
    """

    folder: Path
    given: Mapping[str, Any]
    level: str
    overrides: tuple[str, ...]

    @property
    def others(self) -> tuple[str, ...]:
        """The overrides that do not choose effects."""
        return tuple(text for text in self.overrides if text.partition("=")[0].strip() not in OF_EFFECTS)

    def read(self) -> dict[str, Any]:
        """Read everything that defines the case except its choice of effects.

        The result has tables, overrides, and checksums of the files that these name: files of surfaces,
        tables of particles, and the last state of a run from which particles come.  Raises CaseError for a
        level that cannot be read.
        """
        levels = {
            name: read_level(self.folder, name)[0]
            for name in {self.level, CHEAP_LEVEL} - {""}
            if find_level(self.folder, name).is_file()
        }
        tables = [
            {key: value for key, value in table.items() if key not in OF_EFFECTS}
            for table in (self.given, *levels.values())
        ]
        texts = [value for _, value in leaves([*tables, self.others]) if isinstance(value, str)]
        named = {text.rpartition("=")[2].strip().strip("\"'") for text in texts}  # an override, or a value
        return {
            "level": self.level,
            "given": tables[0],
            "levels": dict(zip(levels, tables[1:], strict=True)),
            "overrides": list(self.others),
            "files": {
                word: hashlib.sha256(file.read_bytes()).hexdigest()
                for word in sorted(named)
                if (file := self._find_file(word)) is not None
            },
        }

    def _find_file(self, word: str) -> Path | None:
        """Return the file that a word of the case names, in its folder or in the working directory.

        The word may be the folder of a run; the file is then the last ``bed.h5`` of its checkpoints.
        """
        if not 0 < len(word) <= LONGEST_NAME:
            return None
        for place in (self.folder / word, Path(word)):
            if word.lower().endswith(FILES) and place.is_file():
                return place
            if beds := sorted(place.glob(LAST_STATES)):
                return beds[-1]
        return None
