"""Rows of the time series: motion of frames and probes, forces of panels and bushings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from orchestrator.coupling.machine import Machine, PlacedProbe
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.records.history import History
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot
from orchestrator.ports.state import SavedAttributes

ARMS = np.arange(1, 4)


def rotations(carried: Motion, centres: Indices) -> tuple[Array, Array]:
    """Returns rotation vectors since t = 0 in rad and angular velocities in rad/s, (frames, 3) each, in
    the world.

    ``centres`` (frames,): numbers of the centres of mass; the three points after each are the ends
    of arms that were 1 m long and lay along the world's axes at t = 0 (``surface_parts.frame_parts``).
    """
    if not len(centres):  # which Rotation does not take
        return np.empty((0, 3)), np.empty((0, 3))
    ends = centres[:, None] + ARMS
    arms_m, rates_m_per_s = (
        value[ends] - value[centres][:, None] for value in (carried.position_m, carried.velocity_m_per_s)
    )
    rotation_rad = Rotation.from_matrix(arms_m.transpose(0, 2, 1)).as_rotvec()
    # for orthonormal arms a:  sum of a x (spin x a) = 2 spin
    return rotation_rad, np.cross(arms_m, rates_m_per_s).sum(axis=1) / 2


FORCES = ("load_N", "reaction_N", "first_clamp_N", "second_clamp_N", "stops_N")


class PanelForces:
    """Sums over the points of a panel, its clamps and its stops."""

    def __init__(self, machine: Machine, start: State) -> None:
        self._panels = len(machine.panels)
        kinds = ("clamps", "first_clamp", "second_clamp", "stops")
        held = [getattr(panel, kind) for kind in kinds for panel in machine.panels]
        self._loads = _sums([panel.surface for panel in machine.panels], len(start.load))
        self._reactions = _sums(held, len(start.panel.reaction))

    def at(self, state: State) -> Array:
        """Returns (5, panels, 3), in the order of FORCES: means over the interval that ends here."""
        load_N, reaction_N = state.load.force_N, state.panel.reaction.force_N
        sums_N = np.vstack([self._loads @ load_N, self._reactions @ reaction_N])
        return np.asarray(sums_N.reshape(len(FORCES), self._panels, 3))


def _sums(parts: Sequence[slice | Indices], points: int) -> csr_array:
    """(parts, points): sums over the points of each part, all in one product."""
    numbers = [np.arange(points)[part] for part in parts]
    starts = np.cumsum([0, *map(len, numbers)])
    inside = np.concatenate([np.empty(0, dtype=np.int64), *numbers])
    return csr_array((np.ones(len(inside)), inside, starts), shape=(len(parts), points))


class TimeSeries(SavedAttributes):
    """Motion in a row is that of the moment; panel forces are means over the sync intervals since
    the last row, so that none of their impulse is missed."""

    STATE: ClassVar = ("_sum_N", "_summed")

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
        """Writes a row; ``followed`` are the particles, where probes ask for them."""
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

    def _frames(self, time_s: float, state: State) -> None:
        clamps, points = state.clamps, self._centres
        moved = clamps.position_m[points] - self._start.clamps.position_m[points]
        rows = (moved, clamps.velocity_m_per_s[points], *rotations(clamps, points))
        names = ("displacement_m", "velocity_m_per_s", "rotation_rad", "spin_rad_per_s")
        for frame, *row in zip(self._machine.centres, *rows, strict=True):
            values = dict(zip(names, row, strict=True))
            self._history.add(f"frames/{frame}", time_s, values)


def _at(probe: PlacedProbe, state: State, followed: ParticleSnapshot | None) -> tuple[Any, Any]:
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
