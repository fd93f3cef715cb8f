"""What a case was read from, and a checksum of it."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchestrator.case.file.toml_file import read_toml

CHEAP_LEVEL = "draft"
"""The level at which a case is tried out, where it has one of this name."""
OF_EFFECTS = ("effects", "effects_for")


@dataclass(frozen=True)
class Origin:
    """``given`` is the table of case.toml, ``level`` "" for none, ``overrides`` are ``--set``'s."""

    folder: Path
    given: Mapping[str, Any]
    level: str
    overrides: tuple[str, ...]

    @property
    def others(self) -> tuple[str, ...]:
        """``overrides`` without those that choose effects."""
        return tuple(one for one in self.overrides if one.partition("=")[0].strip() not in OF_EFFECTS)

    def read(self) -> dict[str, Any]:
        """All that decides what the case is, but for which effects are chosen: tables, overrides,
        and checksums of the other files in the folder that it names.  Raises CaseError."""
        levels = {
            name: read_toml(file, self.folder)
            for name in {self.level, CHEAP_LEVEL} - {""}
            if (file := self.folder / "levels" / f"{name}.toml").is_file()
        }
        tables = [_without_effects(one) for one in (self.given, *levels.values())]
        named = {word for table in [*tables, *self.others] for word in _words(table)}
        return {
            "level": self.level,
            "given": tables[0],
            "levels": dict(zip(levels, tables[1:], strict=True)),
            "overrides": list(self.others),
            "files": {
                word: hashlib.sha256(file.read_bytes()).hexdigest()
                for word in sorted(named)
                if word.endswith((".stl", ".h5")) and (file := self.folder / word).is_file()
            },
        }


def _without_effects(table: Mapping[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in OF_EFFECTS}


def _words(value: Any) -> set[str]:
    """All strings in a table, and the value of an override."""
    if isinstance(value, Mapping):
        return {word for inner in value.values() for word in _words(inner)}
    if isinstance(value, list | tuple):
        return {word for inner in value for word in _words(inner)}
    return {value.rpartition("=")[2].strip().strip("\"'")} if isinstance(value, str) else set()
