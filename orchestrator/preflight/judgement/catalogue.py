"""All effects that there are: every file in ``orchestrator/preflight/effects`` is one."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from pkgutil import iter_modules
from typing import get_args

from orchestrator.case import solvers
from orchestrator.case.tables.case import Case, absent, has_particles
from orchestrator.preflight import effects
from orchestrator.preflight.scene.effect import Effect, Part, Verdict
from orchestrator.preflight.scene.scene import scene


def _found() -> dict[str, Effect]:
    found: dict[str, Effect] = {}
    for module in iter_modules(effects.__path__):
        effect = import_module(f"{effects.__name__}.{module.name}").EFFECT
        assert isinstance(effect, Effect)
        found[module.name.replace("_", "-")] = effect
    return found


EFFECTS = _found()
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


def judged(case: Case) -> dict[Part, list[Judged]]:
    """By part; particles and panels are empty where there are none.  For a case whose tables fit
    together (``checks.find_table_problems``)."""
    there: dict[Part, bool] = {
        "particles": has_particles(case),
        "panels": bool(case.screen.panels),
        "frames": True,
        "machine": True,
    }
    seen = scene(case)
    found: dict[Part, list[Judged]] = {part: [] for part in get_args(Part)}
    for name, effect in EFFECTS.items():
        verdict = effect.judge(seen) if there[effect.part] else None
        if verdict is not None:
            one = Judged(name, effect.key, present(case, name), can_go(case, name), verdict)
            found[effect.part].append(one)
    return found


def can_go(case: Case, name: str) -> bool:
    """Whether keys of the case leave it out that do not do so yet: neither it nor, with another
    value of the same key, something that it needs."""
    gone = any(why_left_out(case, effect) for effect in (name, *needs_of(name)))
    return bool(EFFECTS[name].overlay(case)) and not gone


def spared(every: Iterable[Judged]) -> list[str]:
    """What may be left out, by keys of the case."""
    return [one.effect for one in every if one.can_go and one.verdict.matters is False]


def with_dependents(names: Collection[str], why: str) -> dict[str, str]:
    """These, and all that needs one of them: name -> why."""
    found = dict.fromkeys(names, why)
    for name in EFFECTS:
        if need := next((need for need in needs_of(name) if need in names), None):
            found[name] = f"it needs {need}, which is left out"
    return found


def needs_of(name: str) -> Iterator[str]:
    """All effects without which this is nothing."""
    for need in EFFECTS[name].needs:
        yield need
        yield from needs_of(need)


def present(case: Case, name: str) -> bool:
    """Whether the case describes it and nothing leaves it out, nor what it needs."""
    effect = EFFECTS[name]
    there = effect.described(case) and not why_left_out(case, name)
    return there and all(present(case, one) for one in effect.needs)


def taken_along(case: Case, name: str) -> list[str]:
    """What else the case loses with an effect although it does not need it: solvers that leave out
    the one may not know the other."""
    flat = {
        table: getattr(case, table).model_copy(update=dict(keys))
        for table, keys in EFFECTS[name].overlay(case).items()
        if table in FLAT
    }
    without = case.model_copy(update=flat)
    others = (one for one in EFFECTS if one != name and name not in needs_of(one))
    return [one for one in others if present(case, one) and not present(without, one)]


def left_out(case: Case) -> dict[str, str]:
    """What solvers and other settings leave out of this case: name -> why."""
    reasons = {name: why_left_out(case, name) for name in EFFECTS}
    return {name: why for name, why in reasons.items() if why}


def why_left_out(case: Case, name: str) -> str:
    """Why settings leave an effect out, or a solver one that the case describes; "" if none does."""
    effect = EFFECTS[name]
    if why := effect.left_out(case):
        return why
    for port, adapter in solvers.in_use(case).items():
        instead = adapter.leaves_out.get(name)
        if instead is not None and effect.described(case):
            return f"{port}.solver {getattr(case, port).solver}: {instead}"
    return ""


def dropped(bare: Case, at_level: Case) -> dict[str, str]:
    """What the level leaves out of the bare case."""
    before, after = absent(bare) | left_out(bare), absent(at_level) | left_out(at_level)
    found = {name: why for name, why in after.items() if name not in before}
    for name, effect in EFFECTS.items():
        if effect.overlay(bare) and effect.described(bare) and not effect.described(at_level):
            found.setdefault(name, "nothing in the case describes it any more")
    return found
