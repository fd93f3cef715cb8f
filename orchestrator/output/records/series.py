"""The rows of the time series: motion of frames and probes, and forces of panels and bushings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from orchestrator.coupling._kernel import PointMatrix
from orchestrator.coupling.bushing_forces import frame_points
from orchestrator.coupling.machine import Machine, PlacedProbe
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.records.history import COLUMNS, Groups, History, groups
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot
from orchestrator.ports.frames import find_element_forces_N, find_shaft_angles_rad
from orchestrator.ports.state import SavedAttributes

ROWS = "rows"  # the group of rows from which those of the file are computed, many at once
FORCES = COLUMNS["forces"]


class PanelForces:
    """The sums of the forces over the points of each panel, its clamps and its stops."""

    def __init__(self, machine: Machine, start: State) -> None:
        self._panels = len(machine.panels)
        kinds = ("clamps", "first_clamp", "second_clamp", "stops")
        carried = [getattr(panel, kind) for kind in kinds for panel in machine.panels]
        self._loads = _sums([panel.surface for panel in machine.panels], len(start.load))
        self._reactions = _sums(carried, len(start.panel.reaction))

    def at(self, state: State) -> Array:
        """Return the mean forces (5, panels, 3) over the interval that ends here, in the order of FORCES."""
        load_N, reaction_N = state.load.force_N, state.panel.reaction.force_N
        sums_N = np.concatenate([self._loads.times(load_N), self._reactions.times(reaction_N)])
        return np.asarray(sums_N.reshape(len(FORCES), self._panels, 3))


def _sums(parts: Sequence[slice | Indices], points: int) -> PointMatrix:
    """Return the matrix (parts, points) whose product with vectors at points gives the sum of each part."""
    numbers = [np.arange(points)[part] for part in parts]
    starts = np.cumsum([0, *map(len, numbers)])
    inside = np.concatenate([np.empty(0, dtype=np.int64), *numbers])
    return PointMatrix(starts, inside, np.ones(len(inside)), points)


class TimeSeries(SavedAttributes):
    """The writer of the time series.

    A row has the motion of its moment, and the mean forces of the panels over the sync intervals since
    the last row, so that the series contain their whole impulse.
    """

    STATE: ClassVar = ("_sum_N", "_summed")

    def __init__(self, machine: Machine, start: State, history: History) -> None:
        self._machine, self._history = machine, history
        centres, self._points = frame_points(machine.centres)
        self._centres = np.fromiter(centres.values(), np.int64)
        self._start_m = start.clamps.position_m[self._points[self._centres]]
        self._sum_N: Array = np.zeros((len(FORCES), len(machine.panels), 3))
        self._summed = 0
        self._shafts = list(find_shaft_angles_rad(machine.members.frames))
        self._unstopped = {f"forces/{panel.name}" for panel in machine.panels if not len(panel.stops)}
        history.derived[ROWS] = self._groups

    def add_forces(self, forces_N: Array) -> None:
        """Add the forces of a sync interval, (5, panels, 3) in the order of FORCES."""
        self._sum_N += forces_N
        self._summed += 1

    def write_row(self, time_s: float, state: State, followed: ParticleSnapshot | None) -> None:
        """Write a row; ``followed`` are the particles if a probe follows one of them."""
        solver = self._machine.members.frames
        element_N = find_element_forces_N(solver)
        probes = [_probe_motion(probe, state, followed) for probe in self._machine.probes]
        row: dict[str, Array | float] = {
            "position_m": state.clamps.position_m[self._points],
            "velocity_m_per_s": state.clamps.velocity_m_per_s[self._points],
            "probes": np.array(probes).reshape(-1, 2, 3),
            "forces_N": self._sum_N / self._summed,
            "angle_rad": np.array(list(find_shaft_angles_rad(solver).values())),
        }
        self._history.add(ROWS, time_s, row if element_N is None else row | {"element_N": element_N})
        self._sum_N[:], self._summed = 0.0, 0

    def _groups(self, rows: Mapping[str, Array]) -> Groups:
        """Yield the groups of ``history.h5`` with their rows, from rows as ``write_row`` adds them."""
        machine, centres = self._machine, self._centres
        frames = Motion.unchecked(rows["position_m"], rows["velocity_m_per_s"])
        moved_m = frames.position_m[:, centres] - self._start_m
        of_frames = (moved_m, frames.velocity_m_per_s[:, centres], *rotations(frames, centres))
        bushings = machine.bushings.at(frames, rows.get("element_N"))
        probes, panels = ([one.name for one in every] for every in (machine.probes, machine.panels))
        for kind, names, values in (
            ("frames", machine.centres, of_frames),
            ("probes", probes, np.moveaxis(rows["probes"], 2, 0)),
            ("bushings", machine.bushings.names, bushings),
            ("forces", panels, np.moveaxis(rows["forces_N"], 1, 0)),
            ("shafts", self._shafts, rows["angle_rad"][None]),
        ):
            by_name = {c: np.moveaxis(v, 1, 0) for c, v in zip(COLUMNS[kind], values, strict=True)}
            for group, of_group in groups(kind, names, by_name):
                if group in self._unstopped:
                    del of_group["stops_N"]
                yield group, of_group


def rotations(carried: Motion, centres: Indices) -> tuple[Array, Array]:
    """Return the frames' rotation vectors since t = 0 in rad and their angular velocities in rad/s.

    Both are (frames, 3), in world axes.  ``centres`` (frames,) are the point numbers of the centres of mass.
    The three points after each centre are the ends of arms that are 1 m long and lie along the world's axes
    at t = 0 (``coupling/surface_parts.py``).  All arrays may have a leading axis of moments.
    """
    shape = (*carried.position_m.shape[:-2], len(centres), 3)
    if not prod(shape):  # Rotation refuses empty arrays
        return np.empty(shape), np.empty(shape)
    ends = centres[:, None] + np.arange(1, 4)
    arms_m, rates_m_per_s = (
        value[..., ends, :] - value[..., centres, None, :]
        for value in (carried.position_m, carried.velocity_m_per_s)
    )
    turns = np.swapaxes(arms_m, -1, -2).reshape(-1, 3, 3)
    rotation_rad = Rotation.from_matrix(turns).as_rotvec().reshape(shape)
    # for orthonormal arms a:  sum of a x (spin x a) = 2 spin
    (x, y, z), (u, v, w) = np.moveaxis(arms_m, -1, 0), np.moveaxis(rates_m_per_s, -1, 0)
    products = np.stack([y * w - z * v, z * u - x * w, x * v - y * u], axis=-1)  # quicker than np.cross
    return rotation_rad, products.sum(axis=-2) / 2


def _probe_motion(probe: PlacedProbe, state: State, followed: ParticleSnapshot | None) -> tuple[Array, Array]:
    """Return the position and the velocity (3,) of a probe; NaN if its particle is not present."""
    motion: Motion | ParticleSnapshot = state.clamps if probe.on == "clamps" else state.panel.surface
    index = probe.index
    if probe.on == "particle":
        if followed is None or probe.index not in followed.id:
            return np.full(3, np.nan), np.full(3, np.nan)
        motion, index = followed, int(np.flatnonzero(followed.id == probe.index)[0])
    return motion.position_m[index], motion.velocity_m_per_s[index]
