"""A case run with and without an effect: what that changed, and the memory of it.

The memory is a folder in the user's cache, never in the case's: a pair is found again by a
checksum of all that the case was read from, the effect, and the version of this program.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

from orchestrator.case.scalars import Value, scalar

TENTH = 0.1


@dataclass(frozen=True)
class Change:
    """Of one result: ``with_it`` and ``without`` the effect; ``relative`` is the size of their
    difference over the value with the effect (infinite where only one run has the result), None
    where neither run has it or both values are too small to be resolved; ``uncertain`` is half the
    width of its interval, None where the runs give none."""

    with_it: float | None
    without: float | None
    relative: float | None
    uncertain: float | None = None

    @property
    def matters(self) -> bool | None:
        """By a tenth, where chance does not decide; None else."""
        if self.relative is None:
            return None
        chance = self.uncertain or 0.0
        if self.relative - chance > TENTH:
            return True
        return False if self.relative + chance <= TENTH else None


@dataclass(frozen=True)
class Pair:
    """Two runs of a case at a cheap level; ``refused`` says why there are none ("": there are).

    ``summary_with`` and ``summary_without`` are theirs; ``processor_s`` is of both together;
    ``level`` and ``sets`` say how the case was made cheap, ``limit_s`` what a run was allowed.
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
        """Of a result by its name (``case/scalars.py``); None without runs."""
        if self.summary_with is None or self.summary_without is None:
            return None
        asked = scalar(name)
        return compute_change(asked.of(self.summary_with), asked.of(self.summary_without), asked.floor)

    def changes(self, names: Sequence[str]) -> dict[str, Change]:
        """Of those results that the runs have, by name."""
        found = {name: self.change(name) for name in names}
        return {name: one for name, one in found.items() if one and one.relative is not None}


def compute_change(one: Value | None, two: Value | None, floor: float) -> Change:
    """From ``one`` with the effect to ``two`` without; a result that one run alone has has changed
    by all of it."""
    if one is None and two is None:
        return Change(None, None, None)
    if one is None or two is None:
        found, lost = (each.value if each is not None else None for each in (one, two))
        return Change(found, lost, math.inf)
    if max(abs(one.value), abs(two.value)) < floor:
        return Change(one.value, two.value, None)
    by = max(abs(one.value), floor)
    widths = [each.half_width for each in (one, two) if each.half_width is not None]
    uncertain = math.hypot(*widths) / by if len(widths) == 2 else None
    return Change(one.value, two.value, abs(two.value - one.value) / by, uncertain)


def memory() -> Path:
    """The folder of all pairs."""
    home = Path(os.getenv("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "flipflow" / "pairs"


@cache
def _program() -> str:
    """What computes: other versions may find other values."""
    from orchestrator.case.provenance import commit, versions  # loads much, and is rarely asked

    return json.dumps([commit(), versions()], sort_keys=True)


def key_of(read: Mapping[str, Any], effect: str) -> str:
    """``read``: all that the case was read from (``case/file/layers.py``)."""
    text = json.dumps([_program(), read, effect], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


_AGREED: dict[str, Pair | None] = {}


def share_pairs(found: Mapping[str, Pair | None]) -> None:
    """From now on, this process remembers these pairs by their keys, whatever its own memory has:
    processes that run one case together must choose alike."""
    _AGREED.update(found)


def recall(found: str) -> Pair | None:
    """The pair of a key; None where it is not known, or its file is no pair."""
    if found in _AGREED:
        return _AGREED[found]
    try:
        table = json.loads((memory() / f"{found}.json").read_text(encoding="utf-8"))
        return Pair(**(table | {"sets": tuple(table["sets"])}))
    except (OSError, ValueError, TypeError, KeyError):
        return None


def remember(found: str, pair: Pair) -> None:
    """Whole or not at all; where nothing can be written, it is asked again another time."""
    with suppress(OSError):
        folder = memory()
        folder.mkdir(parents=True, exist_ok=True)
        aside = folder / f".{found}.{os.getpid()}"
        aside.write_text(json.dumps(asdict(pair)), encoding="utf-8")
        aside.replace(folder / f"{found}.json")
