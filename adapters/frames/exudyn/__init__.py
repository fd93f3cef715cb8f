"""Rigid frames with six degrees of freedom on bushings, by Exudyn (docs/theory/frames.md)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.ports import Frames
from orchestrator.ports.adapters import FramesAdapter, Objection
from orchestrator.ports.plans import Cost, FramesPlan, FramesWork

LARGEST_TILT_RAD = 1.4
"""The rotation angles are singular at a tilt of pi/2 about y; frames on bushings tilt by 0.01."""


def build(plan: FramesPlan) -> Frames:
    """Open frames at rest, or about to drop.

    Raises ValueError for unknown bodies, drives that make no sense, or bushings that cannot hold the
    weight; SolverMissing without Exudyn.
    """
    from adapters.frames.exudyn.frames import ExudynFrames

    return ExudynFrames(plan)


def objections(plan: FramesPlan) -> Iterator[Objection]:
    """Yield objections to drives that may turn a frame over."""
    for drive in plan.drives:
        largest_rad = np.linalg.norm(drive.rotation_rad)
        if largest_rad > LARGEST_TILT_RAD:
            what = f"may add up to {largest_rad:.3g} rad; exudyn's limit is {LARGEST_TILT_RAD:g}"
            key = ("screen", "frames", drive.body, "drive", "rotation_rad")
            yield Objection(what, 'frames.solver = "prescribed" has none', key)


def cost(work: FramesWork) -> Cost:
    """Return the measured time of a call, and of steps of about 1e-4 s."""
    return Cost(0.1, work.runs * (8e-5 + 0.4 * work.interval_s))


ADAPTER = FramesAdapter(
    about="rigid bodies in space, free or driven (Exudyn)",
    build=build,
    cost=cost,
    objections=objections,
    needs=("adapters.frames.exudyn.frames",),
    fidelity=3,
)
