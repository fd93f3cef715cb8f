"""The contract of the adapters of the frames port; ``CASES`` lists the adapters.

Each case builds the real solver on a small machine.  A package that is missing makes the case
fail with SolverMissing: nothing is skipped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from orchestrator.case import solvers
from orchestrator.ports import Account, Array, Frames, Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import DrivePlan, FramesPlan
from tests.frames.machines import exciter, two_bodies, with_elements, with_gaps

INTERVAL_S = 5e-4


@dataclass(frozen=True)
class Case:
    """``still``: a plan in which nothing drives; ``moving``: one in which something does."""

    solver: str
    still: Callable[[], FramesPlan]
    moving: Callable[[float], FramesPlan]

    def open(self, plan: FramesPlan) -> Frames:
        frames: Frames = solvers.adapter("frames", self.solver).build(plan)
        return frames


def driven(*drives: DrivePlan) -> FramesPlan:
    return replace(two_bodies(drawn_at_rest=False), bushings=(), drives=drives)


def drive(body: str = "driven", size: float = 1.0) -> DrivePlan:
    half, none = np.array([0.0, 0.3, 1.0]), np.zeros(3)
    swing, rock = size * np.array([8e-3, 0.0, 5e-3]), size * np.array([0.0, 0.01, 0.0])
    return DrivePlan(body, none, 78.5, swing, half, rock, half, 0.05)


def excited(step_s: float) -> FramesPlan:
    turning = exciter(run_up_s=0.05, position_m=np.array([0.05, 0.02, 0.226]))
    return two_bodies((turning,), interval_s=INTERVAL_S, step_s=step_s)


def one_driven(step_s: float, size: float = 1.0) -> FramesPlan:
    """The driving frame rocks as prescribed; the driven one hangs on it, free and excited."""
    plan = two_bodies(interval_s=INTERVAL_S, step_s=step_s)
    turning = exciter(body="driven", mass_moment_kg_m=0.5 * size, run_up_s=0.05)
    return replace(plan, drives=(drive("driving", size),), exciters=(turning,))


def both_driven(step_s: float, size: float = 1.0) -> FramesPlan:
    """Return two driven frames with bushings between them and to the ground, which the drives have to
    move."""
    slower = replace(drive("driving", size), speed_rad_per_s=40.0)
    plan = two_bodies(interval_s=INTERVAL_S, step_s=step_s)
    return replace(plan, drives=(drive("driven", size), slower))


def curved(plan: Callable[[float], FramesPlan]) -> Callable[[float], FramesPlan]:
    """The plan with friction and Maxwell elements in its bushings."""
    return lambda step_s: with_elements(plan(step_s))


def gapped(plan: Callable[[float], FramesPlan]) -> Callable[[float], FramesPlan]:
    """The plan with piecewise linear bushings."""
    return lambda step_s: with_gaps(plan(step_s))


CASES = {
    "prescribed": Case("prescribed", lambda: driven(), lambda step_s: driven(drive())),
    "two-mass": Case("two-mass", two_bodies, excited),
    "two-mass, gaps": Case("two-mass", lambda: with_gaps(two_bodies()), gapped(excited)),
    "planar": Case("planar", two_bodies, excited),
    "planar, one driven": Case("planar", lambda: one_driven(0.0, 0.0), one_driven),
    "planar, both driven": Case("planar", lambda: both_driven(0.0, 0.0), both_driven),
    "planar, curved": Case("planar", lambda: with_elements(two_bodies()), curved(excited)),
    "exudyn": Case("exudyn", two_bodies, excited),
    "exudyn, curved": Case("exudyn", lambda: with_elements(two_bodies()), curved(excited)),
    "exudyn, gaps": Case("exudyn", lambda: with_gaps(two_bodies()), gapped(excited)),
    "exudyn, one driven, gaps": Case("exudyn", lambda: with_gaps(one_driven(0.0, 0.0)), gapped(one_driven)),
    "exudyn, one driven": Case("exudyn", lambda: one_driven(0.0, 0.0), one_driven),
    "exudyn, both driven": Case("exudyn", lambda: both_driven(0.0, 0.0), both_driven),
}


def loads(count: int) -> Array:
    """(count, 4, 3) reproducible reactions of some hundred newton."""
    phase = np.random.default_rng(3).uniform(0, 6, size=(1, 4, 3))
    return np.asarray(500.0 * np.sin(0.02 * np.arange(count)[:, None, None] + phase))


def accounts(frames: Frames, reactions: Array, interval_s: float = INTERVAL_S) -> list[Account]:
    """The account at the start and after each interval."""
    books = [frames.account()]
    for index, force_N in enumerate(reactions):
        frames.advance(Interval(index, interval_s), Load(force_N))
        books.append(frames.account())
    return books


def defect_J(start: Account, end: Account) -> float:
    """Zero for a perfect solver; see ``Account``."""

    def total(account: Account) -> float:
        kept = sum(account.stored_J.values()) + sum(account.lost_J.values())
        return kept - sum(account.supplied_J.values()) - sum(account.received_J.values())

    return total(end) - total(start)


def compared(first: Frames, second: Frames, reactions: Array, interval_s: float) -> None:
    """Motions to 1e-14 m and 1e-12 m/s in every interval, books to 1e-12 of their size."""
    for index, force_N in enumerate(reactions):
        interval = Interval(index, interval_s)
        actual, expected = (first.advance(interval, Load(force_N)), second.advance(interval, Load(force_N)))
        assert actual.position_m == pytest.approx(expected.position_m, abs=1e-14)
        assert actual.velocity_m_per_s == pytest.approx(expected.velocity_m_per_s, abs=1e-12)
    mine, its = first.account(), second.account()
    assert mine.supplied_J["drive"] == pytest.approx(its.supplied_J["drive"], rel=1e-11)
    assert mine.outside_impulse_N_s == pytest.approx(its.outside_impulse_N_s, rel=1e-11)
