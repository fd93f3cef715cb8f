"""Frames that move as prescribed: no masses, no forces, exact positions and velocities.

The drives give whatever force and work the panels' reaction asks for.  A body without a drive
stands still, and so does "ground".  Equations: docs/theory/frames.md.
"""

from __future__ import annotations

import numpy as np

from adapters.frames.common.drive import DrivenBodies
from orchestrator.ports import Account, Known, Load, Motion, Pose, check_point_count, linear_frames
from orchestrator.ports.adapters import FramesAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import Cost, FramesPlan, FramesWork
from orchestrator.ports.state import SavedAttributes


class PrescribedFrames(SavedAttributes):
    """``Frames`` moved by drives only.

    Raises ValueError if the plan has exciters or bushings, or names an unknown body.
    """

    STATE = ("_now", "_now_s", "_impulse_N_s", "_received_J")

    def __init__(self, plan: FramesPlan) -> None:
        if plan.exciters or plan.bushings:
            raise ValueError(
                f"prescribed frames move by drives only, but the plan has {len(plan.exciters)} "
                f"exciters and {len(plan.bushings)} bushings: leave them out or take another solver"
            )
        linear_frames.numbers(plan, plan.carrier)
        linear_frames.driven(plan)
        self._plan, self._bodies = plan, DrivenBodies(plan)
        self._now, self._now_s = self._bodies.points(0.0), 0.0
        self._impulse_N_s = np.zeros(3)
        self._received_J = 0.0

    def initial(self) -> Motion:
        return self._now

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        check_point_count("frames' reaction", reaction, len(self._now))
        before, self._now, self._now_s = self._now, self._bodies.points(interval.end_s), interval.end_s
        moved_m = self._now.position_m - before.position_m
        self._received_J += float(np.sum(reaction.force_N * moved_m))
        self._impulse_N_s += interval.length_s * reaction.force_N.sum(axis=0)
        return self._now

    def ahead(self, interval: Interval) -> Known | None:
        """Return the motion of all points; points without a drive stand still."""
        if not self._plan.drives:
            return None
        return Known(self._bodies.points(interval.end_s), np.ones(len(self._now), dtype=np.bool_))

    def pose(self) -> Pose:
        return self._bodies.pose(self._now_s)

    def account(self) -> Account:
        """Return the account of massless bodies: the drives return at once the impulse and the work they
        receive."""
        return Account(
            np.zeros(3),
            -self._impulse_N_s,
            supplied_J={"drive": -self._received_J},
            received_J={"reaction": self._received_J},
        )


build = PrescribedFrames


def cost(work: FramesWork) -> Cost:
    """Return the time of a call in each interval, and of each drive."""
    return Cost(0.01, work.runs * (1.5e-5 + 7e-5 * work.driven))


ADAPTER = FramesAdapter(
    about="moved by drives only",
    build=build,
    cost=cost,
    leaves_out={
        "frame-dynamics": "nothing acts on the frames' motion",
        "motor-slip": "shafts turn at their speed_rad_per_s",
        "bushing-hysteresis": "bushings do not act, and their recorded forces are linear",
    },
    moved_by_forces=False,
    motors=False,
    hysteresis=False,
    fidelity=0,
)
