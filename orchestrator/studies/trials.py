"""Which effects are worth a pair of runs, in which order, and for how long.

For ``effects = "auto"`` before a run, and for ``flipflow explain --for``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from orchestrator.case.scalars import SCALARS
from orchestrator.preflight.cost import particles_at_start, predicted_s
from orchestrator.preflight.effect_choice import known_pairs
from orchestrator.preflight.judgement.catalogue import Judged
from orchestrator.preflight.judgement.pair import Pair
from orchestrator.preflight.judgement.weighing import undecided, weighed
from orchestrator.preflight.levels import LoadedCase
from orchestrator.preflight.scene.effect import in_words
from orchestrator.studies.paired import LIMIT_S, Pairs, Say

BUDGET_S = 300.0
"""Processor time for all trial runs of a case together."""
WORTH = 4
"""Times the processor time that a trial run may take: from here on a run is long enough for trials
before it."""


@dataclass(frozen=True)
class Asked:
    """Pairs that were made or remembered, effects for which the budget did not last, and the
    processor time that was spent."""

    pairs: dict[str, Pair]
    omitted: tuple[str, ...] = ()
    spent_s: float = 0.0


def ranked(every: Sequence[Judged]) -> list[str]:
    """Effects to be tried, those first of which estimates say least that they matter: what cannot
    be judged, then what matters, from the lowest value over its threshold up.  Not among them is
    what surely may be left out."""
    there = [one for one in every if one.present and one.can_go]
    open_ones = [one for one in there if undecided(one)]
    others = [one for one in there if one.verdict.matters is True and one not in open_ones]
    return [one.effect for group in (open_ones, others) for one in sorted(group, key=_over)]


def _over(one: Judged) -> float:
    verdict = one.verdict
    if verdict.value is None:
        return math.inf
    return verdict.value / (verdict.limit or 1.0)


def tried(loaded: LoadedCase, effects: Sequence[str], pairs: Pairs, budget_s: float) -> Asked:
    """The pairs of effects in turn, until the budget is used; what is remembered costs nothing."""
    found = known_pairs(loaded.origin, effects)
    omitted = []
    for name in effects:
        if pairs.spent_s < budget_s:
            found[name] = pairs.of(loaded, name)
        elif name not in found or found[name].refused:
            omitted.append(name)
    return Asked(found, tuple(omitted), pairs.spent_s)


def for_results(loaded: LoadedCase, pairs: Pairs, budget_s: float) -> Asked:
    """Of all effects of the case that a pair could decide about."""
    every = [one for rows in weighed(loaded.described).values() for one in rows]
    return tried(loaded, ranked(every), pairs, budget_s)


def wanted_before(loaded: LoadedCase) -> tuple[str, ...]:
    """Effects that "auto" tries out before a run of this case: those that it cannot decide about
    and that would save time, if the run is long enough; none that are known already."""
    names = loaded.choice.undecided
    if not names:
        return ()
    cost_s = predicted_s(loaded.case, particles_at_start(loaded.case))
    return names if cost_s >= WORTH * LIMIT_S else ()


def before(loaded: LoadedCase, say: Say) -> dict[str, Pair]:
    """Tries them out; what came of it is remembered, so that the case loaded again has it."""
    names = wanted_before(loaded)
    if names:
        say(
            f'effects = "auto" cannot decide about {", ".join(names)}: short runs with and without '
            f"each, at most {BUDGET_S:g} s of processor time"
        )
    found = tried(loaded, names, Pairs(LIMIT_S, say), BUDGET_S).pairs
    asked = loaded.choice.asked or (*SCALARS,)
    rows = (one for rows in weighed(loaded.described, found, asked).values() for one in rows)
    verdicts = {one.effect: one.verdict for one in rows}
    for name, pair in found.items():
        if pair.refused:
            say(f"{name} stays, as there are no runs to tell: {pair.refused}")
        else:
            say(f"{name}: {in_words(verdicts[name].matters)}: {verdicts[name].why}")
    return found
