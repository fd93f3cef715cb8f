"""The rows of ``loads/<frame>``: all forces on a frame at one moment, with their places."""

from __future__ import annotations

import numpy as np

from orchestrator.coupling.machine import Machine
from orchestrator.output.records.history import History
from orchestrator.output.records.series import rotations_rad
from orchestrator.ports import Array, Indices
from orchestrator.ports.frames import find_frame_loads

CLAMP, STOP, WALL, BUSHING, EXCITER = "clamp", "stop", "wall", "bushing", "exciter"
"""The kinds of forces.  A force's name is its kind, the name of its part and its number there."""


class FrameLoadRecord:
    """The writer of the forces on each frame; nothing is written for frames that do not tell their forces."""

    def __init__(self, machine: Machine, history: History) -> None:
        self._machine, self._history = machine, history
        mount = machine.members.panel.mount
        self._points, self._names = np.array(mount.frame), _names_of_points(machine, len(mount.frame))

    def describe(self, exciters: dict[str, str]) -> None:
        """Write the names of the forces of each frame; ``exciters`` has the frame of each exciter by name."""
        bushings = self._machine.bushings
        excited = np.array(list(exciters.values()))
        self._rows: list[tuple[Indices, Indices, Indices, Indices]] = []
        for number, frame in enumerate(self._machine.frames):
            rows = (
                np.flatnonzero(self._points == frame),
                np.flatnonzero(bushings.first == number),
                np.flatnonzero(bushings.second == number),
                np.flatnonzero(excited == frame),
            )
            self._rows.append(rows)
            ends = np.concatenate(rows[1:3])
            names = [self._names[point] for point in rows[0]]
            names += [f"{BUSHING}/{bushings.names[each]}/1" for each in ends]
            names += [f"{EXCITER}/{list(exciters)[each]}/1" for each in rows[3]]
            self._history.describe(f"loads/{frame}", "names", names)

    def write_row(self, time_s: float) -> None:
        """Write the forces at a sync point after the first interval, before the next interval's reaction."""
        members = self._machine.members
        loads = find_frame_loads(members.frames)
        if loads is None:
            return
        reaction, carried = members.frames.last
        pose = members.frames.pose()
        turned_rad = rotations_rad(pose)
        for number, (frame, (points, first, second, exciters)) in enumerate(
            zip(self._machine.frames, self._rows, strict=True)
        ):
            force_N = [reaction.force_N[points], loads.bushing_N[first]]
            force_N += [-loads.bushing_N[second], loads.exciter_N[exciters]]
            place_m = [carried.position_m[points], loads.bushing_m[first]]
            place_m += [loads.bushing_m[second], loads.exciter_m[exciters]]
            row: dict[str, Array | float] = {
                "center_m": pose.position_m[number],
                "rotation_rad": turned_rad[number],
                "spin_rad_per_s": pose.spin_rad_per_s[number],
                "acceleration_m_per_s2": loads.acceleration_m_per_s2[number],
                "angular_acceleration_rad_per_s2": loads.angular_acceleration_rad_per_s2[number],
                "lag_N_m": loads.lag_N_m[number],
                "place_m": np.concatenate(place_m),
                "force_N": np.concatenate(force_N),
            }
            self._history.add(f"loads/{frame}", time_s, row)


def _names_of_points(machine: Machine, points: int) -> list[str]:
    """Return the name of each point at which a panel or a wall acts on the frames."""
    names = [f"{WALL}/walls/{point}" for point in range(1, points + 1)]
    for panel in machine.panels:
        for kind, part, numbers in (
            (CLAMP, f"{panel.name}-first", panel.first_clamp),
            (CLAMP, f"{panel.name}-second", panel.second_clamp),
            (STOP, panel.name, panel.stops),
        ):
            for place, point in enumerate(numbers, start=1):
                names[point] = f"{kind}/{part}/{place}"
    return names
