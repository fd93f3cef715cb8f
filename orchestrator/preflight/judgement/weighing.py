"""The weighing of verdicts against each other, so that only effects beyond doubt may be left out.

An estimate "may be left out" becomes "cannot say" if

- the number is within the estimate's error of the threshold (``Verdict.is_close``), or
- the user asks for the separation, and the effect brings or removes material, or
- it is an effect of frames or panels, whose numbers are of a steady harmonic motion, and the machine may
  move otherwise (``scene/steadiness.py``), or
- the user asks for a peak, or for nothing in particular, and the estimate is another with the strokes on the
  way up to the full speed, or
- another effect of the case would go as well, because it needs this one or because the solver that
  leaves this one out does not know it, and that effect matters or cannot be judged.

An estimate "matters" of an effect that could be left out becomes "cannot say" if

- it estimates the results of other parts than the user asks for, or
- it is within a factor of ``MARGIN`` above the threshold, so that a pair of runs decides
  (``with_doubt``).

Before the weighing, pairs of runs that have measured the changes by an effect replace its estimate.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence, Set
from dataclasses import replace

from orchestrator.case.tables.case import Case
from orchestrator.figures.short_names import is_of_separation, named, part_of
from orchestrator.preflight.judgement.catalogue import (
    EFFECTS,
    Judged,
    all_needs,
    find_also_lost,
    judge_effects,
)
from orchestrator.preflight.judgement.pair import Pair
from orchestrator.preflight.scene.effect import MARGIN, TENTH, Verdict, describe_verdict
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.scene.steadiness import doubt_of_steady_motion, on_the_way_up

OF_MOTION = ("panels", "frames")  # parts whose numbers are of the frames' steady motion
NEAR = f"within a factor of {MARGIN:g} of the threshold"


def weigh_effects(
    case: Case, pairs: Mapping[str, Pair] | None = None, asked: Sequence[str] = ()
) -> dict[str, Judged]:
    """Return the weighed judgements of all effects by name.

    ``pairs`` are the remembered runs by effect, and ``asked`` has the names of the results that count.
    """
    numbers = scene(case)
    judged = judge_effects(case, numbers)
    for name, pair in (pairs or {}).items():
        if name in judged:
            judged[name] = replace(judged[name], verdict=measured_verdict(judged[name].verdict, pair, asked))
    separates = any(is_of_separation(name) for name in asked)
    parts = {part_of(name, case) for name in asked}
    unsteady = doubt_of_steady_motion(numbers)
    rising = (
        on_the_way_up(numbers)
        if not asked or not all(named(name).figure.is_decisive for name in asked)
        else None
    )
    doubted = {}
    for name, effect in judged.items():
        why = _doubt(effect, parts, separates) or _doubt_of_motion(effect, unsteady, rising)
        doubted[name] = _add_doubt(effect, why)
    return {name: _consistent(case, effect, doubted.values()) for name, effect in doubted.items()}


def is_undecided(judged: Judged) -> bool:
    """Return whether only a pair of runs can tell if the case can do without an effect.

    The case has such an effect, keys can leave it out, and no estimate is certain that it matters.
    """
    verdict = judged.verdict
    if verdict.measured or not (judged.present and judged.can_go):
        return False
    return verdict.matters is None or (verdict.matters and not verdict.is_clear)


def with_doubt(judged: Judged) -> Judged:
    """Return the judgement with "cannot say" in place of an uncertain "matters".

    The estimate is uncertain if its error may exceed the distance to the threshold; then a pair of runs
    can decide.
    """
    return _add_doubt(judged, NEAR if is_undecided(judged) and judged.verdict.matters else "")


def measured_verdict(verdict: Verdict, pair: Pair, asked: Sequence[str]) -> Verdict:
    """Return the verdict by the largest change that decides of the results that are asked for.

    Return the given verdict if there are no runs, or neither has such a result.
    """
    changes = pair.changes(asked)
    if not changes:
        return verdict
    verdicts = {change.matters for change in changes.values()}
    matters = True if True in verdicts else None if None in verdicts else False
    deciding = (item for item in changes.items() if item[1].matters is matters)
    name, worst = max(deciding, key=lambda item: item[1].relative or 0.0)
    return replace(
        verdict,
        number=f"change of {name}",
        value=worst.relative,
        threshold=f"{TENTH:g} (two runs)",
        matters=matters,
        why=f"measured: {name} {worst.in_words}",
        limit=TENTH,
        measured=True,
    )


def _add_doubt(judged: Judged, because: str) -> Judged:
    return replace(judged, verdict=judged.verdict.doubted(because)) if because else judged


def _doubt(judged: Judged, parts: Set[str], separates: bool) -> str:
    """Return the reason why an estimate does not decide; "" if it does.

    ``parts`` has the parts to which the results belong that are asked for ("" stands for any part).
    ``separates`` says whether a separation is among these results; a run without feed or removal has
    no separation, however little material comes and goes.
    """
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


def _doubt_of_motion(judged: Judged, unsteady: str, rising: Scene | None) -> str:
    """Return the reason why an estimate "may be left out" does not hold in another motion; "" if it does.

    ``unsteady`` says why the machine may move otherwise than steadily, and ``rising`` is the scene with the
    largest strokes of its run-up.
    """
    if judged.verdict.matters is not False or judged.verdict.measured or judged.part not in OF_MOTION:
        return ""
    if unsteady or rising is None:
        return unsteady
    then = EFFECTS[judged.effect].judge(rising)
    if then is None or (then.matters is False and not then.is_close):
        return ""
    return f"on its way up the machine may come to {then.in_numbers}, and a peak counts"


def _consistent(case: Case, judged: Judged, every: Collection[Judged]) -> Judged:
    """Return the judgement, with "cannot say" if another effect that goes as well may matter.

    A measured verdict includes the effects that go as well, unless a measurement of one contradicts it.
    """
    measured = judged.verdict.measured
    if judged.verdict.matters is not False:
        return judged
    also_lost = find_also_lost(case, judged.effect) if judged.present and judged.can_go else []
    for other in every:
        if measured and not (other.verdict.measured and other.verdict.matters):
            continue
        goes = other.effect in also_lost or judged.effect in all_needs(other.effect)
        if goes and other.present and other.verdict.matters is not False:
            says = describe_verdict(other.verdict.matters)
            return _add_doubt(judged, f"{other.effect} goes with it: {says}")
    return judged
