"""The C++ bridge to LIGGGHTS (``bridge/module.cpp``): one LIGGGHTS instance in this process.

Errors of LIGGGHTS are RuntimeError.  All calls are collective, all results this rank's own.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array

Ints = npt.NDArray[np.int32]

class Engine:
    def __init__(
        self, communicator: int, screen_file: str, log_file: str, contact_distance_factor: float
    ) -> None:
        """``communicator`` is a Fortran handle (mpi4py: ``py2f()``)."""

    def command(self, line: str) -> None: ...
    def set_surface(
        self, position_m: Array, triangles: Ints, type: Ints, largest_radius_m: float
    ) -> None: ...
    def set_laws(
        self,
        e_star_Pa: list[float],
        g_star_Pa: list[float],
        tangential_spring: bool,
        adhesion: str,
        strength: list[float],
    ) -> None:
        """Tables row by row (types x types); ``adhesion`` is "none", "jkr" with ``strength`` in
        J/m2, or "sjkr" with it in J/m3."""

    def set_wear(self, rate_m3_per_N_m: list[float]) -> None:
        """From now on contacts wear the surface; a table row by row (types x types)."""

    def create(
        self,
        position_m: Array,
        velocity_m_per_s: Array,
        spin_rad_per_s: Array,
        diameter_m: Array,
        density_kg_per_m3: Array,
        type: Ints,
        first_id: int,
    ) -> None:
        """Each rank creates the particles whose place it owns."""

    def repeat_surface(self, period_m: float, joined: Ints) -> None:
        """The surface goes on after a period along y; ``joined`` (m, 3): the triangles again, with
        one number for points that are one period apart and the same place."""

    def set_exits(self, center_m: Array, axes: Array, half_m: Array, domain_m: Array) -> None:
        """Boxes (n, 3), (n, 3, 3), (n, 3) that take particles out, and the domain (2, 3)."""

    def take_removed(self) -> dict[str, npt.NDArray[Any]]:
        """Those of this rank taken out during the last ``run``: x (at the end of the step), v (half
        a step before), omega (n, 3), radius, rmass, density, type, tag, exit (-1: left the domain)
        and step of that run, from 1, (n,)."""

    def overlaps(self, position_m: Array, diameter_m: Array) -> list[bool]:
        """Which places overlap the surface, where it is now, or a particle of this rank."""

    def store_history(self) -> None:
        """To be called before ``create`` once the first step was made."""

    def prepare(self) -> None:
        """To be called after it: neighbour lists and forces."""

    def begin_path(
        self,
        start_m: Array,
        start_m_per_s: Array,
        end_m: Array,
        end_m_per_s: Array,
        length_s: float,
        steps: int,
    ) -> None: ...
    def run(self, steps: int, step_s: float) -> None: ...
    def save(self) -> dict[str, npt.NDArray[Any]]:
        """Between runs: this rank's part of all that the next ones depend on, to the last bit."""

    def restore(self, arrays: dict[str, npt.NDArray[Any]]) -> None:
        """Back to there, also in another instance with the same input, surface and ranks."""

    def particles(self) -> dict[str, npt.NDArray[Any]]:
        """Views of LIGGGHTS's memory: x, v, omega, f, torque (n, 3), radius, rmass, density, type,
        tag (n,); valid until the next call that moves particles."""

    def impulse_N_s(self) -> Array:
        """On each surface point (points, 3) during the last ``run``."""

    def force_N(self) -> Array:
        """On each surface point (points, 3) in the last force evaluation."""

    def ask_response(self) -> None:
        """To be called before the first force evaluation by who will want ``response``."""

    def response(self, length_s: float) -> tuple[Array, Array]:
        """This rank's part of ``orchestrator.ports.Response``: (points, 3) and (3 * points, 3)."""

    def worn_m3(self) -> Array:
        """(points,) since t = 0; empty without ``set_wear``."""

    def angular_impulse_N_m_s(self) -> Array:
        """(3,) about the world's origin, of all forces of this rank's particles on the surface
        points since t = 0."""

    def mass_moment_time_kg_m_s(self) -> Array:
        """(3,) integral over time since t = 0 of the sum of mass times place of this rank's
        particles."""

    def surface_work_J(self) -> float:
        """Done by the surface on the particles since t = 0."""

    def surface_energy_J(self) -> tuple[float, float]:
        """Elastic energy and (negative) energy of adhesion in contacts with the surface."""

    def take_deepest_overlaps(self) -> tuple[float, float, float, float]:
        """Of this rank's contacts in all force evaluations since this was last asked: overlap and
        its share of a diameter, between particles and with the surface."""

    def take_crossings(self) -> dict[str, npt.NDArray[Any]]:
        """Particles of this rank whose centre went through a triangle since this was last asked:
        tag, step of the last ``run``, from 1, (n,), and x (n, 3) at the end of that step."""

    def surface_contacts(self) -> int: ...
    def pair_energy_J(self) -> tuple[float, float]:
        """The same between particles; a contact with another rank's particle counts half."""
