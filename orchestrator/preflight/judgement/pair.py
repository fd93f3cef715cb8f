"""Pairs of runs of a case with and without an effect, the changes of their results, and their memory.

The memory is a folder in the user's cache, never in the case's folder.  The key of a pair is a
checksum of everything that the case was read from, of the effect, and of the version of this program.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from orchestrator.case.file.whole import write_text
from orchestrator.figures.short_names import Value, named
from orchestrator.preflight.scene.effect import TENTH


@dataclass(frozen=True)
class Change:
    """The change of one result by an effect.

    ``with_it`` and ``without`` are its values with and without the effect.  ``relative`` is the size of
    their difference over the value with the effect.  It is infinite if only one run has the result, and
    None if neither has it or both values are too small to be resolved.  ``uncertain`` is half the width
    of its confidence interval, None if the runs give none.  ``by_chance`` says that chance
    changes the result, too, and the runs do not tell by how much.
    """

    with_it: float | None
    without: float | None
    relative: float | None
    uncertain: float | None = None
    by_chance: bool = False

    @property
    def matters(self) -> bool | None:
        """Whether the change is more than a tenth; None if it is unknown, or chance decides."""
        if self.relative is None:
            return None
        chance = self.uncertain or 0.0
        if self.relative - chance > TENTH:
            return True
        hidden = self.by_chance and self.relative > 0
        return False if self.relative + chance <= TENTH and not hidden else None

    @property
    def in_words(self) -> str:
        """The two values and the uncertainty as text."""
        values = ("none" if value is None else f"{value:.3g}" for value in (self.with_it, self.without))
        chance = ", chance unknown" if self.by_chance else ""
        if self.uncertain is not None:
            chance = f", +- {100 * self.uncertain:.2g} % by chance"
        return "{} with it, {} without".format(*values) + chance


@dataclass(frozen=True)
class Pair:
    """Two runs of a case at a cheap level, with and without an effect.

    ``refused`` says why there are no runs, and is "" if there are.  ``level`` and ``sets`` say how the
    case was made cheap.  ``processor_s`` is the time of both runs together, and ``limit_s`` the allowed
    time of one.  ``summary_with`` and ``summary_without`` are the summaries of the runs.
    """

    effect: str
    level: str = ""
    sets: tuple[str, ...] = ()
    refused: str = ""
    processor_s: float = 0.0
    limit_s: float = 0.0
    summary_with: Mapping[str, Any] | None = None
    summary_without: Mapping[str, Any] | None = None

    def change(self, name: str) -> Change | None:
        """Return the change of a result by its name in ``figures/short_names.py``; None without runs."""
        if self.summary_with is None or self.summary_without is None:
            return None
        asked = named(name)
        of_particles = asked.figure.part == "particles"
        change = compute_change(
            asked.of(self.summary_with), asked.of(self.summary_without), asked.figure.floor
        )
        return replace(change, by_chance=change.uncertain is None and of_particles)

    def changes(self, names: Sequence[str]) -> dict[str, Change]:
        """Return the changes of the named results that the runs have, by name."""
        changes = {name: self.change(name) for name in names}
        return {name: change for name, change in changes.items() if change and change.relative is not None}


def compute_change(with_it: Value | None, without: Value | None, floor: float) -> Change:
    """Return the change of a result, which cannot be resolved below ``floor``.

    If only one run has the result, the relative change is infinite.
    """
    if with_it is None or without is None:
        values = [None if value is None else value.value for value in (with_it, without)]
        return Change(values[0], values[1], None if with_it is without else math.inf)
    if max(abs(with_it.value), abs(without.value)) < floor:
        return Change(with_it.value, without.value, None)
    by = max(abs(with_it.value), floor)
    uncertain = None
    if with_it.half_width is not None and without.half_width is not None:
        uncertain = math.hypot(with_it.half_width, without.half_width) / by
    return Change(with_it.value, without.value, abs(without.value - with_it.value) / by, uncertain)


def _memory() -> Path:
    home = Path(os.getenv("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "flipflow" / "pairs"


@cache
def _program() -> str:
    """Return the versions of all programs that compute; other versions may compute other values."""
    from orchestrator.case.provenance import commit, versions  # this import is slow and rarely needed

    return json.dumps([commit(), versions()], sort_keys=True)


def key_of(read: Mapping[str, Any], effect: str) -> str:
    """Return the checksum by which a pair is stored; ``read`` has all sources of the case."""
    text = json.dumps([_program(), read, effect], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


_AGREED: dict[str, Pair | None] = {}


def share_pairs(by_key: Mapping[str, Pair | None]) -> None:
    """Use these pairs from now on instead of those in the memory.

    Processes that run one case together must make the same choice.
    """
    _AGREED.update(by_key)


def recall(key: str) -> Pair | None:
    """Return the remembered pair of a key; None if there is none, or its file is damaged."""
    if key in _AGREED:
        return _AGREED[key]
    try:
        table = json.loads((_memory() / f"{key}.json").read_text(encoding="utf-8"))
        return Pair(**(table | {"sets": tuple(table["sets"])}))
    except (OSError, ValueError, TypeError, KeyError):
        return None


def remember(key: str, pair: Pair) -> None:
    """Write a pair to the memory, whole or not at all.

    If nothing can be written, a later run makes the pair again.
    """
    with suppress(OSError):
        folder = _memory()
        folder.mkdir(parents=True, exist_ok=True)
        write_text(folder / f"{key}.json", json.dumps(asdict(pair)))
