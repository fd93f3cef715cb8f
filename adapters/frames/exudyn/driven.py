"""A driven body among free ones: steered so that every step ends where its drive says.

A trapezoidal step evaluates forces at its end only (those of its start are in the stored
accelerations).  So a driven body may start each step wherever it takes to *coast*, without
acceleration, into its exact position with its exact velocity; and it is made so heavy that
nothing turns it from that path (``multibody.HEAVY_kg``).  What bushings and their dampers see of
it is then the drive's motion to rounding, and no constraint has to be solved.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import exudyn
import numpy as np

from adapters.frames.common.drive import driving
from adapters.frames.common.poses import turning
from orchestrator.ports import Array
from orchestrator.ports.plans import Body, Drive


class Driven:
    """``body``: its number among the bodies.

    Raises ValueError if the rotation vector could grow beyond ``largest_tilt_rad``, where the
    rotation angles end.
    """

    def __init__(self, number: int, body: Body, drive: Drive, largest_tilt_rad: float) -> None:
        self.body, self._drive = number, drive
        self._drawn_m = body.center_of_mass_m
        largest_rad = float(np.linalg.norm(drive.rotation_rad))
        if largest_rad > largest_tilt_rad:
            raise ValueError(
                f"the drive of {drive.body!r} may turn it by {largest_rad:.3g} rad; the limit is "
                f"{largest_tilt_rad:g} rad"
            )

    def coordinates(self, time_s: float) -> tuple[Array, Array]:
        """Displacement of the centre of mass with Tait-Bryan angles, and their rates: (6,) each,
        as ``Poses.of`` reads them."""
        now = driving(self._drive, time_s)
        position_m, velocity_m_per_s = now.carried((self._drawn_m - self._drive.center_m)[None])
        angles_rad = now.rotation.as_euler("XYZ")
        axes = turning(angles_rad[None])[1][0]
        rates_rad_per_s = np.linalg.solve(axes, now.spin_rad_per_s)
        place = np.concatenate([position_m[0] - self._drawn_m, angles_rad])
        return place, np.concatenate([velocity_m_per_s[0], rates_rad_per_s])

    def steer(self, data: Any, step_s: float, end_s: float) -> None:
        """Put the body, in Exudyn's system data, where the coming step starts for it."""
        place, rate = self.coordinates(end_s)
        for get, put, value in (
            (data.GetODE2Coordinates, data.SetODE2Coordinates, place - step_s * rate),
            (data.GetODE2Coordinates_t, data.SetODE2Coordinates_t, rate),
            (data.GetODE2Coordinates_tt, data.SetODE2Coordinates_tt, 0.0),
        ):
            coordinates = get()
            coordinates[6 * self.body : 6 * self.body + 6] = value
            put(coordinates)


def place_at_start(data: Any, every: Sequence[Driven], bodies: int) -> None:
    """At t = 0, by the initial values from which Exudyn finds the first accelerations."""
    places, rates = np.zeros((2, bodies, 6))
    for driven in every:
        places[driven.body], rates[driven.body] = driven.coordinates(0.0)
    data.SetODE2Coordinates(places.ravel(), exudyn.ConfigurationType.Initial)
    data.SetODE2Coordinates_t(rates.ravel(), exudyn.ConfigurationType.Initial)
