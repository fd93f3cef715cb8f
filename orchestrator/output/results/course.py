"""The course of a run: how the stroke follows the load on the deck, from run-up to the empty deck."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from orchestrator.figures.machine import Course, PairInTime
from orchestrator.output.cycles import within
from orchestrator.output.results.estimate import IntervalOf
from orchestrator.output.results.harmonics import first_harmonic
from orchestrator.output.results.machine import relative_motions_m
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array

WINDOW_CYCLES = 12  # ten turns, the fewest that give an interval, of a shaft that lags by up to a sixth
FEWEST_WINDOWS = 3


def course(run: RunReader, interval_of: IntervalOf) -> Course | None:
    """Return the amplitude of each pair of frames along the deck, and the load, in windows of twelve whole
    cycles.

    The windows end at the run's last whole cycle; cycles that are left over are the first ones.  ``end_s``
    has the windows' ends.  ``relative`` has, for each pair of frames, ``along_m`` with ``half_width_m``.
    ``on_deck_kg`` and ``velocity_m_per_s`` (of the material along the deck) are means over the output times
    of a window, and NaN for a window without one; they are missing in a run without a deck or particles.
    Returns None for a run of less than three windows.
    """
    edges_s = run.edges_s[(len(run.edges_s) - 1) % WINDOW_CYCLES :: WINDOW_CYCLES]
    windows = list(pairwise(edges_s))
    if len(windows) < FEWEST_WINDOWS:
        return None
    time_s, pairs_m = run.series_s(), relative_motions_m(run)
    relative = {}
    for name, place_m in pairs_m.items():
        along_m = place_m @ run.deck_axes[:, :1]
        fits = [
            first_harmonic(time_s, along_m, run.turn_s(*window), *window, interval_of) for window in windows
        ]
        relative[name] = PairInTime(
            along_m=[float(fit.amplitude[0]) for fit in fits],
            half_width_m=np.array(
                [np.nan if fit.half_width is None else fit.half_width[0] for fit in fits], dtype=float
            ),
        )
    return Course(end_s=edges_s[1:], relative=relative, **_load(run, windows))


def _load(run: RunReader, windows: list[tuple[float, float]]) -> dict[str, Array]:
    """Return the mean mass on the deck and its velocity in each window; nothing without a deck."""
    if not run.has("profile"):
        return {}
    time_s = run.read("profile/time_s")
    mass_kg, velocity_m_per_s = (
        np.nan_to_num(run.read(f"profile/{name}")) for name in ("mass_kg", "velocity_m_per_s")
    )
    inside = [within(time_s, start_s, end_s, run.cycle_s) for start_s, end_s in windows]
    mass = np.array([_mean(mass_kg[rows].sum(axis=1)) for rows in inside])
    momentum = np.array([_mean((mass_kg * velocity_m_per_s)[rows].sum(axis=1)) for rows in inside])
    velocity = np.divide(momentum, mass, out=np.full(len(mass), np.nan), where=mass > 0)
    return {"on_deck_kg": mass, "velocity_m_per_s": velocity}


def _mean(values: Array) -> float:
    """Return the mean; NaN of nothing."""
    return float(values.mean()) if len(values) else np.nan
