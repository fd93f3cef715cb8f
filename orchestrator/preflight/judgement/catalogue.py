"""All effects that there are: every file in ``orchestrator/preflight/effects`` is one, and so is every
entry point of an installed package in the group ``flipflow.effects``."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import get_args

from orchestrator.case.tables.case import Case, absent, has_particles
from orchestrator.preflight import effects
from orchestrator.preflight.scene.effect import Effect, Part, Verdict
from orchestrator.preflight.scene.scene import scene


def _find_effects() -> dict[str, Effect]:
    """Return every effect by its name: those in ``effects``, then those of installed packages."""
    found: dict[str, Effect] = {}
    for module in iter_modules(effects.__path__):
        effect = import_module(f"{effects.__name__}.{module.name}").EFFECT
        found[module.name.replace("_", "-")] = effect
    found |= {point.name: point.load() for point in entry_points(group="flipflow.effects")}
    assert all(isinstance(effect, Effect) for effect in found.values())
    return found


EFFECTS = _find_effects()
FLAT = ("frames", "panel", "particles", "exchange")
"""Tables of the case that have no tables in them: solvers and hand-overs."""


@dataclass(frozen=True)
class Judged:
    """An effect in one scene.  ``present``: whether the case has it; ``can_go``: whether keys of
    the case can still leave it out."""

    effect: str
    key: str
    present: bool
    can_go: bool
    verdict: Verdict

    @property
    def lacking(self) -> bool:
        """It matters, and the case does not have it."""
        return self.verdict.matters is True and not self.present

    @property
    def spare(self) -> bool:
        """The case has it, could do without, and a key takes it out."""
        return self.verdict.matters is False and self.present and bool(self.key)


def judge_effects(case: Case) -> dict[Part, list[Judged]]:
    """By part; particles and panels are empty where there are none.  For a case whose tables fit
    together (``checks.find_table_problems``)."""
    there: dict[Part, bool] = {
        "particles": has_particles(case),
        "panels": bool(case.screen.panels),
        "frames": True,
        "machine": True,
    }
    numbers = scene(case)
    found: dict[Part, list[Judged]] = {part: [] for part in get_args(Part)}
    for name, effect in EFFECTS.items():
        verdict = effect.judge(numbers) if there[effect.part] else None
        if verdict is not None:
            one = Judged(name, effect.key, has_effect(case, name), can_leave_out(case, name), verdict)
            found[effect.part].append(one)
    return found


def can_leave_out(case: Case, name: str) -> bool:
    """Whether keys of the case leave it out that do not do so yet: neither it nor, with another
    value of the same key, something that it needs."""
    gone = any(why_left_out(case, effect) for effect in (name, *all_needs(name)))
    return bool(EFFECTS[name].overlay(case)) and not gone


def find_dispensable(every: Iterable[Judged]) -> list[str]:
    """What may be left out, by keys of the case."""
    return [one.effect for one in every if one.can_go and one.verdict.matters is False]


def with_dependents(names: Collection[str], why: str) -> dict[str, str]:
    """These, and all that needs one of them: name -> why."""
    found = dict.fromkeys(names, why)
    for name in EFFECTS:
        if need := next((need for need in all_needs(name) if need in names), None):
            found[name] = f"it needs {need}, which is left out"
    return found


def all_needs(name: str) -> Iterator[str]:
    """All effects without which this is nothing."""
    for need in EFFECTS[name].needs:
        yield need
        yield from all_needs(need)


def has_effect(case: Case, name: str) -> bool:
    """Whether the case describes it and nothing leaves it out, nor what it needs."""
    effect = EFFECTS[name]
    there = effect.is_described(case) and not why_left_out(case, name)
    return there and all(has_effect(case, one) for one in effect.needs)


def find_also_lost(case: Case, name: str) -> list[str]:
    """What else the case loses with an effect although it does not need it: solvers that leave out
    the one may not know the other."""
    flat = {
        table: getattr(case, table).model_copy(update=dict(keys))
        for table, keys in EFFECTS[name].overlay(case).items()
        if table in FLAT
    }
    without = case.model_copy(update=flat)
    others = (one for one in EFFECTS if one != name and name not in all_needs(one))
    return [one for one in others if has_effect(case, one) and not has_effect(without, one)]


def find_left_out(case: Case) -> dict[str, str]:
    """What solvers and other settings leave out of this case: name -> why."""
    reasons = {name: why_left_out(case, name) for name in EFFECTS}
    return {name: why for name, why in reasons.items() if why}


def why_left_out(case: Case, name: str) -> str:
    """Why settings leave an effect out, or a solver one that the case describes; "" if none does."""
    effect = EFFECTS[name]
    if why := effect.left_out(case):
        return why
    for port, adapter in case.adapters.items():
        instead = adapter.leaves_out.get(name)
        if instead is not None and effect.is_described(case):
            return f"{port}.solver {getattr(case, port).solver}: {instead}"
    return ""


def find_left_out_by_level(bare: Case, at_level: Case) -> dict[str, str]:
    """What the level leaves out of the bare case."""
    before, after = absent(bare) | find_left_out(bare), absent(at_level) | find_left_out(at_level)
    found = {name: why for name, why in after.items() if name not in before}
    for name, effect in EFFECTS.items():
        if effect.overlay(bare) and effect.is_described(bare) and not effect.described(at_level):
            found.setdefault(name, "nothing in the case describes it any more")
    return found
