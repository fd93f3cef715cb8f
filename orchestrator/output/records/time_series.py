"""Rows of the time series in ``history.h5``: motion of frames and probes, forces of panels and
bushings."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.coupling.machine import Machine, Probe
from orchestrator.coupling.schemes.exchange import State
from orchestrator.output.records.frame_rotation import rotations
from orchestrator.output.records.history import History
from orchestrator.output.records.panel_forces import FORCES
from orchestrator.ports import Array, Motion, ParticleSnapshot, Saved
from orchestrator.ports.state import put_back, taken


class TimeSeries:
    """Motion in a row is that of the moment; panel forces are means over the sync intervals since
    the last row, so that none of their impulse is missed."""

    def __init__(self, machine: Machine, start: State, history: History) -> None:
        self._machine, self._start, self._history = machine, start, history
        self._centres = np.fromiter(machine.centres.values(), np.int64)
        self._sum_N: Array = np.zeros((len(FORCES), len(machine.panels), 3))
        self._summed = 0

    def sync_point(self, forces_N: Array) -> None:
        """Takes note of an interval's forces, (5, panels, 3) in the order of FORCES."""
        self._sum_N += forces_N
        self._summed += 1

    def row(self, time_s: float, state: State, followed: ParticleSnapshot | None) -> None:
        """``followed``: the particles, where probes ask for them."""
        self._frames(time_s, state)
        for probe in self._machine.probes:
            position, velocity = _at(probe, state, followed)
            values = {"position_m": position, "velocity_m_per_s": velocity}
            self._history.add(f"probes/{probe.name}", time_s, values)
        stretched = self._machine.bushings.at(state.clamps)
        for name, *row in zip(self._machine.bushings.names, *stretched, strict=True):
            values = dict(zip(("deformation_m", "force_N"), row, strict=True))
            self._history.add(f"bushings/{name}", time_s, values)
        mean_N = self._sum_N / self._summed
        for number, panel in enumerate(self._machine.panels):
            values = dict(zip(FORCES, mean_N[:, number], strict=True))
            if not len(panel.stops):
                del values["stops_N"]
            self._history.add(f"forces/{panel.name}", time_s, values)
        self._sum_N[:], self._summed = 0.0, 0

    def save(self) -> Saved:
        return taken(self, "_sum_N", "_summed")

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, "_sum_N", "_summed")

    def _frames(self, time_s: float, state: State) -> None:
        clamps, points = state.clamps, self._centres
        moved = clamps.position_m[points] - self._start.clamps.position_m[points]
        rows = (moved, clamps.velocity_m_per_s[points], *rotations(clamps, points))
        names = ("displacement_m", "velocity_m_per_s", "rotation_rad", "spin_rad_per_s")
        for frame, *row in zip(self._machine.centres, *rows, strict=True):
            values = dict(zip(names, row, strict=True))
            self._history.add(f"frames/{frame}", time_s, values)


def _at(probe: Probe, state: State, followed: ParticleSnapshot | None) -> tuple[Any, Any]:
    """Position and velocity (3,) of a probe; NaN for a particle that has left, or
    where particles are left out."""
    if probe.on == "particle":
        gone = np.full(3, np.nan), np.full(3, np.nan)
        if followed is None:
            return gone
        row = np.flatnonzero(followed.id == probe.index)
        if len(row) == 0:
            return gone
        return followed.position_m[row[0]], followed.velocity_m_per_s[row[0]]
    motion: Motion = state.clamps if probe.on == "clamps" else state.panel.surface
    return motion.position_m[probe.index], motion.velocity_m_per_s[probe.index]
