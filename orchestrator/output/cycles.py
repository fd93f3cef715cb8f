"""The machine's cycle, and the cycle to which a time belongs: one definition for records and results.

Cycle n, counted from 0, holds the times later than n and up to n + 1 cycles after the start; the
start itself belongs to the first cycle.  Rows at equal steps therefore spread evenly over the cycles.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType

import numpy as np
import numpy.typing as npt

from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, Indices

CYCLES_WITHOUT_DRIVE = 50
ROUNDING = 1e-7  # of a cycle: a time that is nearer than this to the end of a cycle counts as its end


def cycle_s(case: Case, shafts_rad_per_s: Mapping[str, float] = MappingProxyType({})) -> float:
    """Return the period of the slowest exciter or drive, or the duration of the run if there is none.

    ``shafts_rad_per_s`` has the speeds of exciters, by name, that differ from the case's.
    """
    speeds_rad_per_s = {**named_speeds_rad_per_s(case), **shafts_rad_per_s}.values()
    return 2 * math.pi / min(speeds_rad_per_s) if speeds_rad_per_s else case.duration_s


def is_driven(case: Case) -> bool:
    """Return whether an exciter or a drive gives the machine a cycle."""
    return bool(named_speeds_rad_per_s(case))


def named_speeds_rad_per_s(case: Case) -> dict[str, float]:
    """Return the speeds that the case names: of drives that move, by the frame as "drive of <frame>", and of
    exciters, by their names, if forces move the frames."""
    drives = {
        f"drive of {name}": frame.drive.speed_rad_per_s
        for name, frame in case.screen.frames.items()
        if frame.drive and frame.drive.moves
    }
    exciters = case.screen.exciters if case.frames.adapter.moved_by_forces else {}
    return drives | {name: exciter.speed_rad_per_s for name, exciter in exciters.items()}


def counted_cycle_s(case: Case) -> float:
    """Return the period by which results are counted: the machine's cycle, or a fiftieth of the run if
    nothing drives the machine."""
    return cycle_s(case) if is_driven(case) else case.duration_s / CYCLES_WITHOUT_DRIVE


def cycle_numbers(time_s: Array | float, cycle_s: float, start_s: float = 0.0) -> Indices:
    """Return the number of each time's cycle, counted from 0 after ``start_s``."""
    number = np.ceil((time_s - start_s) / cycle_s - ROUNDING) - 1
    return np.asarray(np.maximum(number, 0), np.int64)


def cycle_number(time_s: float, cycle_s: float) -> int:
    """Return the number of the cycle of one time since t = 0, as ``cycle_numbers`` does, and far quicker."""
    return max(0, math.ceil(time_s / cycle_s - ROUNDING) - 1)


def count_whole_cycles(lasting_s: float, cycle_s: float) -> int:
    """Return the number of whole cycles in the span ``lasting_s``."""
    return max(0, math.floor(lasting_s / cycle_s + ROUNDING))


def within(time_s: Array, start_s: float, end_s: float, cycle_s: float) -> npt.NDArray[np.bool_]:
    """Return whether each time lies in the cycles between ``start_s`` and ``end_s``, both ends of cycles.

    A time at ``start_s`` lies outside, and a time at ``end_s`` inside.
    """
    rounding_s = ROUNDING * cycle_s
    return np.asarray((time_s > start_s + rounding_s) & (time_s <= end_s + rounding_s))
