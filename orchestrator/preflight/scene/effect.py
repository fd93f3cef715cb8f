"""Effects, and the verdicts on them in a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal, get_args

from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.scene import Scene

Part = Literal["particles", "panels", "frames", "machine"]
PARTS: tuple[Part, ...] = get_args(Part)
Overlay = Mapping[str, Any]
NOTHING_BUT_ROUNDING = 1e-9
MARGIN = 3.0
"""Factor by which estimates may be wrong (docs/theory/effects.md), the project's own choice."""
TENTH = 0.1
"""Share of a result below which a change does not matter.  The project chose it because the amplitudes of
cases/ffs0827-empty agree with the published ones to about a tenth."""


@dataclass(frozen=True)
class Verdict:
    """The verdict whether an effect matters in a scene.

    ``number`` names the dimensionless number that decides, ``value`` is its value or None, and
    ``threshold`` describes its threshold.  ``matters`` is None if the scene does not tell.  ``why``
    explains the verdict, and ``cost`` says what the effect costs.  ``limit`` is the threshold as a
    number if the estimate is only good to a factor; within ``MARGIN`` below it, the estimate does not
    decide.  ``measured`` marks a verdict by a pair of runs with and without the effect.  ``about`` has
    the parts whose results the number estimates if they differ from those of the effect.
    """

    number: str
    value: float | None
    threshold: str
    matters: bool | None
    why: str
    cost: str = ""
    limit: float | None = None
    measured: bool = False
    about: tuple[Part, ...] = ()

    @property
    def is_close(self) -> bool:
        """Whether the value is below the limit, but too close to it for the estimate to decide."""
        if self.limit is None or self.value is None or self.measured:
            return False
        return self.limit / MARGIN < self.value <= self.limit

    @property
    def is_clear(self) -> bool:
        """Whether the value is farther above the limit than the estimate may be wrong."""
        return self.limit is None or self.value is None or self.value > MARGIN * self.limit

    @property
    def value_in_words(self) -> str:
        """The value as text with three digits; "-" without a value."""
        if self.value is None:
            return "-"
        if math.isinf(self.value):
            return "infinite"
        return "0" if abs(self.value) < NOTHING_BUT_ROUNDING else f"{self.value:.3g}"

    @property
    def in_numbers(self) -> str:
        """The name of the number, its value and its threshold as text."""
        return f"{self.number} {self.value_in_words}, threshold {self.threshold}"

    def doubted(self, because: str) -> Verdict:
        """Return the verdict "cannot say", with a further reason."""
        return replace(self, matters=None, why=f"{self.why}; {because}")


def compare(
    number: str,
    value: float | None,
    why: str,
    threshold: str = f"{TENTH:g}",
    limit: float = TENTH,
    cost: str = "",
    about: tuple[Part, ...] = (),
) -> Verdict:
    """Return the verdict of a number that matters above a limit, or "cannot say" without a value."""
    matters = None if value is None else value > limit
    return Verdict(number, value, threshold, matters, why, cost, limit, about=about)


def describe_verdict(matters: bool | None) -> str:
    """Return "matters", "may be left out" or "cannot say"."""
    if matters is None:
        return "cannot say"
    return "matters" if matters else "may be left out"


def has_part(case: Case, part: Part) -> bool:
    """Return whether a case has a part; every case has frames and a machine."""
    return {"particles": has_particles(case), "panels": bool(case.screen.panels)}.get(part, True)


def _nothing(case: Case) -> Overlay:
    return {}


Judge = Callable[[Scene], Verdict | None]


@dataclass(frozen=True)
class Effect:
    """An effect, which a file in ``orchestrator/preflight/effects`` with its name defines.

    ``part`` is the part of the scene to which the effect belongs.  ``judge`` returns the verdict for a
    case that has this part, or None if the scene does not raise the question.  ``described`` says
    whether the data of such a case describe the effect.  ``left_out`` names the setting that leaves out
    the effect, or returns "".  ``overlay`` returns the keys that leave the effect out of a case (None
    removes a key); it is empty if only a number could be changed, or if the case cannot do without the
    effect.  ``needs`` names the effects without which this one has no meaning.  ``laws`` maps the names
    of alternative laws, by which a case can call for the effect, to the keys that choose them.  ``key``
    names the key with which a user chooses the effect.  ``checked_by`` is the field of ``Observed``
    that a run must have before ``judge`` can repeat its verdict after the run.  ``saves`` says whether a
    run without the effect takes less time, so that a trial is worthwhile.  ``about`` has the parts whose
    results the number estimates; a number above its threshold says nothing of other parts.
    """

    part: Part
    judge: Judge
    described: Callable[[Case], bool] = lambda case: True
    left_out: Callable[[Case], str] = lambda case: ""
    overlay: Callable[[Case], Overlay] = _nothing
    needs: tuple[str, ...] = ()
    laws: Mapping[str, Overlay] = field(default_factory=dict)
    key: str = ""
    checked_by: str = ""
    saves: bool = False
    about: tuple[Part, ...] = PARTS

    @property
    def optional(self) -> bool:
        """Whether the case key ``effects`` can leave the effect out."""
        return self.overlay is not _nothing

    def is_described(self, case: Case) -> bool:
        """Return whether the case has the effect's part and its data describe the effect."""
        return has_part(case, self.part) and self.described(case)


def exchange_effect(part: Part, judge: Judge, switch: str, off: str, **more: Any) -> Effect:
    """Return an effect that a key of ``exchange`` switches on and off.

    ``off`` says what happens without it, and ``more`` has the effect's other fields.
    """

    def left_out(case: Case) -> str:
        return "" if getattr(case.exchange, switch) else f"exchange.{switch} is off: {off}"

    overlay: Overlay = {"exchange": {switch: False}}
    key = f"exchange.{switch}"
    return Effect(part, judge, left_out=left_out, overlay=lambda case: overlay, key=key, **more)


def overlay_of_rows(path: str, names: Iterable[str], keys: Overlay) -> Overlay:
    """Return an overlay that gives the named rows of a table, such as "screen.bushings", the same keys.

    The overlay is empty without names.
    """
    overlay: Overlay = {name: keys for name in names}
    for word in reversed(path.split(".")) if overlay else ():
        overlay = {word: overlay}
    return overlay


def overlay_of_panels(case: Case, key: str) -> Overlay:
    """Return the overlay that removes ``key`` from all panels and decks that have it."""
    kinds: dict[str, Mapping[str, Any]] = {"panels": case.screen.panels, "decks": case.screen.decks}
    tables = {
        kind: overlay
        for kind, rows in kinds.items()
        if (overlay := {name: {key: None} for name, row in rows.items() if getattr(row, key)})
    }
    return {"screen": tables} if tables else {}
