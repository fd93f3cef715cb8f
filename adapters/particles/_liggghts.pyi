"""The C++ bridge to LIGGGHTS (``bridge/module.cpp``): one LIGGGHTS instance in this process.

Every function of several arguments takes them by keyword alone.  Arrays are of float64 or int32,
rows one after the other; another kind is a TypeError, and ValueError names one of another shape.
Errors of LIGGGHTS are RuntimeError.  All calls are collective, all results this rank's own.
"""

from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Indices

Ints = npt.NDArray[np.int32]

class Engine:
    def __init__(
        self,
        *,
        communicator: int,
        screen_file: str,
        log_file: str,
        contact_distance_factor: float,
        class_ratio: float,
        as_packaged: bool = False,
    ) -> None:
        """``communicator`` is a Fortran handle (mpi4py: ``py2f()``).  ``as_packaged`` takes the contact
        models that the package has, uncured, in a process whose engines are all so; it lacks ``jkr``."""

    def command(self, line: str) -> None:
        """Execute one line of LIGGGHTS input."""

    def set_surface(
        self,
        *,
        position_m: Array,
        rigid_first: Ints,
        rigid_share: Array,
        triangles: Ints,
        type: Ints,
        largest_radius_m: float,
    ) -> None:
        """Set the points (n, 3), the vertices of rigid surfaces (v,) and (v, 3) as ``RigidVertices`` has
        them, the triangles (m, 3) of vertices, the points first, and their materials' types (m,), from 1."""

    def set_laws(
        self,
        *,
        e_star_Pa: Array,
        g_star_Pa: Array,
        tangential_spring: bool,
        work_J_per_m2: Array,
        energy_density_J_per_m3: Array,
    ) -> None:
        """Set the tables (types, types) by which energy in contacts is computed: of adhesion the one
        of jkr, the one of sjkr, or none; the others are empty."""

    def set_rebound(self, *, type: int, other_type: int, speed_m_per_s: Array, restitution: Array) -> None:
        """Let the restitution of two types, from 1, go by the speed of approach, by points (n,).

        The call comes before the input names a contact model."""

    def set_wear(self, rate_m3_per_N_m: Array) -> None:
        """Let contacts wear the surface from now on, by a table (types, types)."""

    def create(
        self,
        *,
        position_m: Array,
        velocity_m_per_s: Array,
        spin_rad_per_s: Array,
        diameter_m: Array,
        density_kg_per_m3: Array,
        type: Ints,
        first_id: int,
    ) -> None:
        """Create particles; each rank takes those whose place it owns."""

    def set_shapes(
        self,
        *,
        count: Ints,
        spheres: Array,
        volume: Array,
        inertia: Array,
        bounding_radius: Array,
        reach_m: float,
    ) -> None:
        """Let particles be bodies, whose motion is `fix motion all bodies/flipflow`: of each shape (k,) the
        number of its spheres, which follow each other in (n, 4), and the numbers of ``Shape``.  ``reach_m``:
        how far from the centre of the largest body spheres reach at most."""

    def create_bodies(
        self,
        *,
        position_m: Array,
        velocity_m_per_s: Array,
        spin_rad_per_s: Array,
        size_m: Array,
        density_kg_per_m3: Array,
        type: Ints,
        shape: Ints,
        turn: Array,
        first_id: int,
    ) -> None:
        """Create bodies, (n,) and (n, 3) each, turned by quaternions (n, 4), with ids in order from
        ``first_id``."""

    def bodies(self) -> dict[str, Any]:
        """Return copies of this rank's bodies: tag, shape, type, size, density, rmass (n,), x, v, omega, f,
        angular_momentum (n, 3) and turn (n, 4), the quaternion from the principal axes to the world."""

    def repeat_surface(self, *, period_m: float, joined_triangles: Ints) -> None:
        """Repeat the surface after a period along y; ``joined_triangles`` (m, 3) are the triangles
        with one number for vertices that are one period apart and the same place."""

    def set_exits(
        self, *, center_m: Array, axes: Array, half_m: Array, domain_m: Array, below_deck: Ints, deck: Ints
    ) -> None:
        """Set the boxes (n, 3), (n, 3, 3), (n, 3) that take particles out, and the domain (2, 3)."""

    def set_deck(
        self,
        *,
        along: Array,
        across: Array,
        points: Ints,
        panel: Ints,
        station_m: Array,
        open_m: Array,
        reach_m: float,
        half_depth_m: Array,
        on_deck: Ints,
    ) -> None:
        """Count contacts with a deck, from before the first particle: the fields of ``DeckPlan``, and of
        each triangle (m,) whether touching it is a contact with the deck."""

    def tally(self) -> Indices:
        """Return four numbers of particles of this rank: present ones, those of them whose place or velocity
        is not a number, those removed and those that went through the surface, until these are taken."""

    def take_removed(self) -> dict[str, npt.NDArray[Any]]:
        """Return those of this rank taken out during the last ``run``: x (at the end of the step), v
        (half a step before), omega (n, 3), radius, rmass, density, type, tag, exit (-1: left the
        domain) and step of that run, from 1, (n,); and deck (n, 1 + 3 panels): the panel of the last contact,
        or -1, then for each panel its contacts, then the seconds over each and those within reach of it."""

    def overlaps(self, *, position_m: Array, diameter_m: Array) -> list[bool]:
        """Tell which places overlap the surface, where it is now, or a particle of this rank."""

    def store_history(self) -> None:
        """Bring contact history to safety before ``create``, once the first step was made."""

    def prepare(self) -> None:
        """List neighbours and evaluate forces after ``create``."""

    def cuts(self) -> list[list[float]]:
        """Return where the box is cut into the ranks' parts: along x, y and z the fractions of its side at
        which parts begin and end, from 0 to 1."""

    def cut(self, cuts: list[list[float]]) -> None:
        """Cut the box elsewhere, alike on every rank, while there are no particles."""

    def cut_later(self, cuts: list[list[float]]) -> None:
        """Cut the box elsewhere when particles are next handed to other ranks.

        They go to ranks side by side only: each cut must stay between those that are now beside it.
        """

    def box_m(self) -> Array:
        """Return the lowest and the highest corner (2, 3) of the box that is cut."""

    def begin_path(
        self,
        *,
        start_m: Array,
        start_m_per_s: Array,
        end_m: Array,
        end_m_per_s: Array,
        length_s: float,
        steps: int,
    ) -> None:
        """Give the surface points (n, 3) their path over the next ``steps``."""

    def run(self, *, steps: int, step_s: float) -> None: ...
    def save(self) -> dict[str, npt.NDArray[Any]]:
        """Return, between runs, this rank's part of all that the next ones depend on, to the last
        bit."""

    def restore(self, arrays: dict[str, npt.NDArray[Any]]) -> None:
        """Go back to there, also in another instance with the same input, surface and ranks."""

    def particles(self) -> dict[str, npt.NDArray[Any]]:
        """Return views of LIGGGHTS's memory: x, v, omega, f, torque (n, 3), radius, rmass, density,
        type, tag (n,); valid until the next call that moves particles."""

    def impulse_N_s(self) -> Array:
        """Return the impulse on each surface point (points, 3) during the last ``run``."""

    def force_N(self) -> Array:
        """Return the force on each surface point (points, 3) in the last force evaluation."""

    def ask_contact_tangent(self) -> None:
        """Ask for ``contact_tangent``, before the first force evaluation."""

    def contact_tangent(self, length_s: float) -> dict[str, Array]:
        """Return this rank's part of the tangent: push_N (points, 3) and impedance_N_s_per_m
        (points, 3, 3)."""

    def worn_m3(self) -> Array:
        """Return the volume worn off at each vertex since t = 0; empty without ``set_wear``."""

    def angular_impulse_N_m_s(self) -> Array:
        """Return (3,) about the world's origin, of all forces of this rank's particles on the
        surface points since t = 0."""

    def mass_moment_time_kg_m_s(self) -> Array:
        """Return (3,) the integral over time since t = 0 of the sum of mass times place of this
        rank's particles."""

    def surface_work_J(self) -> float:
        """Return the work that the surface did on the particles since t = 0."""

    def air(self) -> dict[str, Any]:
        """Return impulse_N_s (3,), angular_impulse_N_m_s (3,) and work_J that the air gave this rank's
        particles since t = 0; the input has a ``fix air``."""

    def surface_energy_J(self) -> dict[str, float]:
        """Return elastic_J and (negative) adhesion_J in contacts with the surface."""

    def contact_numbers(self) -> Indices: ...
    def pair_energy_J(self) -> dict[str, float]:
        """Return the same between particles; a contact with another rank's particle counts half."""

    def take_deepest_overlaps(self) -> dict[str, float]:
        """Return the fields of ``orchestrator.ports.Overlaps``, of this rank's contacts in all force
        evaluations since this was last asked."""

    def take_crossings(self) -> dict[str, npt.NDArray[Any]]:
        """Return the particles of this rank whose centre went through a triangle since this was last
        asked: tag, step of the last ``run``, from 1, (n,), and x (n, 3) at the end of that step."""
