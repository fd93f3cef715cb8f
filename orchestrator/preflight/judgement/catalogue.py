"""The catalogue of all effects.

Every file in ``orchestrator/preflight/effects`` is an effect, and so is every entry point of an
installed package in the group ``flipflow.effects``.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass, fields
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules

from orchestrator.case.tables.case import Case, missing_features
from orchestrator.preflight import effects
from orchestrator.preflight.scene.effect import PARTS, Effect, Part, Verdict, has_part
from orchestrator.preflight.scene.observed import Observed
from orchestrator.preflight.scene.scene import Scene, scene


def _find_effects() -> dict[str, Effect]:
    """Return every effect by its name, first the project's own and then those of installed packages."""
    by_name: dict[str, Effect] = {}
    for module in iter_modules(effects.__path__):
        effect = import_module(f"{effects.__name__}.{module.name}").EFFECT
        by_name[module.name.replace("_", "-")] = effect
    by_name |= {point.name: point.load() for point in entry_points(group="flipflow.effects")}
    checkable = {"", *(field.name for field in fields(Observed))}
    for name, effect in by_name.items():
        assert isinstance(effect, Effect), f"{name} is not an Effect"
        assert effect.checked_by in checkable, f"{name}: a run does not tell {effect.checked_by}"
    return by_name


EFFECTS = _find_effects()
FLAT = ("frames", "panel", "particles", "exchange")
"""Tables of the case that contain no tables, for solvers and exchanges."""


@dataclass(frozen=True)
class Judged:
    """An effect judged in one scene.

    ``present`` says whether the case has the effect, and ``can_go`` whether keys of the case can still
    leave it out.
    """

    effect: str
    part: Part
    key: str
    present: bool
    can_go: bool
    verdict: Verdict

    @property
    def is_lacking(self) -> bool:
        """Whether the effect matters, and the case does not have it."""
        return self.verdict.matters is True and not self.present

    @property
    def is_spare(self) -> bool:
        """Whether the case has the effect, could do without it, and has a key that leaves it out."""
        return self.verdict.matters is False and self.present and bool(self.key)


def judge_effects(case: Case, numbers: Scene | None = None) -> dict[str, Judged]:
    """Return the judgements of effects by name, part by part, for a case without problems in its tables.

    ``numbers`` is the case's scene where it is known.  Cases without particles or without panels have no
    judgements of the effects of these.
    """
    numbers, judged = numbers or scene(case), {}
    for name, effect in sorted(EFFECTS.items(), key=lambda item: PARTS.index(item[1].part)):
        verdict = effect.judge(numbers) if has_part(case, effect.part) else None
        if verdict is not None:
            present, can_go = has_effect(case, name), can_leave_out(case, name)
            judged[name] = Judged(name, effect.part, effect.key, present, can_go, verdict)
    return judged


def can_leave_out(case: Case, name: str) -> bool:
    """Return whether keys of the case can still leave an effect out.

    They cannot if settings leave out the effect already, or another one that it needs.
    """
    gone = any(why_left_out(case, effect) for effect in (name, *all_needs(name)))
    return bool(EFFECTS[name].overlay(case)) and not gone


def find_dispensable(every: Iterable[Judged]) -> list[str]:
    """Return the names of the effects that may be left out and that keys of the case can leave out."""
    return [judged.effect for judged in every if judged.can_go and judged.verdict.matters is False]


def with_dependents(names: Collection[str], why: str) -> dict[str, str]:
    """Return the reasons why these effects, and all that need one of them, are left out, by name."""
    reasons = dict.fromkeys(names, why)
    for name in EFFECTS:
        if need := next((need for need in all_needs(name) if need in names), None):
            reasons[name] = f"it needs {need}, which is left out"
    return reasons


def all_needs(name: str) -> Iterator[str]:
    """Yield the names of all effects that an effect needs, directly or through others."""
    for need in EFFECTS[name].needs:
        yield need
        yield from all_needs(need)


def has_effect(case: Case, name: str) -> bool:
    """Return whether the case describes an effect and has it, and has all effects that it needs."""
    effect = EFFECTS[name]
    present = effect.is_described(case) and not why_left_out(case, name)
    return present and all(has_effect(case, need) for need in effect.needs)


def find_also_lost(case: Case, name: str) -> list[str]:
    """Return the effects that the case loses together with an effect although they do not need it.

    A solver that leaves out the one may not know the other.
    """
    flat = {
        table: getattr(case, table).model_copy(update=dict(keys))
        for table, keys in EFFECTS[name].overlay(case).items()
        if table in FLAT
    }
    without = case.model_copy(update=flat)
    others = (other for other in EFFECTS if other != name and name not in all_needs(other))
    return [other for other in others if has_effect(case, other) and not has_effect(without, other)]


def find_left_out(case: Case) -> dict[str, str]:
    """Return the reasons why solvers and other settings leave effects out of a case, by effect."""
    reasons = {name: why_left_out(case, name) for name in EFFECTS}
    return {name: why for name, why in reasons.items() if why}


def why_left_out(case: Case, name: str) -> str:
    """Return why settings, or a solver, leave out an effect; "" if none does.

    A solver only leaves out effects that the case describes.
    """
    effect = EFFECTS[name]
    if why := effect.left_out(case):
        return why
    for port, adapter in case.adapters.items():
        instead = adapter.leaves_out.get(name)
        if instead is not None and effect.is_described(case):
            return f"{port}.solver {getattr(case, port).solver}: {instead}"
    return ""


def find_left_out_by_level(bare: Case, at_level: Case) -> dict[str, str]:
    """Return the reasons why a level leaves effects out of the bare case, by effect."""
    before, after = (missing_features(case) | find_left_out(case) for case in (bare, at_level))
    reasons = {name: why for name, why in after.items() if name not in before}
    for name, effect in EFFECTS.items():
        if effect.overlay(bare) and effect.is_described(bare) and not effect.described(at_level):
            reasons.setdefault(name, "nothing in the case describes it any more")
    return reasons
