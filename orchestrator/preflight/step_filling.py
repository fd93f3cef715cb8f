"""How the particles' steps fill a sync interval, and which settings would waste less of the allowed step.

Whole steps fill an interval, so the step that is taken is the allowed one only where the interval is a
multiple of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from decimal import ROUND_FLOOR, Decimal

from orchestrator.case.bed.contact_times import LARGEST_RAYLEIGH_FRACTION, shortest_rayleigh_s
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.case import Case
from orchestrator.ports.clock import steps_in

WELL_FILLED = 0.9
"""Share of the allowed step from which on nothing is gained by other settings."""
DIGITS = 3
"""Significant digits of a proposed interval or fraction, which is rounded down."""


@dataclass(frozen=True)
class StepFilling:
    """The steps of the particles in a sync interval.

    ``share`` is the step taken over the longest step that the case allows.
    """

    steps: int
    share: float
    interval_s: float
    allowed_s: float


def step_filling(case: Case) -> StepFilling:
    """Return how the particles' steps fill the sync interval of a case with particles."""
    interval_s, allowed_s = case.coupling.sync_interval_s, particle_step_s(case)
    steps = steps_in(interval_s, allowed_s)
    return StepFilling(steps, interval_s / steps / allowed_s, interval_s, allowed_s)


def step_filling_lines(case: Case) -> Iterator[str]:
    """Yield lines that tell how steps fill an interval, and what would waste less."""
    filling = step_filling(case)
    steps, used = filling.steps, 100 * filling.share
    yield f"  particles' steps in an interval  {steps}, each {used:.0f} % of the longest allowed"
    if filling.share >= WELL_FILLED:
        return
    intervals_s = {count: _round_down(count * filling.allowed_s) for count in (steps - 1, steps) if count}
    intervals = " or ".join(f"{interval_s:g} ({count})" for count, interval_s in intervals_s.items())
    fraction = _fraction_for_fewer(case, filling)
    proposed = f", or particles.rayleigh_fraction = {fraction:g} ({steps - 1})" if fraction else ""
    yield f"    full steps: coupling.sync_interval_s = {intervals}{proposed}"


def _fraction_for_fewer(case: Case, filling: StepFilling) -> float | None:
    """Return the fraction of the Rayleigh time with which one step fewer fills the interval; None if that is
    above the largest fraction, or if something else limits the step."""
    if filling.steps == 1 or case.particles.step_s > 0:
        return None
    rayleigh_s = shortest_rayleigh_s(case)
    fraction = -_round_down(-filling.interval_s / (filling.steps - 1) / rayleigh_s)
    by_fraction = filling.allowed_s >= case.particles.rayleigh_fraction * rayleigh_s * (1 - 1e-9)
    return fraction if by_fraction and fraction <= LARGEST_RAYLEIGH_FRACTION else None


def _round_down(value: float) -> float:
    """Return the number of ``DIGITS`` significant digits that is next below."""
    exact = Decimal(value)
    digit = Decimal(1).scaleb(exact.adjusted() - DIGITS + 1)
    return float(exact.quantize(digit, rounding=ROUND_FLOOR))
