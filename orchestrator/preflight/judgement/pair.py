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
from orchestrator.preflight.scene.effect import TENTH


@dataclass(frozen=True)
class Change:
    """The change of one result: ``with_it`` and ``without`` the effect; ``relative`` is the size of their
    difference over the value with the effect (infinite where only one run has the result), None
    where neither run has it or both values are too small to be resolved; ``uncertain`` is half the
    width of its interval, None where the runs give none."""

    with_it: float | None
    without: float | None
    relative: float | None
    uncertain: float | None = None

    @property
    def matters(self) -> bool | None:
        """Whether it is more than a tenth; None where there is no change, or chance decides."""
        if self.relative is None:
            return None
        chance = self.uncertain or 0.0
        if self.relative - chance > TENTH:
            return True
        return False if self.relative + chance <= TENTH else None

    @property
    def in_words(self) -> str:
        """Both values, and what is by chance."""
        values = ("none" if value is None else f"{value:.3g}" for value in (self.with_it, self.without))
        chance = "" if self.uncertain is None else f", +- {100 * self.uncertain:.2g} % by chance"
        return "{} with it, {} without".format(*values) + chance


@dataclass(frozen=True)
class Pair:
    """Two runs of a case at a cheap level, with and without an effect; ``refused`` says why there are
    none ("": there are).

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
        """Return the change of a result by its name (``case/scalars.py``); None without runs."""
        if self.summary_with is None or self.summary_without is None:
            return None
        asked = scalar(name)
        return compute_change(asked.of(self.summary_with), asked.of(self.summary_without), asked.floor)

    def changes(self, names: Sequence[str]) -> dict[str, Change]:
        """Return the changes of those results that the runs have, by name."""
        every = {name: self.change(name) for name in names}
        return {name: each for name, each in every.items() if each and each.relative is not None}


def compute_change(with_it: Value | None, without: Value | None, floor: float) -> Change:
    """Return the change of a result, which is too small to be resolved below ``floor``; a result that
    one run alone has has changed by all of it."""
    if with_it is None or without is None:
        one, other = (None if value is None else value.value for value in (with_it, without))
        return Change(one, other, None if with_it is without else math.inf)
    if max(abs(with_it.value), abs(without.value)) < floor:
        return Change(with_it.value, without.value, None)
    by = max(abs(with_it.value), floor)
    uncertain = None
    if with_it.half_width is not None and without.half_width is not None:
        uncertain = math.hypot(with_it.half_width, without.half_width) / by
    return Change(with_it.value, without.value, abs(without.value - with_it.value) / by, uncertain)


def _memory() -> Path:
    """Return the folder of all pairs."""
    home = Path(os.getenv("XDG_CACHE_HOME") or Path.home() / ".cache")
    return home / "flipflow" / "pairs"


@cache
def _program() -> str:
    """Return what computes: other versions may find other values."""
    from orchestrator.case.provenance import commit, versions  # loads much, and is rarely asked

    return json.dumps([commit(), versions()], sort_keys=True)


def key_of(read: Mapping[str, Any], effect: str) -> str:
    """Return the checksum by which a pair is found again; ``read`` is all that the case was read from
    (``case/file/layers.py``)."""
    text = json.dumps([_program(), read, effect], sort_keys=True, default=str)
    return hashlib.sha256(text.encode()).hexdigest()[:32]


_AGREED: dict[str, Pair | None] = {}


def share_pairs(by_key: Mapping[str, Pair | None]) -> None:
    """Remember these pairs from now on, whatever this process's own memory has: processes that run
    one case together must choose alike."""
    _AGREED.update(by_key)


def recall(key: str) -> Pair | None:
    """Return the pair of a key; None where it is not known, or its file is no pair."""
    if key in _AGREED:
        return _AGREED[key]
    try:
        table = json.loads((_memory() / f"{key}.json").read_text(encoding="utf-8"))
        return Pair(**(table | {"sets": tuple(table["sets"])}))
    except (OSError, ValueError, TypeError, KeyError):
        return None


def remember(key: str, pair: Pair) -> None:
    """Write a pair whole or not at all; where nothing can be written, it is asked again another time."""
    with suppress(OSError):
        folder = _memory()
        folder.mkdir(parents=True, exist_ok=True)
        aside = folder / f".{key}.{os.getpid()}"
        aside.write_text(json.dumps(asdict(pair)), encoding="utf-8")
        aside.replace(folder / f"{key}.json")
