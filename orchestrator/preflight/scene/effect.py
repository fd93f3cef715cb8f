"""What an effect is, and what is said of one in a scene."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.observed import ObservedField
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
    ``about``: the parts whose results the number is an estimate of, where they are others than
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
    def value_in_words(self) -> str:
        """To three digits; "-" without one."""
        if self.value is None:
            return "-"
        if math.isinf(self.value):
            return "infinite"
        return "0" if abs(self.value) < NOTHING_BUT_ROUNDING else f"{self.value:.3g}"

    @property
    def in_numbers(self) -> str:
        """Number, value and threshold."""
        return f"{self.number} {self.value_in_words}, threshold {self.threshold}"


def describe_verdict(matters: bool | None) -> str:
    """ "matters", "may be left out" or "cannot say"."""
    if matters is None:
        return "cannot say"
    return "matters" if matters else "may be left out"


def _nothing(case: Case) -> Overlay:
    return {}


def _never(case: Case) -> str:
    return ""


Judge = Callable[[Scene], Verdict | None]


@dataclass(frozen=True)
class Effect:
    """One effect: a file in ``orchestrator/preflight/effects`` named after it.

    ``part``: what it belongs to.  ``judge``: None where the scene has no such question.
    ``described``: whether the case's data describe it.  ``left_out``: what settings leave it out
    nevertheless, in words ("": none do).  ``overlay``: keys of the case that leave it out, laid
    over it before it is read (None takes a key away); empty where only a number could be changed,
    or where this case cannot do without.  ``needs``: effects without which it is nothing.
    ``laws``: names by which it can be called for with one of several laws, and the keys that choose
    it; two of them exclude each other.  ``key``: what a user changes to have it or not.
    ``undescribed``: keys that take it out of the data where ``overlay`` chooses another law, for
    the benchmark.  ``checked_by``: what a run must tell (a field of ``Observed``) for ``judge`` to be
    asked again after it.  ``saves``: whether a run without it takes less time, so that it is worth
    a trial.  ``about``: the parts whose results the number is an estimate of; of others it says
    nothing when it is above its threshold.
    """

    part: Part
    judge: Judge
    described: Callable[[Case], bool]
    left_out: Callable[[Case], str] = _never
    overlay: Callable[[Case], Overlay] = _nothing
    undescribed: Callable[[Case], Overlay] = _nothing
    needs: tuple[str, ...] = ()
    laws: Mapping[str, Overlay] = field(default_factory=dict)
    key: str = ""
    checked_by: ObservedField | None = None
    saves: bool = False
    about: tuple[Part, ...] = PARTS

    @property
    def optional(self) -> bool:
        """Whether ``effects`` can leave it out."""
        return self.overlay is not _nothing
