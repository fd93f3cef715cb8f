"""The bed on the deck: depth, velocity and hold-up along it, and what is stuck."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.ports import Array
from orchestrator.results.estimate import Estimate, mean
from orchestrator.results.run_data import RunData


def bed_figures(data: RunData, start_s: float, end_s: float, is_steady: bool) -> dict[str, Any]:
    """Over the output times from ``start_s`` to ``end_s``; intervals only where it is steady."""
    time = data.read("profile/time_s")
    window = (time > start_s) & (time <= end_s + 1e-9)
    if not window.any():
        window[-1] = True
    mass, velocity, depth = (
        data.read(f"profile/{name}")[window] for name in ("mass_kg", "velocity_m_s", "depth_m")
    )
    along = data.read("profile/along_m")[0]
    cycle = np.floor((time[window] - start_s) / data.cycle_s - 1e-9).astype(int)
    kg = mass.sum(axis=1)
    flow = np.nansum(mass * velocity, axis=1)
    speed = np.divide(flow, kg, out=np.full(len(kg), np.nan), where=kg > 0)
    deepest = np.where(np.isnan(depth).all(axis=1), 0.0, np.nanmax(_filled(depth), axis=1))
    total = mass.sum(axis=0)
    return {
        "on_deck_kg": by_cycles(kg, cycle, is_steady),
        "velocity_m_s": by_cycles(speed[kg > 0], cycle[kg > 0], is_steady),
        "largest_depth_m": by_cycles(deepest, cycle, is_steady),
        "profile": {
            "along_m": along,
            "mass_kg_m": mass.mean(axis=0) / (along[1] - along[0]),
            "velocity_m_s": np.divide(
                np.nansum(mass * velocity, axis=0),
                total,
                out=np.full(len(total), np.nan),
                where=total > 0,
            ),
            "depth_m": _mean_there(depth),
        },
    }


def held_figures(data: RunData, start_s: float, end_s: float, is_steady: bool) -> dict[str, Any]:
    """Stickers and blinded openings over the same times."""
    time = data.read("held/time_s")
    window = (time > start_s) & (time <= end_s + 1e-9)
    if not window.any():
        window[-1] = True
    cycle = np.floor((time[window] - start_s) / data.cycle_s - 1e-9).astype(int)
    names = {"stickers": "stickers", "sticking_kg": "mass_kg", "blinded_openings": "openings"}
    return {
        name: by_cycles(data.read(f"held/{series}")[window], cycle, is_steady)
        for name, series in names.items()
    }


def by_cycles(values: Array, cycle: Array, is_steady: bool) -> Estimate:
    """Of values at output times, by cycles."""
    if not len(values):
        return Estimate(None)
    if not is_steady:
        return Estimate(float(values.mean()))
    which, index = np.unique(cycle, return_inverse=True)
    sums = np.bincount(index, values, len(which)) / np.bincount(index)
    return mean(sums)


def _filled(depth_m: Array) -> Array:
    return np.where(np.isnan(depth_m), -np.inf, depth_m)


def _mean_there(values: Array) -> Array:
    """Mean over rows of what is not NaN; NaN where nothing is."""
    there = np.isfinite(values)
    count = there.sum(axis=0)
    total = np.where(there, values, 0.0).sum(axis=0)
    return np.divide(total, count, out=np.full(len(count), np.nan), where=count > 0)
