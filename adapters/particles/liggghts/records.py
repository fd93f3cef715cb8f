"""From LIGGGHTS's own arrays to the records of the port."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Crossings, ParticleSnapshot, Removed

Arrays = dict[str, npt.NDArray[Any]]
"""By LIGGGHTS's names, one row per particle of this rank; ``type`` counts from 1."""


def snapshot(mine: Arrays, communicator: Any) -> ParticleSnapshot:
    """Of all particles, in the order of their ids; without any on ranks but the first."""
    names = ("tag", "x", "v", "omega", "radius", "density", "type")
    ranks = communicator.gather([np.array(mine[name]) for name in names])
    if communicator.rank != 0:
        ranks = [[np.array(mine[name][:0]) for name in names]]
    tag, x, v, omega, radius, density, kind = map(np.concatenate, zip(*ranks, strict=True))
    order = np.argsort(tag)
    return ParticleSnapshot(
        id=tag[order].astype(np.int64),
        position_m=x[order],
        velocity_m_per_s=v[order],
        spin_rad_per_s=omega[order],
        diameter_m=2.0 * radius[order],
        density_kg_per_m3=density[order],
        material=kind[order].astype(np.int64) - 1,
    )


def removed(mine: Arrays, time_s: Array) -> Removed:
    """Of the particles that this rank took out, at ``time_s`` (n,)."""
    return Removed(
        id=mine["tag"].astype(np.int64),
        time_s=time_s,
        position_m=mine["x"],
        velocity_m_per_s=mine["v"],
        diameter_m=2.0 * mine["radius"],
        density_kg_per_m3=mine["density"],
        material=mine["type"].astype(np.int64) - 1,
        exit=mine["exit"].astype(np.int64),
    )


def crossings(mine: Arrays, start_s: float, step_s: float) -> Crossings:
    """Of the particles of this rank that went through the surface in an interval from ``start_s``
    on; of one step the lowest id counts as the first."""
    if not len(mine["tag"]):
        return Crossings.none()
    first = np.lexsort((mine["tag"], mine["step"]))[0]
    time_s = start_s + step_s * int(mine["step"][first])
    return Crossings(len(mine["tag"]), int(mine["tag"][first]), time_s, mine["x"][first])
