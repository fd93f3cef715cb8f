"""All effects that there are: every file in ``orchestrator/preflight/effects`` is one, and so is every
entry point of an installed package in the group ``flipflow.effects``."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, fields
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules

from orchestrator.case.tables.case import Case, absent
from orchestrator.preflight import effects
from orchestrator.preflight.scene.effect import PARTS, Effect, Part, Verdict, has_part
from orchestrator.preflight.scene.observed import Observed
from orchestrator.preflight.scene.scene import scene


def _find_effects() -> dict[str, Effect]:
    """Return every effect by its name: those in ``effects``, then those of installed packages."""
    by_name: dict[str, Effect] = {}
    for module in iter_modules(effects.__path__):
        effect = import_module(f"{effects.__name__}.{module.name}").EFFECT
        by_name[module.name.replace("_", "-")] = effect
    by_name |= {point.name: point.load() for point in entry_points(group="flipflow.effects")}
    checkable = {"", *(field.name for field in fields(Observed))}
    for name, effect in by_name.items():
        assert isinstance(effect, Effect), f"{name} is no Effect"
        assert effect.checked_by in checkable, f"{name}: a run does not tell {effect.checked_by}"
    return by_name


EFFECTS = _find_effects()
FLAT = ("frames", "panel", "particles", "exchange")
"""Tables of the case that have no tables in them: solvers and hand-overs."""


@dataclass(frozen=True)
class Judged:
    """An effect in one scene: ``present`` says whether the case has it, ``can_go`` whether keys of the
    case can still leave it out."""

    effect: str
    part: Part
    key: str
    present: bool
    can_go: bool
    verdict: Verdict

    @property
    def lacking(self) -> bool:
        """Whether it matters, and the case does not have it."""
        return self.verdict.matters is True and not self.present

    @property
    def spare(self) -> bool:
        """Whether the case has it, could do without, and a key takes it out."""
        return self.verdict.matters is False and self.present and bool(self.key)


def judge_effects(case: Case) -> dict[str, Judged]:
    """Return what is said of each effect, part by part; nothing of particles and panels where there
    are none.  For a case whose tables fit together (``find_table_problems``)."""
    numbers, judged = scene(case), {}
    for name, effect in sorted(EFFECTS.items(), key=lambda item: PARTS.index(item[1].part)):
        verdict = effect.judge(numbers) if has_part(case, effect.part) else None
        if verdict is not None:
            present, can_go = has_effect(case, name), can_leave_out(case, name)
            judged[name] = Judged(name, effect.part, effect.key, present, can_go, verdict)
    return judged


def can_leave_out(case: Case, name: str) -> bool:
    """Return whether keys of the case leave it out that do not do so yet: neither it nor, with another
    value of the same key, something that it needs."""
    gone = any(why_left_out(case, effect) for effect in (name, *all_needs(name)))
    return bool(EFFECTS[name].overlay(case)) and not gone


def find_dispensable(every: Iterable[Judged]) -> list[str]:
    """Return the effects that may be left out, by keys of the case."""
    return [one.effect for one in every if one.can_go and one.verdict.matters is False]


def with_dependents(names: Collection[str], why: str) -> dict[str, str]:
    """Return these, and all that needs one of them: name -> why."""
    reasons = dict.fromkeys(names, why)
    for name in EFFECTS:
        if need := next((need for need in all_needs(name) if need in names), None):
            reasons[name] = f"it needs {need}, which is left out"
    return reasons


def all_needs(name: str) -> Iterator[str]:
    """Yield all effects without which this is nothing."""
    for need in EFFECTS[name].needs:
        yield need
        yield from all_needs(need)


def has_effect(case: Case, name: str) -> bool:
    """Return whether the case describes it and nothing leaves it out, nor what it needs."""
    effect = EFFECTS[name]
    there = effect.is_described(case) and not why_left_out(case, name)
    return there and all(has_effect(case, one) for one in effect.needs)


def find_also_lost(case: Case, name: str) -> list[str]:
    """Return what else the case loses with an effect although it does not need it: solvers that leave
    out the one may not know the other."""
    flat = {
        table: getattr(case, table).model_copy(update=dict(keys))
        for table, keys in EFFECTS[name].overlay(case).items()
        if table in FLAT
    }
    without = case.model_copy(update=flat)
    others = (one for one in EFFECTS if one != name and name not in all_needs(one))
    return [one for one in others if has_effect(case, one) and not has_effect(without, one)]


def find_left_out(case: Case) -> dict[str, str]:
    """Return what solvers and other settings leave out of this case: name -> why."""
    reasons = {name: why_left_out(case, name) for name in EFFECTS}
    return {name: why for name, why in reasons.items() if why}


def why_left_out(case: Case, name: str) -> str:
    """Return why settings leave an effect out, or a solver one that the case describes; "" if none
    does."""
    effect = EFFECTS[name]
    if why := effect.left_out(case):
        return why
    for port, adapter in case.adapters.items():
        instead = adapter.leaves_out.get(name)
        if instead is not None and effect.is_described(case):
            return f"{port}.solver {getattr(case, port).solver}: {instead}"
    return ""


def find_left_out_by_level(bare: Case, at_level: Case) -> dict[str, str]:
    """Return what the level leaves out of the bare case."""
    before, after = absent(bare) | find_left_out(bare), absent(at_level) | find_left_out(at_level)
    reasons = {name: why for name, why in after.items() if name not in before}
    for name, effect in EFFECTS.items():
        if effect.overlay(bare) and effect.is_described(bare) and not effect.described(at_level):
            reasons.setdefault(name, "nothing in the case describes it any more")
    return reasons
