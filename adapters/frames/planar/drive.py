"""A body that a drive moves in the plane: its coordinates at any times, exactly."""

from __future__ import annotations

import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.drive import shifted, turned
from adapters.frames.planar.plane import in_plane
from orchestrator.ports import Array
from orchestrator.ports.plans import Body, Drive, FramesPlan


def planar_drives(plan: FramesPlan) -> list[PlanarDrive]:
    """Raises ValueError for drives that make no sense or leave the plane."""
    numbered = zip(linear.driven(plan), plan.drives, strict=True)
    return [PlanarDrive(int(n), plan.bodies[n], drive) for n, drive in numbered]


class PlanarDrive:
    """Raises ValueError for a drive that leaves the plane."""

    def __init__(self, number: int, body: Body, drive: Drive) -> None:
        across = (drive.amplitude_m[1], *drive.rotation_rad[[0, 2]])
        if any(across):
            raise ValueError(
                f"the drive of {drive.body!r} leaves the vertical plane, to which planar frames "
                "are bound; exudyn and prescribed know no such bounds"
            )
        self.body, self._drive = number, drive
        self._arm_m = in_plane(body.center_of_mass_m - drive.center_m)

    def coordinates(self, time_s: Array) -> tuple[Array, Array]:
        """Displacement of the centre of mass up and along, and angle; and their rates: (times,
        3) each."""
        shift_m, shift_m_per_s = (in_plane(one) for one in shifted(self._drive, time_s))
        angle_rad, spin_rad_per_s = (one[:, 1] for one in turned(self._drive, time_s))
        moved_m = shift_m + np.expm1(1j * angle_rad) * self._arm_m
        velocity_m_per_s = shift_m_per_s + 1j * spin_rad_per_s * np.exp(1j * angle_rad) * self._arm_m
        place = np.stack([moved_m.real, moved_m.imag, angle_rad], axis=1)
        return place, np.stack([velocity_m_per_s.real, velocity_m_per_s.imag, spin_rad_per_s], axis=1)
