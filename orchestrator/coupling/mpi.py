"""The MPI ranks of a run: one program on every rank, and one rank that speaks to the user.

``mpirun -n N flipflow run …`` starts N copies.  LIGGGHTS decomposes the particles over all ranks, each
panel belongs to one rank, and rank 0 solves the frames and broadcasts their motion.  A failure on any
rank ends all ranks: the first rank to fail reports it and then aborts the others, which may be
waiting for it in a collective call.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Mapping
from typing import Any, TypeVar, cast

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Account, Array, Frames, Known, Load, Motion, Pose, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import (
    FrameLoads,
    find_driven_points,
    find_element_forces_N,
    find_frame_loads,
    find_shaft_angles_rad,
)

Shared = TypeVar("Shared")
FIRST = Interval(0, 1e-6)
"""An interval to ask which points are driven; its length does not matter."""
_LAUNCHERS = ("OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK")


def communicator() -> Any:
    """Return the world's communicator, or None in a run of one process, which does not import mpi4py."""
    if not any(name in os.environ for name in _LAUNCHERS):
        return None
    from mpi4py import MPI

    return MPI.COMM_WORLD if MPI.COMM_WORLD.size > 1 else None


def is_first(world: Any) -> bool:
    """Return whether this is the rank that writes files and speaks to the user."""
    return world is None or world.rank == 0


def first_rank_does(world: Any, act: Callable[[], Shared]) -> Shared:
    """Call ``act`` on rank 0 alone, and return or raise the outcome on every rank."""
    if world is None:
        return act()
    answer: Any = None
    if world.rank == 0:
        try:
            answer = act()
        except Exception as error:
            answer = error
    answer = world.bcast(answer)
    if isinstance(answer, Exception):
        raise answer
    return cast(Shared, answer)


def end_all(world: Any, code: int) -> int:
    """End every rank, wherever it waits, with the exit code ``code``; with only one rank, return the code."""
    if world is not None:
        world.Abort(code)
    return code


def in_turn(world: Any, speak: Callable[[], object], code: int) -> int:
    """Report a failure that usually occurs on all ranks alike.

    The first rank speaks and ends all; another rank speaks only if no rank before it did.
    """
    if world is not None:
        time.sleep(2.0 * world.rank)
    speak()
    return end_all(world, code)


class FramesOnFirstRank:
    """Frames solved on rank 0, with the same motion, bit for bit, on all ranks."""

    def __init__(self, world: Any, open_frames: Callable[[], Frames]) -> None:
        self._world = world
        self._frames = open_frames() if world.rank == 0 else None
        self._points = 0
        self._driven: npt.NDArray[np.bool_] | None = None

    def initial(self) -> Motion:
        motion = self._broadcast(lambda frames: frames.initial())
        self._points = len(motion)
        first = self._broadcast(lambda frames: find_driven_points(frames, FIRST))
        self._driven = None if first is None else first.which
        return motion

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        return self._send(lambda frames: frames.advance(interval, reaction))

    def ahead(self, interval: Interval) -> Known | None:
        """Return the motion of the driven points, which are always the same."""
        if self._driven is None:
            return None
        return Known(self._send(lambda frames: _driven_motion(frames, interval)), self._driven)

    def _send(self, move: Callable[[Frames], Motion]) -> Motion:
        """Return the motion of all points, which goes to the other ranks as plain numbers."""
        numbers = np.empty((2, self._points, 3))
        if self._frames is not None:
            motion = move(self._frames)
            numbers[:] = motion.position_m, motion.velocity_m_per_s
        self._world.Bcast(numbers)
        return Motion(*numbers)

    def pose(self) -> Pose:
        """Return the pose on rank 0, which records it; a pose of no body on other ranks."""
        return self._frames.pose() if self._frames is not None else Pose.nothing()

    def element_forces_N(self) -> Array | None:
        """Return the forces on rank 0, which records them; None on other ranks."""
        return find_element_forces_N(self._frames) if self._frames is not None else None

    def shaft_angles_rad(self) -> Mapping[str, float]:
        """Return the angles on rank 0, which records them; none on other ranks."""
        return find_shaft_angles_rad(self._frames) if self._frames is not None else {}

    def loads(self) -> FrameLoads | None:
        """Return the forces on rank 0, which records them; None on other ranks."""
        return find_frame_loads(self._frames) if self._frames is not None else None

    def account(self) -> Account:
        return self._broadcast(lambda frames: frames.account())

    def save(self) -> Saved:
        """Return nothing on ranks that have no frames."""
        return self._frames.save() if self._frames is not None else {}

    def restore(self, saved: Saved) -> None:
        if self._frames is not None:
            self._frames.restore(saved)

    def close(self) -> None:
        if self._frames is not None:
            self._frames.close()

    def _broadcast(self, ask: Callable[[Frames], Shared]) -> Shared:
        answer = ask(self._frames) if self._frames is not None else None
        return cast(Shared, self._world.bcast(answer))


def _driven_motion(frames: Frames, interval: Interval) -> Motion:
    """Return the motion of all points at the interval's end, of which that of the driven ones is known."""
    known = find_driven_points(frames, interval)
    assert known is not None, "asked of frames without drives"
    return known.motion
