"""How fast material goes along the deck, and where and when it passes."""

from __future__ import annotations

import numpy as np

from orchestrator.output.results.events import Fed, Removed
from orchestrator.ports import Array


def residence_s(fed: Fed, removed: Removed) -> Array:
    """(removed,) time from entering to leaving; NaN for particles that were never fed."""
    order = np.argsort(fed.id)
    ids = fed.id[order]
    place = np.searchsorted(ids, removed.id)
    known = place < len(ids)
    known[known] = ids[place[known]] == removed.id[known]
    entered = np.full(len(removed.id), np.nan)
    entered[known] = fed.time_s[order][place[known]]
    return np.asarray(removed.time_s - entered)


def passing_kg_per_s_m(along_m: Array, mass_kg: Array, edges_m: Array, lasting_s: float) -> Array:
    """(bins,) mass passed per length of deck and time; what is outside ``edges_m`` counts to the
    nearest bin."""
    inside = np.clip(along_m, edges_m[0], edges_m[-1])
    passed = np.histogram(inside, edges_m, weights=mass_kg)[0]
    return np.asarray(passed / np.diff(edges_m) / lasting_s)
