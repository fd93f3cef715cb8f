"""What every adapter of the frames port must do; ``CASES`` lists the adapters.

Each case builds the real solver on a small machine.  A package that is missing makes the case
fail with SolverMissing: nothing is skipped.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib import import_module

import numpy as np

from orchestrator.clock import Interval
from orchestrator.plans import Drive, FramesPlan
from orchestrator.ports import Account, Array, Frames, Load
from tests.frames.machines import exciter, two_bodies

INTERVAL_S = 5e-4


@dataclass(frozen=True)
class Case:
    """``still``: a plan in which nothing drives; ``moving``: one in which something does."""

    solver: str
    still: Callable[[], FramesPlan]
    moving: Callable[[float], FramesPlan]

    def open(self, plan: FramesPlan) -> Frames:
        frames: Frames = import_module(f"adapters.frames.{self.solver}").build(plan)
        return frames


def driven(*drives: Drive) -> FramesPlan:
    return replace(two_bodies(drawn_at_rest=False), bushings=(), drives=drives)


def drive() -> Drive:
    half, none = np.array([0.0, 0.3, 1.0]), np.zeros(3)
    swing = np.array([8e-3, 0.0, 5e-3])
    return Drive("driven", none, 78.5, swing, half, np.array([0.0, 0.01, 0.0]), half, 0.05)


def excited(step_s: float) -> FramesPlan:
    turning = exciter(run_up_s=0.05, position_m=np.array([0.05, 0.02, 0.226]))
    return two_bodies((turning,), interval_s=INTERVAL_S, step_s=step_s)


CASES = {
    "prescribed": Case("prescribed", lambda: driven(), lambda step_s: driven(drive())),
    "two_mass": Case("two_mass", two_bodies, excited),
    "exudyn": Case("exudyn", two_bodies, excited),
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
