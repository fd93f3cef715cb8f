"""Verdicts weighed against each other: what may be left out must be so beyond doubt.

An estimate that says "may be left out" is overruled to "cannot say" where

- it is within its own error of the threshold (``Verdict.is_close``), or
- the separation is asked for, and the effect brings or removes material, or
- something that the case has would go with the effect, as it needs it or as the solver that leaves
  the effect out does not know it, and matters or cannot be judged.

An estimate that says "matters" is overruled to "cannot say" of an effect that could be left out

- where it is an estimate of other parts' results than those that are asked for, and
- within a factor of ``MARGIN`` above the threshold, where a pair of runs decides (``doubted``).

Pairs of runs that have measured what an effect changes take the place of its estimate before.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import replace

from orchestrator.case.scalars import is_of_separation, part_of
from orchestrator.case.tables.case import Case
from orchestrator.preflight.judgement.catalogue import (
    EFFECTS,
    Judged,
    all_needs,
    find_also_lost,
    judge_effects,
)
from orchestrator.preflight.judgement.pair import Change, Pair
from orchestrator.preflight.scene.effect import MARGIN, TENTH, Part, Verdict, describe_verdict


def weigh_effects(
    case: Case, pairs: Mapping[str, Pair] | None = None, asked: Sequence[str] = ()
) -> dict[Part, list[Judged]]:
    """As ``judged``, weighed, with the ``pairs`` that are known, by what results are ``asked``
    for."""
    parts = judge_effects(case)
    by_name = {one.effect: one for rows in parts.values() for one in rows}
    for name, pair in (pairs or {}).items():
        if name in by_name:
            verdict = measured_verdict(by_name[name].verdict, pair, asked)
            by_name[name] = replace(by_name[name], verdict=verdict)
    if any(is_of_separation(name) for name in asked):
        by_name = {name: _separated(one) for name, one in by_name.items()}
    parts_asked = {part_of(name, case) for name in asked}
    by_name = {name: _about(one, parts_asked) for name, one in by_name.items()}
    close = {name: _far_enough(one) for name, one in by_name.items()}
    every = [_consistent(case, one, close.values()) for one in close.values()]
    kept = {one.effect: one for one in every}
    return {part: [kept[one.effect] for one in rows] for part, rows in parts.items()}


def is_undecided(one: Judged) -> bool:
    """Whether only a pair of runs can say if the case can do without the effect: it has it, a key
    takes it out, and no estimate says with certainty that it matters."""
    verdict = one.verdict
    if verdict.measured or not (one.present and one.can_go):
        return False
    return verdict.matters is None or (verdict.matters is True and not is_clear(verdict))


def with_doubt(one: Judged) -> Judged:
    """ "Cannot say" in place of a "matters" that is no further above its threshold than estimates
    err, where a pair of runs can decide."""
    if not is_undecided(one) or one.verdict.matters is None:
        return one
    return _cannot_say(one, f"within a factor of {MARGIN:g} of the threshold")


def is_clear(verdict: Verdict) -> bool:
    """Whether what matters does so beyond the error of its estimate."""
    if verdict.limit is None or verdict.value is None:
        return True
    return verdict.value > MARGIN * verdict.limit


def measured_verdict(verdict: Verdict, pair: Pair, asked: Sequence[str]) -> Verdict:
    """By the largest change of the results that are asked for; as it was where there are no
    runs, or neither has such a result."""
    changes = pair.changes(asked)
    if not changes:
        return verdict
    name, worst = max(changes.items(), key=lambda item: item[1].relative or 0.0)
    verdicts = {one.matters for one in changes.values()}
    matters = True if True in verdicts else None if None in verdicts else False
    return replace(
        verdict,
        number=f"change of {name}",
        value=worst.relative,
        threshold=f"{TENTH:g} (two runs)",
        matters=matters,
        why=f"measured: {name} {_figures(worst)}",
        limit=TENTH,
        measured=True,
    )


def _figures(change: Change) -> str:
    with_it, without = ("none" if one is None else f"{one:.3g}" for one in (change.with_it, change.without))
    chance = "" if change.uncertain is None else f", +- {100 * change.uncertain:.2g} % by chance"
    return f"{with_it} with it, {without} without{chance}"


def _separated(one: Judged) -> Judged:
    """Without what comes and goes a run has no separation to tell of, however little that is."""
    if one.effect not in ("feed", "removal") or one.verdict.matters is not False:
        return one
    return _cannot_say(one, "yet without it there is no separation, which is asked for")


def _about(one: Judged, parts: Set[str]) -> Judged:
    """``parts``: of the results that are asked for; "" stands for any."""
    about = one.verdict.about or EFFECTS[one.effect].about
    if not parts or "" in parts or one.verdict.measured or one.verdict.matters is not True:
        return one
    if not one.present or not one.can_go or not parts.isdisjoint(about):
        return one
    return _cannot_say(one, f"what that changes of the {' and '.join(sorted(parts))} it does not say")


def _cannot_say(one: Judged, because: str) -> Judged:
    why = f"{one.verdict.why}; {because}"
    return replace(one, verdict=replace(one.verdict, matters=None, why=why))


def _far_enough(one: Judged) -> Judged:
    verdict = one.verdict
    if verdict.matters is not False or not verdict.is_close:
        return one
    return _cannot_say(one, f"within a factor of {MARGIN:g} of the threshold")


def _consistent(case: Case, one: Judged, every: Collection[Judged]) -> Judged:
    """What is measured speaks for all that goes with it, but against another measurement."""
    if one.verdict.matters is not False:
        return one
    along = find_also_lost(case, one.effect) if one.present and one.can_go else []
    for other in every:
        goes = other.effect in along or one.effect in all_needs(other.effect)
        if one.verdict.measured and not (other.verdict.measured and other.verdict.matters):
            continue
        if goes and other.present and other.verdict.matters is not False:
            why = f"{other.effect} goes with it: {describe_verdict(other.verdict.matters)}"
            return _cannot_say(one, why)
    return one
