"""Pairs of short runs, with and without an effect, and which effects are worth them.

They serve ``effects = "auto"`` before a run and ``flipflow explain --for``.  The case is taken at its
level "draft" if it has one that still has the effect, and made cheaper still by settings that do not
bear on the effect.  Both runs are commands of their own.  A run that a pair shares with another is
made once.
"""

from __future__ import annotations

import json
import math
import resource
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from orchestrator.case import solvers
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.layers import CHEAP_LEVEL
from orchestrator.case.load import level_names
from orchestrator.case.playback import turning
from orchestrator.case.scalars import SCALARS
from orchestrator.case.tables.case import Case
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.output.records.trust import DOUBTFUL, doubts, is_trusted
from orchestrator.ports.clock import exact
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.cost import particles_at_start, predicted_s
from orchestrator.preflight.judge import JudgedCase, known_pairs, load_judged
from orchestrator.preflight.judgement.catalogue import (
    EFFECTS,
    Judged,
    can_leave_out,
    has_effect,
    with_dependents,
)
from orchestrator.preflight.judgement.pair import Pair, key_of, recall, remember
from orchestrator.preflight.judgement.weighing import is_undecided, weigh_effects
from orchestrator.preflight.scene.effect import describe_verdict
from orchestrator.studies.points import RunFailed, run_in_scratch, sample_s

LIMIT_S = 30.0
"""Processor time that one run of a pair may take, as it is predicted."""
PATIENCE = 10.0
"""A run that takes this many times the limit in wall time is ended: prediction errs by a factor of
three, and the processor may be busy with other work."""
RUNS_IN_BUDGET = 4
"""Of ``flipflow explain --for``, each as long as is allowed: three at least say something."""
FEWEST_CYCLES = 6
"""Of the machine, after its run-up: half of the cycles are looked at."""
STRIP_CELLS = 16
ACROSS = "variation-across"
MIDDLE = "flipflow-middle-of"
AUTO = "effects=auto"

Say = Callable[[str], None]


class NoPair(Exception):
    """The runs cannot be made, or cannot be relied upon; the message says why."""


@dataclass
class Pairs:
    """Makes pairs, remembers them, and shares runs among them.

    ``limit_s``: processor time that a run may take as predicted; ``say`` gets a line before each
    run; ``forget`` asks again for what is remembered.  ``spent_s``: processor time of all runs so
    far, also of those that came to nothing.
    """

    limit_s: float = LIMIT_S
    say: Say = lambda line: None
    forget: bool = False
    spent_s: float = field(default=0.0, init=False)
    _runs: dict[str, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Files may have changed since another engine read them."""
        _load.cache_clear()
        _predicted_s.cache_clear()

    def of(self, loaded: JudgedCase, effect: str) -> Pair:
        """The pair of a case and an effect that it has, from memory if it is known."""
        found = key_of(loaded.origin.read(), effect)
        known = None if self.forget else recall(found)
        if known is not None and not (known.refused and known.limit_s < self.limit_s):
            return known
        try:
            pair = self._made(loaded, effect)
        except NoPair as why:
            pair = Pair(effect, refused=str(why), limit_s=self.limit_s)
        remember(found, pair)
        return pair

    def _made(self, loaded: JudgedCase, effect: str) -> Pair:
        path, (level, sets) = loaded.folder, _cheap(loaded, effect, self.limit_s)
        every = [*_present(path, level, sets)]
        kept = [one for one in every if one not in with_dependents([effect], "")]
        with_it = self._summary(path, level, (*sets, _named(every)), f"{loaded.name} as it is")
        without = self._summary(path, level, (*sets, _named(kept)), f"{loaded.name} without {effect}")
        used_s = with_it["processor_s"] + without["processor_s"]
        return Pair(effect, level, sets, "", used_s, self.limit_s, with_it, without)

    def _summary(self, path: Path, level: str, sets: tuple[str, ...], what: str) -> dict[str, Any]:
        """Of the run of a case with ``sets``.  Raises NoPair."""
        loaded = _load(path, level, sets)
        if wrong := find_problems(loaded):
            raise NoPair(f"{what} cannot be run: {wrong[0]}")
        same = json.dumps([resolved_case(loaded), str(path)], sort_keys=True, default=str)
        if same not in self._runs:
            cost_s = _predicted_s(path, level, sets)
            self.say(f"trial run: {what}, {loaded.case.duration_s:g} s, about {cost_s:.0f} s")
            began_s = _of_children_s()
            try:
                self._runs[same] = _run(path, level, sets, PATIENCE * self.limit_s, what)
            finally:
                self.spent_s += _of_children_s() - began_s
        return self._runs[same]


def _of_children_s() -> float:
    """Processor time of all processes that this one has waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _run(path: Path, level: str, sets: tuple[str, ...], patience_s: float, what: str) -> dict[str, Any]:
    """Returns the summary of a run in a folder that is gone afterwards.  Raises NoPair."""
    try:
        summary = run_in_scratch(path, level, sets, patience_s)
    except RunFailed as why:
        raise NoPair(f"{what} {why}") from None
    if not _is_usable(summary):
        reasons = [summary.get("reason", ""), *summary.get("doubts", [])]
        raise NoPair(f"{what} ended {summary['status']}: {'; '.join(filter(None, reasons))}")
    return summary


def _is_usable(summary: dict[str, Any]) -> bool:
    """Whether a run is to be trusted, but for what the pair left out on purpose."""
    state: str = summary["status"]
    of_effects_alone = state == DOUBTFUL and not doubts(summary | {"effects": {}})
    return is_trusted(state) or of_effects_alone


def _cheap(loaded: JudgedCase, effect: str, limit_s: float) -> tuple[str, tuple[str, ...]]:
    """Level and ``--set``s at which the pair is run.  Raises NoPair."""
    origin, reasons = loaded.origin, [f"the case does not have {effect}"]
    levels = [name for name in (CHEAP_LEVEL,) if name in level_names(loaded.folder)]
    for level in dict.fromkeys([*levels, loaded.level]):
        for cheaper in (True, False):
            try:
                return level, _sets(loaded.folder, level, origin.others, effect, limit_s, cheaper)
            except NoPair as why:
                reasons.append(str(why))
            except CaseError as error:
                reasons.append(str(error.problems[0]))
    raise NoPair(reasons[-1])


def _sets(
    folder: Path, level: str, others: tuple[str, ...], effect: str, limit_s: float, cheaper: bool
) -> tuple[str, ...]:
    """Raises NoPair and CaseError."""
    case = _described(folder, level, others).case
    if not (has_effect(case, effect) and can_leave_out(case, effect)):
        raise NoPair(f"{effect} cannot be left out of the case at level {level or 'none'}")
    sets = (*others, *_watched(case))
    if cheaper:
        sets = (*sets, *_cheaper_panels(case, effect))
    every = (*sets, _named(_present(folder, level, sets)))
    found = _load(folder, level, every)
    if wrong := find_problems(found):
        raise NoPair(str(wrong[0]))
    if not has_effect(found.case, effect):
        raise NoPair(f"{effect} is gone with cheaper panels")
    return (*sets, *_shorter(found.case, _predicted_s(folder, level, every), limit_s))


def _described(folder: Path, level: str, sets: tuple[str, ...]) -> JudgedCase:
    """With all that the case describes, whatever its key ``effects`` says: nothing asks in turn."""
    return _load(folder, level, (*sets, _named(_present(folder, level, sets))))


@lru_cache(maxsize=256)
def _load(folder: Path, level: str, sets: tuple[str, ...]) -> JudgedCase:
    """As ``load``; pairs of many effects ask for the same cases."""
    return load_judged(folder, level, sets)


def _present(folder: Path, level: str, sets: tuple[str, ...]) -> Iterator[str]:
    case = _load(folder, level, (*sets, AUTO)).described
    return (name for name in EFFECTS if has_effect(case, name))


def _named(effects: Iterable[str]) -> str:
    return f"effects={json.dumps([*effects])}"


def _watched(case: Case) -> Iterator[str]:
    """What a short run writes: rows often enough, a probe on a panel, and nothing else."""
    yield "output.pictures=false"
    yield "checkpoint.wall_min=0.0"
    yield f"output.series_s={float(sample_s(case.coupling.sync_interval_s))!r}"
    panels = single_panels(case)
    if panels and not any(probe.panel for probe in case.probes.values()):
        panel = panels[len(panels) // 2].name
        yield f'probes.{MIDDLE}={{panel="{panel}", at=[0.5, 0.5]}}'


def _cheaper_panels(case: Case, effect: str) -> Iterator[str]:
    if effect != ACROSS and case.panel.adapter.varies_across:
        narrow = solvers.without("panel", ACROSS)
        cells = f"panel.cells=[{min(STRIP_CELLS, max(2, case.panel.cells[0]))}, 1]"
        yield from (f"panel.solver={narrow}", "panel.integrator=explicit", "panel.step_s=0.0", cells)


@lru_cache(maxsize=256)
def _predicted_s(folder: Path, level: str, sets: tuple[str, ...]) -> float:
    case = _load(folder, level, sets).case
    return predicted_s(case, particles_at_start(case))


def _shorter(case: Case, cost_s: float, limit_s: float) -> Iterator[str]:
    """Nothing where the case is within the limit; else as long as the limit allows, of whole output
    intervals, if enough cycles of the machine are in it.  Raises NoPair."""
    if cost_s <= limit_s:
        return
    machine = turning(case)
    fewest_s = 0.0
    if machine is not None:
        cycle_s = 2 * math.pi / machine.speed_rad_per_s
        fewest_s = machine.start_s + machine.run_up_s + FEWEST_CYCLES * cycle_s
    every = exact(case.output.interval_s)
    wanted_s = case.duration_s * limit_s / cost_s
    duration_s = float(max(1, int(wanted_s / every)) * every)
    if duration_s < fewest_s:
        least_s = cost_s * float(math.ceil(fewest_s / every) * every) / case.duration_s
        budget_s = math.ceil(RUNS_IN_BUDGET * least_s)
        raise NoPair(
            f"a trial run takes about {least_s:.0f} s, more than the {limit_s:g} s allowed "
            f"(flipflow explain CASE --for ... --budget {budget_s} allows it)"
        )
    yield f"duration_s={duration_s!r}"


BUDGET_S = 300.0
"""Processor time for all trial runs of a case together."""
WORTH = 4
"""Times the processor time that a trial run may take: from here on a run is long enough for trials
before it."""


@dataclass(frozen=True)
class TriedEffects:
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
    open_ones = [one for one in there if is_undecided(one)]
    others = [one for one in there if one.verdict.matters is True and one not in open_ones]
    return [one.effect for group in (open_ones, others) for one in sorted(group, key=_over)]


def _over(one: Judged) -> float:
    verdict = one.verdict
    if verdict.value is None:
        return math.inf
    return verdict.value / (verdict.limit or 1.0)


def tried(loaded: JudgedCase, effects: Sequence[str], pairs: Pairs, budget_s: float) -> TriedEffects:
    """The pairs of effects in turn, until the budget is used; what is remembered costs nothing."""
    found = known_pairs(loaded.origin, effects)
    omitted = []
    for name in effects:
        if pairs.spent_s < budget_s:
            found[name] = pairs.of(loaded, name)
        elif name not in found or found[name].refused:
            omitted.append(name)
    return TriedEffects(found, tuple(omitted), pairs.spent_s)


def for_results(loaded: JudgedCase, pairs: Pairs, budget_s: float) -> TriedEffects:
    """Of all effects of the case that a pair could decide about."""
    every = [one for rows in weigh_effects(loaded.described).values() for one in rows]
    return tried(loaded, ranked(every), pairs, budget_s)


def wanted_before(loaded: JudgedCase) -> tuple[str, ...]:
    """Effects that "auto" tries out before a run of this case: those that it cannot decide about
    and that would save time, if the run is long enough; none that are known already."""
    names = loaded.choice.undecided
    if not names:
        return ()
    cost_s = predicted_s(loaded.case, particles_at_start(loaded.case))
    return names if cost_s >= WORTH * LIMIT_S else ()


def before(loaded: JudgedCase, say: Say) -> dict[str, Pair]:
    """Tries them out; what came of it is remembered, so that the case loaded again has it."""
    names = wanted_before(loaded)
    if names:
        say(
            f'effects = "auto" cannot decide about {", ".join(names)}: short runs with and without '
            f"each, at most {BUDGET_S:g} s of processor time"
        )
    found = tried(loaded, names, Pairs(LIMIT_S, say), BUDGET_S).pairs
    asked = loaded.choice.asked or (*SCALARS,)
    rows = (one for rows in weigh_effects(loaded.described, found, asked).values() for one in rows)
    verdicts = {one.effect: one.verdict for one in rows}
    for name, pair in found.items():
        if pair.refused:
            say(f"{name} stays, as there are no runs to tell: {pair.refused}")
        else:
            say(f"{name}: {describe_verdict(verdicts[name].matters)}: {verdicts[name].why}")
    return found
