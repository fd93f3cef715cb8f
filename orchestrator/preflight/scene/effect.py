"""What an effect is, and what is said of one in a scene."""

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
"""Estimates are good to a factor of three (docs/theory/effects.md): the project's own choice."""
TENTH = 0.1
"""What changes a result by less than a tenth may be left out: the project's own choice, as the
amplitudes of cases/ffs0827-empty meet the published ones to about a tenth."""


@dataclass(frozen=True)
class Verdict:
    """Whether an effect matters in a scene.

    ``number`` names the dimensionless number that decides, ``value`` is its value (None: there is
    none), ``threshold`` what it is compared with; ``matters`` is None where the scene does not
    tell; ``why`` says so in words, ``cost`` what the effect costs.  ``limit`` is the threshold as
    a number where the estimate is only good to a factor: within ``MARGIN`` below it, the estimate
    does not decide.  ``measured`` marks a verdict by a pair of runs with and without the effect.
    ``about`` has the parts whose results the number is an estimate of, where they are others than
    those of the effect.
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
        """Whether the value is below the limit and yet too near to it for an estimate to say that
        the effect may be left out."""
        if self.limit is None or self.value is None or self.measured:
            return False
        return self.limit / MARGIN < self.value <= self.limit

    @property
    def is_clear(self) -> bool:
        """Whether an effect that matters does so beyond the error of its estimate."""
        return self.limit is None or self.value is None or self.value > MARGIN * self.limit

    @property
    def value_in_words(self) -> str:
        """The value to three digits; "-" without one."""
        if self.value is None:
            return "-"
        if math.isinf(self.value):
            return "infinite"
        return "0" if abs(self.value) < NOTHING_BUT_ROUNDING else f"{self.value:.3g}"

    @property
    def in_numbers(self) -> str:
        """The number, its value and its threshold."""
        return f"{self.number} {self.value_in_words}, threshold {self.threshold}"

    def doubted(self, because: str) -> Verdict:
        """Return the verdict as one that cannot say, with the reason."""
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
    """Return the verdict of a number that matters above a limit; without a value it cannot say."""
    matters = None if value is None else value > limit
    return Verdict(number, value, threshold, matters, why, cost, limit, about=about)


def describe_verdict(matters: bool | None) -> str:
    """Return "matters", "may be left out" or "cannot say"."""
    if matters is None:
        return "cannot say"
    return "matters" if matters else "may be left out"


def has_part(case: Case, part: Part) -> bool:
    """Return whether a case has particles or panels; it always has frames and a machine."""
    return {"particles": has_particles(case), "panels": bool(case.screen.panels)}.get(part, True)


def _always(case: Case) -> bool:
    return True


def _never(case: Case) -> str:
    return ""


def _nothing(case: Case) -> Overlay:
    return {}


Judge = Callable[[Scene], Verdict | None]


@dataclass(frozen=True)
class Effect:
    """One effect: a file in ``orchestrator/preflight/effects`` named after it.

    ``part`` is what it belongs to; ``judge`` is asked of cases that have this part, and returns None
    where the scene has no such question.  ``described`` says whether the data of such a case
    describe the effect.  ``left_out`` says in words what settings leave it out nevertheless ("":
    none do).  ``overlay`` has the keys of the case that leave it out, laid over it before it is read
    (None takes a key away); it is empty where only a number could be changed, or where this case
    cannot do without.  ``needs`` are effects without which it is nothing.  ``laws`` are names by
    which it can be called for with one of several laws, and the keys that choose it; two of them
    exclude each other.  ``key`` is what a user changes to have it or not.
    ``checked_by`` is what a run must tell (a field of ``Observed``) for ``judge`` to be asked again
    after it.  ``saves`` says whether a run without it takes less time, so that it is worth a trial.
    ``about`` has the parts whose results the number is an estimate of; of others it says nothing
    when it is above its threshold.
    """

    part: Part
    judge: Judge
    described: Callable[[Case], bool] = _always
    left_out: Callable[[Case], str] = _never
    overlay: Callable[[Case], Overlay] = _nothing
    needs: tuple[str, ...] = ()
    laws: Mapping[str, Overlay] = field(default_factory=dict)
    key: str = ""
    checked_by: str = ""
    saves: bool = False
    about: tuple[Part, ...] = PARTS

    @property
    def optional(self) -> bool:
        """Whether ``effects`` can leave it out."""
        return self.overlay is not _nothing

    def is_described(self, case: Case) -> bool:
        """Return whether the case has the effect's part and its data describe the effect."""
        return has_part(case, self.part) and self.described(case)


def exchange_effect(part: Part, judge: Judge, switch: str, off: str, **more: Any) -> Effect:
    """Return an effect that a key of ``exchange`` switches; ``off`` says what its being off means,
    and ``more`` are the effect's other fields."""

    def left_out(case: Case) -> str:
        return "" if getattr(case.exchange, switch) else f"exchange.{switch} is off: {off}"

    overlay: Overlay = {"exchange": {switch: False}}
    key = f"exchange.{switch}"
    return Effect(part, judge, left_out=left_out, overlay=lambda case: overlay, key=key, **more)


def overlay_of_rows(path: str, names: Iterable[str], keys: Overlay) -> Overlay:
    """Return an overlay that gives rows of a table, "screen.bushings", the same keys; empty without
    any."""
    overlay: Overlay = {name: keys for name in names}
    for word in reversed(path.split(".")) if overlay else ():
        overlay = {word: overlay}
    return overlay


def overlay_of_panels(case: Case, key: str) -> Overlay:
    """Return the keys that take ``key`` out of all panels and decks that have it."""
    kinds: dict[str, Mapping[str, Any]] = {"panels": case.screen.panels, "decks": case.screen.decks}
    tables = {
        kind: overlay
        for kind, rows in kinds.items()
        if (overlay := {name: {key: None} for name, row in rows.items() if getattr(row, key)})
    }
    return {"screen": tables} if tables else {}
