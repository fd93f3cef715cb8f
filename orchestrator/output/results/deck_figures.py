"""The bed on the deck: depth, velocity and hold-up along it, and what is stuck."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.output.results.estimate import Estimate, batch_sums, estimate, mean
from orchestrator.output.results.placement import share
from orchestrator.output.results.run_data import RunData
from orchestrator.ports import Array


def bed_figures(data: RunData, start_s: float, end_s: float, is_steady: bool) -> dict[str, Any]:
    """Over the output times from ``start_s`` to ``end_s``, of which there must be one; intervals
    only where it is steady.

    All are means over time, in which a bin or a deck without particles has no mass and a depth of
    0; velocities are means over the mass, to which an empty one gives nothing.
    """
    time = data.read("profile/time_s")
    window = averaged(time, start_s, end_s)
    mass, velocity, depth = (
        np.nan_to_num(data.read(f"profile/{name}")[window])
        for name in ("mass_kg", "velocity_m_per_s", "depth_m")
    )
    along = data.read("profile/along_m")[0]
    cycle = np.floor((time[window] - start_s) / data.cycle_s - 1e-9).astype(int)
    kg, momentum = mass.sum(axis=1), (mass * velocity).sum(axis=1)
    total = mass.sum(axis=0)
    present = data.read("bed/particles")[averaged(data.read("bed/time_s"), start_s, end_s)]
    return {
        "output_times": int(window.sum()),
        "particles": float(present.mean()),
        "on_deck_kg": by_cycles(kg, cycle, is_steady),
        "velocity_m_per_s": ratio_by_cycles(momentum, kg, cycle, is_steady),
        "largest_depth_m": by_cycles(depth.max(axis=1), cycle, is_steady),
        "profile": {
            "along_m": along,
            "mass_kg_per_m": mass.mean(axis=0) / (along[1] - along[0]),
            "velocity_m_per_s": np.divide(
                (mass * velocity).sum(axis=0), total, out=np.full(len(total), np.nan), where=total > 0
            ),
            "depth_m": depth.mean(axis=0),
        },
    }


def held_figures(data: RunData, start_s: float, end_s: float, is_steady: bool) -> dict[str, Any]:
    """Stickers and blinded openings over the same times."""
    time = data.read("held/time_s")
    window = averaged(time, start_s, end_s)
    cycle = np.floor((time[window] - start_s) / data.cycle_s - 1e-9).astype(int)
    names = {"stickers": "stickers", "sticking_kg": "mass_kg", "blinded_openings": "openings"}
    return {
        name: by_cycles(data.read(f"held/{series}")[window], cycle, is_steady)
        for name, series in names.items()
    }


def averaged(time_s: Array, start_s: float, end_s: float) -> Any:
    """(times,) which of the output times lie in the window."""
    return (time_s > start_s + 1e-9) & (time_s <= end_s + 1e-9)


def by_cycles(values: Array, cycle: Array, is_steady: bool) -> Estimate:
    """Of values at output times, by cycles."""
    if not is_steady:
        return Estimate(float(values.mean()))
    which, index = np.unique(cycle, return_inverse=True)
    sums = np.bincount(index, values, len(which)) / np.bincount(index)
    return mean(sums)


def ratio_by_cycles(part: Array, whole: Array, cycle: Array, is_steady: bool) -> Estimate:
    """Sum of ``part`` over the sum of ``whole``, both at output times; None where that is 0."""
    which, index = np.unique(cycle, return_inverse=True)
    sums = np.array([np.bincount(index, one, len(which)) for one in (part, whole)], float).T
    if not is_steady:
        return Estimate(share(*sums.sum(axis=0)))
    return estimate(lambda total: share(*total), batch_sums(sums))
