"""Verdicts weighed against each other: what may be left out must be so beyond doubt.

An estimate that says "may be left out" is overruled to "cannot say" where

- it is within its own error of the threshold (``Verdict.is_close``), or
- the separation is asked for, and the effect brings or removes material, or
- something that the case has would go with the effect, as it needs it or as the solver that leaves
  the effect out does not know it, and matters or cannot be judged.

An estimate that says "matters" is overruled to "cannot say" of an effect that could be left out

- where it is an estimate of other parts' results than those that are asked for, and
- within a factor of ``MARGIN`` above the threshold, where a pair of runs decides (``with_doubt``).

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
from orchestrator.preflight.judgement.pair import Pair
from orchestrator.preflight.scene.effect import MARGIN, TENTH, Verdict, describe_verdict

NEAR = f"within a factor of {MARGIN:g} of the threshold"


def weigh_effects(
    case: Case, pairs: Mapping[str, Pair] | None = None, asked: Sequence[str] = ()
) -> dict[str, Judged]:
    """Return the effects as ``judge_effects`` does, weighed, with the ``pairs`` that are known, by the
    results that are ``asked`` for."""
    judged = judge_effects(case)
    for name, pair in (pairs or {}).items():
        if name in judged:
            judged[name] = replace(judged[name], verdict=measured_verdict(judged[name].verdict, pair, asked))
    separates = any(is_of_separation(name) for name in asked)
    parts = {part_of(name, case) for name in asked}
    doubted = {name: _doubted(one, _doubt(one, parts, separates)) for name, one in judged.items()}
    return {name: _consistent(case, one, doubted.values()) for name, one in doubted.items()}


def is_undecided(judged: Judged) -> bool:
    """Return whether only a pair of runs can say if the case can do without the effect: it has it, a
    key takes it out, and no estimate says with certainty that it matters."""
    verdict = judged.verdict
    if verdict.measured or not (judged.present and judged.can_go):
        return False
    return verdict.matters is None or (verdict.matters and not verdict.is_clear)


def with_doubt(judged: Judged) -> Judged:
    """Return "cannot say" in place of a "matters" that is no further above its threshold than
    estimates err, where a pair of runs can decide."""
    return _doubted(judged, NEAR if is_undecided(judged) and judged.verdict.matters else "")


def measured_verdict(verdict: Verdict, pair: Pair, asked: Sequence[str]) -> Verdict:
    """Return the verdict by the largest change of the results that are asked for; as it was where
    there are no runs, or neither has such a result."""
    changes = pair.changes(asked)
    if not changes:
        return verdict
    name, worst = max(changes.items(), key=lambda item: item[1].relative or 0.0)
    verdicts = {change.matters for change in changes.values()}
    return replace(
        verdict,
        number=f"change of {name}",
        value=worst.relative,
        threshold=f"{TENTH:g} (two runs)",
        matters=True if True in verdicts else None if None in verdicts else False,
        why=f"measured: {name} {worst.in_words}",
        limit=TENTH,
        measured=True,
    )


def _doubted(judged: Judged, because: str) -> Judged:
    return replace(judged, verdict=judged.verdict.doubted(because)) if because else judged


def _doubt(judged: Judged, parts: Set[str], separates: bool) -> str:
    """Return why an estimate does not decide, "" where it does.

    ``parts`` are those of the results that are asked for ("" stands for any), ``separates`` says
    whether a separation is among these: without what comes and goes a run has none to tell of,
    however little that is."""
    verdict = judged.verdict
    if verdict.matters is False:
        if separates and judged.effect in ("feed", "removal"):
            return "yet without it there is no separation, which is asked for"
        return NEAR if verdict.is_close else ""
    stays = verdict.measured or not (judged.present and judged.can_go)
    about = verdict.about or EFFECTS[judged.effect].about
    if stays or not verdict.matters or not parts or "" in parts or not parts.isdisjoint(about):
        return ""
    return f"what that changes of the {' and '.join(sorted(parts))} it does not say"


def _consistent(case: Case, judged: Judged, every: Collection[Judged]) -> Judged:
    """Return "cannot say" where what goes with the effect may matter; what is measured speaks for all
    that goes with it, but against another measurement."""
    measured = judged.verdict.measured
    if judged.verdict.matters is not False:
        return judged
    along = find_also_lost(case, judged.effect) if judged.present and judged.can_go else []
    for other in every:
        if measured and not (other.verdict.measured and other.verdict.matters):
            continue
        goes = other.effect in along or judged.effect in all_needs(other.effect)
        if goes and other.present and other.verdict.matters is not False:
            says = describe_verdict(other.verdict.matters)
            return _doubted(judged, f"{other.effect} goes with it: {says}")
    return judged
