"""Pairs of short runs, with and without an effect, and the choice of the effects that are worth a pair.

Pairs serve ``effects = "auto"`` before a run and ``flipflow explain --for``.  The case is run at its level
"draft" if it has such a level and the effect is still in it.  Settings that do not bear on the effect make it
cheaper still.  Both runs are commands of their own.  A run that two pairs share is made once.
"""

from __future__ import annotations

import json
import math
import resource
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any

from orchestrator.case import solvers
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.base import level_names
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.origin import CHEAP_LEVEL
from orchestrator.case.tables.case import Case
from orchestrator.case.turning import turning
from orchestrator.figures.short_names import SHORT_NAMES
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.output.records.trust import DOUBTFUL, doubts, is_trusted
from orchestrator.ports.clock import exact, sample_s
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
from orchestrator.run.trials.scratch import NoResult, run_in_scratch

LIMIT_S = 30.0
"""The largest predicted processor time of one run of a pair before a run with ``effects = "auto"``."""
PATIENCE = 10.0
"""The multiple of the limit, in wall time, after which a run is ended: predictions err by a factor of three,
and the processor may be busy with other work."""
RUNS_IN_BUDGET = 4
"""The number of runs in the budget of ``flipflow explain --for``, each as long as its share allows: three
runs already say something."""
FEWEST_CYCLES = 6
"""The least number of the machine's cycles after its run-up: half of them are evaluated."""
STRIP_CELLS = 16
ACROSS = "variation-across"
MIDDLE = "flipflow-middle-of"
AUTO = "effects=auto"

Say = Callable[[str], None]
Sets = tuple[str, ...]


class NoPair(Exception):
    """An error of a pair whose runs cannot be made, or cannot be relied upon; the message says why."""


class BudgetUsed(Exception):
    """The end of a budget: the next run would take more than is left of it."""


@dataclass
class Pairs:
    """A maker of pairs that remembers them and shares runs among them.

    ``limit_s`` is the largest predicted processor time of a run, and ``budget_s`` that of all runs together.
    ``say`` gets a line before each run.  ``forget`` ignores the remembered results.  ``spent_s`` is the
    processor time of all runs so far, also of runs that failed.
    """

    limit_s: float = LIMIT_S
    say: Say = lambda line: None
    forget: bool = False
    budget_s: float = math.inf
    spent_s: float = field(default=0.0, init=False)
    _made: dict[str, dict[str, Any]] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Clear the caches, since files may have changed after another object filled them."""
        _load.cache_clear()
        _predicted_s.cache_clear()

    def of(self, loaded: JudgedCase, effect: str) -> Pair:
        """Return the pair of a case and one of its effects, from memory if the pair is known.

        Raises BudgetUsed.
        """
        key = key_of(loaded.origin.read(), effect)
        known = None if self.forget else recall(key)
        if known is not None and not (known.refused and known.limit_s < self.limit_s):
            return known
        try:
            pair = self._make(loaded, effect)
        except NoPair as why:
            pair = Pair(effect, refused=str(why), limit_s=self.limit_s)
        remember(key, pair)
        return pair

    def cheapest(self, loaded: JudgedCase, effects: Sequence[str]) -> list[str]:
        """Return the effect without which a run is the cheapest, alone in a list; [] if none can be run."""
        costs_s = {}
        for effect in effects:
            with suppress(NoPair, CaseError):
                level, _, without = self._runs(loaded, effect)
                costs_s[effect] = _predicted_s(loaded.folder, level, without)
        return sorted(costs_s, key=lambda effect: costs_s[effect])[:1]

    def _runs(self, loaded: JudgedCase, effect: str) -> tuple[str, Sets, Sets]:
        """Return the level, and the overlays of the runs with and without an effect.  Raises NoPair."""
        level, sets = _cheap(loaded, effect, self.limit_s)
        present, removed = _present(loaded.folder, level, sets), with_dependents([effect], "")
        remaining = [name for name in present if name not in removed]
        return level, (*sets, _with_effects(present)), (*sets, _with_effects(remaining))

    def _make(self, loaded: JudgedCase, effect: str) -> Pair:
        level, *runs = self._runs(loaded, effect)
        sets = runs[0][:-1]
        with_it, without = (
            self._summary(loaded.folder, level, each, f"{loaded.name} {what}")
            for each, what in zip(runs, ("as it is", f"without {effect}"), strict=True)
        )
        used_s = with_it["processor_s"] + without["processor_s"]
        return Pair(effect, level, sets, "", used_s, self.limit_s, with_it, without)

    def _summary(self, folder: Path, level: str, sets: Sets, what: str) -> dict[str, Any]:
        """Return the summary of the run of a case with ``sets``.  Raises NoPair and BudgetUsed."""
        loaded = _load(folder, level, sets)
        if problems := find_problems(loaded):
            raise NoPair(f"{what} cannot be run: {problems[0]}")
        key = json.dumps([resolved_case(loaded), str(folder)], sort_keys=True, default=str)
        if key not in self._made:
            cost_s, left_s = _predicted_s(folder, level, sets), self.budget_s - self.spent_s
            if cost_s > left_s:
                raise BudgetUsed
            self.say(f"trial run: {what}, {loaded.case.duration_s:g} s, about {cost_s:.0f} s")
            began_s = _processor_time_of_children_s()
            try:
                self._made[key] = _run(folder, level, sets, PATIENCE * self.limit_s, left_s, what)
            finally:
                self.spent_s += _processor_time_of_children_s() - began_s
        return self._made[key]


def _processor_time_of_children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _run(
    folder: Path, level: str, sets: Sets, patience_s: float, processor_s: float, what: str
) -> dict[str, Any]:
    """Return the summary of a run that is trustworthy apart from the deliberate omissions of the pair.

    Raises NoPair.
    """
    try:
        summary = run_in_scratch(folder, level, sets, patience_s, processor_s)
    except NoResult as why:
        raise NoPair(f"{what} {why}") from None
    state = str(summary["status"])
    if is_trusted(state) or (state == DOUBTFUL and not doubts(summary | {"effects": {}})):
        return summary
    reasons = [summary.get("reason", ""), *summary.get("doubts", [])]
    raise NoPair(f"{what} ended {state}: {'; '.join(filter(None, reasons))}")


def _cheap(loaded: JudgedCase, effect: str, limit_s: float) -> tuple[str, Sets]:
    """Return the level and the overlays with which the pair is run.  Raises NoPair."""
    why = f"the case does not have {effect}"
    levels = [name for name in (CHEAP_LEVEL,) if name in level_names(loaded.folder)]
    for level in dict.fromkeys([*levels, loaded.level]):
        for cheaper in (True, False):
            try:
                return level, _sets(loaded, level, effect, limit_s, cheaper)
            except NoPair as error:
                why = str(error)
            except CaseError as error:
                why = str(error.problems[0])
    raise NoPair(why)


def _sets(loaded: JudgedCase, level: str, effect: str, limit_s: float, cheaper: bool) -> Sets:
    """Return the overlays of the pair.  Raises NoPair and CaseError."""
    folder, sets = loaded.folder, loaded.origin.others
    # with all described effects: a case whose key ``effects`` is "auto" would ask for pairs in turn
    case = _load(folder, level, (*sets, _with_effects(_present(folder, level, sets)))).case
    if not (has_effect(case, effect) and can_leave_out(case, effect)):
        raise NoPair(f"{effect} cannot be left out of the case at level {level or 'none'}")
    sets = (*sets, *_output_sets(case))
    if cheaper and effect != ACROSS and case.panel.adapter.varies_across:
        narrow = solvers.name_without("panel", ACROSS)
        cells = f"panel.cells=[{min(STRIP_CELLS, max(2, case.panel.cells[0]))}, 1]"
        sets = (*sets, f"panel.solver={narrow}", "panel.integrator=explicit", "panel.step_s=0.0", cells)
    every = (*sets, _with_effects(_present(folder, level, sets)))
    trial = _load(folder, level, every)
    if problems := find_problems(trial):
        raise NoPair(str(problems[0]))
    if not has_effect(trial.case, effect):
        raise NoPair(f"{effect} is gone with cheaper panels")
    cost_s = _predicted_s(folder, level, every)
    return sets if cost_s <= limit_s else (*sets, _shorter(trial.case, cost_s, limit_s))


@lru_cache(maxsize=256)
def _load(folder: Path, level: str, sets: Sets) -> JudgedCase:
    """Return the case that ``load_judged`` returns; pairs of many effects load the same cases."""
    return load_judged(folder, level, sets)


def _present(folder: Path, level: str, sets: Sets) -> list[str]:
    case = _load(folder, level, (*sets, AUTO)).described
    return [name for name in EFFECTS if has_effect(case, name)]


def _with_effects(names: Sequence[str]) -> str:
    return f"effects={json.dumps(names)}"


@lru_cache(maxsize=256)
def _predicted_s(folder: Path, level: str, sets: Sets) -> float:
    case = _load(folder, level, sets).case
    return predicted_s(case, particles_at_start(case))


def _output_sets(case: Case) -> Iterator[str]:
    """Yield the overlays for the output of a short run: frequent rows and a probe on a panel alone."""
    yield "output.pictures=false"
    yield "checkpoint.wall_min=0.0"
    yield f"output.series_s={float(sample_s(case.coupling.sync_interval_s))!r}"
    panels = single_panels(case)
    if panels and not any(probe.panel for probe in case.probes.values()):
        panel = panels[len(panels) // 2].name
        yield f'probes.{MIDDLE}={{panel="{panel}", at=[0.5, 0.5]}}'


def _shorter(case: Case, cost_s: float, limit_s: float) -> str:
    """Return the overlay of the longest duration, in whole output intervals, that the limit allows.

    Raises NoPair if the duration has too few cycles of the machine.
    """
    machine = turning(case)
    fewest_s = 0.0
    if machine is not None:
        cycle_s = 2 * math.pi / machine.speed_rad_per_s
        fewest_s = machine.start_s + machine.run_up_s + FEWEST_CYCLES * cycle_s
    every = exact(case.output.interval_s)
    duration_s = float(max(1, int(case.duration_s * limit_s / cost_s / every)) * every)
    if duration_s < fewest_s:
        least_s = cost_s * float(math.ceil(fewest_s / every) * every) / case.duration_s
        budget_s = math.ceil(RUNS_IN_BUDGET * least_s)
        raise NoPair(
            f"a trial run takes about {least_s:.0f} s, more than the {limit_s:g} s allowed "
            f"(flipflow explain CASE --for ... --budget {budget_s} allows it)"
        )
    return f"duration_s={duration_s!r}"


BUDGET_S = 300.0
"""The processor time for all trial runs of a case together."""
WORTH = 4
"""The multiple of a trial run's limit from which on a run is long enough for trials before it."""


@dataclass(frozen=True)
class TriedEffects:
    """The pairs that were made or remembered, and the cost of making them.

    ``omitted`` are the effects for which the budget did not last; ``spent_s`` is the processor time of the
    runs.
    """

    pairs: dict[str, Pair]
    omitted: tuple[str, ...] = ()
    spent_s: float = 0.0


def rank_effects(judged: Sequence[Judged]) -> list[str]:
    """Return the effects to be tried, in ascending order of their estimated weight.

    Effects that cannot be judged come first.  Effects that matter follow, in ascending order of their value
    over its threshold.  Effects that may surely be left out are omitted.
    """

    def place(each: Judged) -> tuple[bool, float]:
        value = each.verdict.value
        over = math.inf if value is None else value / (each.verdict.limit or 1.0)
        return not is_undecided(each), over

    open_to_trial = [
        each
        for each in judged
        if each.present and each.can_go and (is_undecided(each) or each.verdict.matters is True)
    ]
    return [each.effect for each in sorted(open_to_trial, key=place)]


def try_effects(loaded: JudgedCase, effects: Sequence[str], pairs: Pairs) -> TriedEffects:
    """Make the pairs of effects in turn, except those for which the budget does not last, and return them.

    Remembered pairs cost nothing.
    """
    tried = known_pairs(loaded.origin, effects)
    omitted = []
    for name in effects:
        try:
            tried[name] = pairs.of(loaded, name)
        except BudgetUsed:
            if name not in tried or tried[name].refused:
                omitted.append(name)
    return TriedEffects(tried, tuple(omitted), pairs.spent_s)


def try_all_effects(loaded: JudgedCase, pairs: Pairs) -> TriedEffects:
    """Make and return the pairs of all effects of the case about which a pair could decide.

    The cheapest of the effects that may surely be left out comes first, to test the estimates.
    """
    judged = list(weigh_effects(loaded.described).values())
    spare = [each.effect for each in judged if each.present and each.can_go and each.verdict.matters is False]
    return try_effects(loaded, [*pairs.cheapest(loaded, spare), *rank_effects(judged)], pairs)


def effects_to_try(loaded: JudgedCase) -> tuple[str, ...]:
    """Return the effects that "auto" tries out before a run of this case.

    They are the effects about which "auto" cannot decide and which would save time.  Effects whose pairs are
    known are omitted.  There are none if the run is too short to be worth trials.
    """
    names = loaded.choice.undecided
    if not names:
        return ()
    cost_s = predicted_s(loaded.case, particles_at_start(loaded.case))
    return names if cost_s >= WORTH * LIMIT_S else ()


def try_before_run(loaded: JudgedCase, say: Say) -> dict[str, Pair]:
    """Try effects out before a run, and return their pairs.

    The pairs are remembered, so that a case that is loaded again has them.
    """
    names = effects_to_try(loaded)
    if names:
        say(
            f'effects = "auto" cannot decide about {", ".join(names)}: short runs with and without '
            f"each, at most {BUDGET_S:g} s of processor time"
        )
    pairs = try_effects(loaded, names, Pairs(LIMIT_S, say, budget_s=BUDGET_S)).pairs
    asked = loaded.choice.asked or (*SHORT_NAMES,)
    judged = weigh_effects(loaded.described, pairs, asked)
    for name, pair in pairs.items():
        if pair.refused:
            say(f"{name} stays, as there are no runs to tell: {pair.refused}")
        else:
            say(f"{name}: {describe_verdict(judged[name].verdict.matters)}: {judged[name].verdict.why}")
    return pairs
