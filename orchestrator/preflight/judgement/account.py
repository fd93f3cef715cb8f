"""What is said of the effects of a run: before it from the case, after it from what it recorded."""

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
    """One effect: ``left_out`` says why it is ("": it is not); ``before`` is None where nothing
    can be said of it, ``after`` where the run does not tell."""

    left_out: str
    present: bool
    before: Verdict | None = None
    after: Verdict | None = None

    @property
    def crossed(self) -> bool:
        """Whether the run says otherwise than the estimate; what two runs measured stands."""
        if self.before is None or self.after is None or self.before.measured:
            return False
        return {self.before.matters, self.after.matters} == {True, False}

    def figures(self) -> dict[str, Any]:
        """For ``summary.json``."""
        return {
            "left_out": self.left_out,
            "present": self.present,
            "before": _figures(self.before),
            "after": _figures(self.after),
            "crossed": self.crossed,
        }


def account(
    described: Case,
    left_out: Mapping[str, str],
    pairs: Mapping[str, Pair] | None = None,
    asked: Sequence[str] = (),
) -> dict[str, Entry]:
    """Of all effects, from the case with all that it describes, and those left out of it.
    ``pairs`` of runs with and without an effect say what results ``asked`` for they change."""
    found = {}
    for one in (one for rows in weigh_effects(described, pairs, asked).values() for one in rows):
        why = left_out.get(one.effect, "")
        found[one.effect] = Entry(why, one.present and not why, one.verdict)
    others = {name: Entry(why, False) for name, why in left_out.items() if name not in found}
    return found | others


def at_start(entries: Mapping[str, Entry]) -> Iterator[str]:
    """What is left out, and why."""
    for name, one in entries.items():
        if one.left_out:
            number = f"; {_said(one.before)}" if one.before else ""
            yield f"left out: {name}: {one.left_out}{number}"


def at_end(entries: Mapping[str, Entry]) -> Iterator[str]:
    """The deciding numbers again of what was left out, where the run has them, and warnings where
    they are on the other side of their thresholds."""
    for name, one in entries.items():
        if not one.left_out or one.before is None:
            continue
        if one.after is None:
            yield f"left out: {name}; the run does not tell what it would have changed"
            continue
        yield f"left out: {name}; by the run {one.after.in_numbers}"
        if one.crossed:
            yield (
                f"WARNING: {name}, which is left out, {describe_verdict(one.after.matters)} by the run; "
                f"the estimate before it was {one.before.value_in_words}"
            )


def _said(verdict: Verdict) -> str:
    return f"{describe_verdict(verdict.matters)}: {verdict.in_numbers}"


def _figures(verdict: Verdict | None) -> dict[str, Any] | None:
    if verdict is None:
        return None
    return {
        "number": verdict.number,
        "value": None if verdict.value is None or math.isinf(verdict.value) else verdict.value,
        "threshold": verdict.threshold,
        "matters": verdict.matters,
        "measured": verdict.measured,
        "why": verdict.why,
    }
