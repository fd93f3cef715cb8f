"""The rows of the time series: motion of frames and probes, and forces of panels and bushings."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from math import prod
from typing import ClassVar

import numpy as np
from scipy.spatial.transform import Rotation

from orchestrator.coupling._kernel import PointMatrix
from orchestrator.coupling.machine import Machine, PlacedProbe
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.records.history import COLUMNS, Groups, History, groups
from orchestrator.ports import Array, Indices, Motion, ParticleSnapshot, Pose
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
        self._start_m = machine.members.frames.pose().position_m
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
        pose = solver.pose()
        probes = [_probe_motion(probe, state, pose, followed) for probe in self._machine.probes]
        row: dict[str, Array | float] = {
            **vars(pose),
            "probes": np.array(probes).reshape(-1, 2, 3),
            "forces_N": self._sum_N / self._summed,
            "angle_rad": np.array(list(find_shaft_angles_rad(solver).values())),
        }
        self._history.add(ROWS, time_s, row if element_N is None else row | {"element_N": element_N})
        self._sum_N[:], self._summed = 0.0, 0

    def _groups(self, rows: Mapping[str, Array]) -> Groups:
        """Yield the groups of ``history.h5`` with their rows, from rows as ``write_row`` adds them."""
        machine = self._machine
        pose = Pose(**{each.name: rows[each.name] for each in fields(Pose)})
        moved_m = pose.position_m - self._start_m
        of_frames = (moved_m, pose.velocity_m_per_s, rotations_rad(pose), pose.spin_rad_per_s)
        bushings = machine.bushings.at(pose, rows.get("element_N"))
        probes, panels = ([one.name for one in every] for every in (machine.probes, machine.panels))
        for kind, names, values in (
            ("frames", machine.frames, of_frames),
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


def rotations_rad(pose: Pose) -> Array:
    """Return the frames' rotation vectors since t = 0 in rad, (frames, 3), in world axes.

    There may be a leading axis of moments.
    """
    shape = pose.position_m.shape
    if not prod(shape):  # Rotation refuses empty arrays
        return np.empty(shape)
    return np.reshape(Rotation.from_matrix(pose.rotation.reshape(-1, 3, 3)).as_rotvec(), shape)


def _probe_motion(
    probe: PlacedProbe, state: State, pose: Pose, followed: ParticleSnapshot | None
) -> tuple[Array, Array]:
    """Return the position and the velocity (3,) of a probe; NaN if its particle is not present."""
    if probe.on == "frame":
        position_m, velocity_m_per_s = pose.carried(np.array([probe.index]), probe.arm_m[None])
        return position_m[0], velocity_m_per_s[0]
    motion: Motion | ParticleSnapshot = state.panel.surface
    index = probe.index
    if probe.on == "particle":
        if followed is None or probe.index not in followed.id:
            return np.full(3, np.nan), np.full(3, np.nan)
        motion, index = followed, int(np.flatnonzero(followed.id == probe.index)[0])
    return motion.position_m[index], motion.velocity_m_per_s[index]
