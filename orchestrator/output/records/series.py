"""Rows of the time series: motion of frames and probes, forces of panels and bushings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from orchestrator.coupling.machine import Machine, PlacedProbe
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.records.history import History
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot
from orchestrator.ports.state import SavedAttributes

FORCES = ("load_N", "reaction_N", "first_clamp_N", "second_clamp_N", "stops_N")


class PanelForces:
    """Sums over the points of a panel, its clamps and its stops."""

    def __init__(self, machine: Machine, start: State) -> None:
        self._panels = len(machine.panels)
        kinds = ("clamps", "first_clamp", "second_clamp", "stops")
        carried = [getattr(panel, kind) for kind in kinds for panel in machine.panels]
        self._loads = _sums([panel.surface for panel in machine.panels], len(start.load))
        self._reactions = _sums(carried, len(start.panel.reaction))

    def at(self, state: State) -> Array:
        """Return (5, panels, 3), in the order of FORCES: means over the interval that ends here."""
        load_N, reaction_N = state.load.force_N, state.panel.reaction.force_N
        sums_N = np.vstack([self._loads @ load_N, self._reactions @ reaction_N])
        return np.asarray(sums_N.reshape(len(FORCES), self._panels, 3))


def _sums(parts: Sequence[slice | Indices], points: int) -> csr_array:
    """Return (parts, points): sums over the points of each part, all in one product."""
    numbers = [np.arange(points)[part] for part in parts]
    starts = np.cumsum([0, *map(len, numbers)])
    inside = np.concatenate([np.empty(0, dtype=np.int64), *numbers])
    return csr_array((np.ones(len(inside)), inside, starts), shape=(len(parts), points))


class TimeSeries(SavedAttributes):
    """Writes rows in which motion is that of the moment, and panel forces are means over the sync
    intervals since the last row, so that none of their impulse is missed."""

    STATE: ClassVar = ("_sum_N", "_summed")

    def __init__(self, machine: Machine, start: State, history: History) -> None:
        self._machine, self._start, self._history = machine, start, history
        self._sum_N: Array = np.zeros((len(FORCES), len(machine.panels), 3))
        self._summed = 0

    def sync_point(self, forces_N: Array) -> None:
        """Take note of an interval's forces, (5, panels, 3) in the order of FORCES."""
        self._sum_N += forces_N
        self._summed += 1

    def row(self, time_s: float, state: State, followed: ParticleSnapshot | None) -> None:
        """Write a row; ``followed`` are the particles, where probes ask for them."""
        machine, history = self._machine, self._history
        history.add_each("frames", time_s, machine.centres, self._frames(state.clamps))
        for probe in machine.probes:
            position_m, velocity_m_per_s = _probe_motion(probe, state, followed)
            values = {"position_m": position_m, "velocity_m_per_s": velocity_m_per_s}
            history.add(f"probes/{probe.name}", time_s, values)
        deformation_m, force_N = machine.bushings.at(state.clamps)
        columns = {"deformation_m": deformation_m, "force_N": force_N}
        history.add_each("bushings", time_s, machine.bushings.names, columns)
        mean_N = self._sum_N / self._summed
        for number, panel in enumerate(machine.panels):
            forces_N = dict(zip(FORCES, mean_N[:, number], strict=True))
            if not len(panel.stops):
                del forces_N["stops_N"]
            history.add(f"forces/{panel.name}", time_s, forces_N)
        self._sum_N[:], self._summed = 0.0, 0

    def _frames(self, clamps: Motion) -> dict[str, Array]:
        centres = np.fromiter(self._machine.centres.values(), np.int64)
        rotation_rad, spin_rad_per_s = rotations(clamps, centres)
        return {
            "displacement_m": clamps.position_m[centres] - self._start.clamps.position_m[centres],
            "velocity_m_per_s": clamps.velocity_m_per_s[centres],
            "rotation_rad": rotation_rad,
            "spin_rad_per_s": spin_rad_per_s,
        }


def rotations(carried: Motion, centres: Indices) -> tuple[Array, Array]:
    """Return rotation vectors since t = 0 in rad and angular velocities in rad/s, (frames, 3) each, in
    the world.

    ``centres`` (frames,): numbers of the centres of mass; the three points after each are the ends
    of arms that were 1 m long and lay along the world's axes at t = 0 (``coupling/surface_parts.py``).
    """
    if not len(centres):  # which Rotation does not take
        return np.empty((0, 3)), np.empty((0, 3))
    ends = centres[:, None] + np.arange(1, 4)
    arms_m, rates_m_per_s = (
        value[ends] - value[centres][:, None] for value in (carried.position_m, carried.velocity_m_per_s)
    )
    rotation_rad = Rotation.from_matrix(arms_m.transpose(0, 2, 1)).as_rotvec()
    # for orthonormal arms a:  sum of a x (spin x a) = 2 spin
    return rotation_rad, np.cross(arms_m, rates_m_per_s).sum(axis=1) / 2


def _probe_motion(probe: PlacedProbe, state: State, followed: ParticleSnapshot | None) -> tuple[Array, Array]:
    """Return position and velocity (3,); NaN for a particle that has left or was left out."""
    motion: Motion | ParticleSnapshot = state.clamps if probe.on == "clamps" else state.panel.surface
    index = probe.index
    if probe.on == "particle":
        if followed is None or probe.index not in followed.id:
            return np.full(3, np.nan), np.full(3, np.nan)
        motion, index = followed, int(np.flatnonzero(followed.id == probe.index)[0])
    return motion.position_m[index], motion.velocity_m_per_s[index]
