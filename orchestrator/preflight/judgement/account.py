"""The account of a run's effects: before the run from the case, and after it from the records."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from orchestrator.case.tables.case import Case
from orchestrator.preflight.judgement.pair import Pair
from orchestrator.preflight.judgement.weighing import weigh_effects
from orchestrator.preflight.scene.effect import Verdict, describe_verdict


@dataclass(frozen=True)
class Entry:
    """The account of one effect.

    ``left_out`` is the reason why the effect is left out, "" if it is not.  ``before`` is None if the
    case allows no verdict, and ``after`` is None if the run does not tell.
    """

    left_out: str
    present: bool
    before: Verdict | None = None
    after: Verdict | None = None

    @property
    def is_crossed(self) -> bool:
        """Whether the run contradicts the estimate; it cannot contradict what two runs have measured."""
        if self.before is None or self.after is None or self.before.measured:
            return False
        return {self.before.matters, self.after.matters} == {True, False}

    def figures(self) -> dict[str, Any]:
        """Return the entry as a table of ``summary.json``."""
        return {
            "left_out": self.left_out,
            "present": self.present,
            "before": _figures(self.before),
            "after": _figures(self.after),
            "crossed": self.is_crossed,
        }


def account(
    described: Case,
    left_out: Mapping[str, str],
    pairs: Mapping[str, Pair] | None = None,
    asked: Sequence[str] = (),
) -> dict[str, Entry]:
    """Return the entries of all effects by name.

    ``described`` is the case with all that it describes, and ``left_out`` maps the effects that are
    left out of it to the reasons.  ``pairs`` of runs with and without an effect tell how it changes the
    results ``asked`` for.
    """
    entries = {}
    for name, judged in weigh_effects(described, pairs, asked).items():
        why = left_out.get(name, "")
        entries[name] = Entry(why, judged.present and not why, judged.verdict)
    return entries | {name: Entry(why, False) for name, why in left_out.items() if name not in entries}


def recall(entries: Mapping[str, Entry], saved: Mapping[str, Mapping[str, Any]]) -> dict[str, Entry]:
    """Return the entries of a run that goes on, with what it left out at its start.

    The case in a run's folder no longer has the tables of effects that were left out by taking tables away.
    ``saved`` are the figures of the entries of all effects that were left out.
    """
    return {**entries, **{name: _entry(figures) for name, figures in saved.items()}}


def _entry(figures: Mapping[str, Any]) -> Entry:
    before = figures["before"]
    return Entry(figures["left_out"], figures["present"], None if before is None else Verdict(**before))


def lines_at_start(entries: Mapping[str, Entry]) -> Iterator[str]:
    """Yield a line for each effect that is left out, with the reason and the estimate."""
    for name, entry in entries.items():
        if entry.left_out:
            estimate = ""
            if entry.before is not None:
                whether = " whether it matters" if entry.before.matters is None else ""
                estimate = f"; {describe_verdict(entry.before.matters)}{whether}: {entry.before.in_numbers}"
            yield f"left out: {name}: {entry.left_out}{estimate}"


def lines_at_end(entries: Mapping[str, Entry]) -> Iterator[str]:
    """Yield the deciding numbers, by the run, of the effects that were left out.

    Yield a warning as well for each number on the other side of its threshold.
    """
    for name, entry in entries.items():
        if not entry.left_out or entry.before is None:
            continue
        if entry.after is None:
            yield f"left out: {name}; the run does not tell what it would have changed"
            continue
        yield f"left out: {name}; by the run {entry.after.in_numbers}"
        if entry.is_crossed:
            yield (
                f"WARNING: {name}, which is left out, {describe_verdict(entry.after.matters)} by the run; "
                f"the estimate before it was {entry.before.value_in_words}"
            )


def _figures(verdict: Verdict | None) -> dict[str, Any] | None:
    if verdict is None:
        return None
    names = ("number", "value", "threshold", "matters", "measured", "why")
    figures = {name: getattr(verdict, name) for name in names}
    return figures | {"value": None} if verdict.value == math.inf else figures
