"""The port of the particles that touch a triangulated surface."""

from __future__ import annotations

from typing import Protocol

from orchestrator.ports.clock import Interval
from orchestrator.ports.interface_records import Array, ContactTangent, HermitePath, Load
from orchestrator.ports.particle_records import Crossings, Overlaps, ParticleSnapshot, Removed
from orchestrator.ports.state import Solver


class Particles(Solver, Protocol):
    """Particles that touch a triangulated surface.

    The surface's triangles are given in the plan (``TriangleSurface``); its points move as
    ``advance`` says.  ``initial`` comes first, then one ``advance`` per interval.  Under MPI all
    calls are collective, except where they say otherwise.  ``received_J`` of the account has the key
    "surface": the work of the surface on the particles.

    Examples
    --------
    One ball on a spring contact with one triangle, which never leaves its plan.

    >>> import numpy as np
    >>> from orchestrator.ports import (
    ...     Account, Crossings, HermitePath, Interval, Load, Motion, Overlaps, ParticleSnapshot, sort_removed
    ... )
    >>> from orchestrator.ports.grains import Grain, Shape, ShapeTable
    >>> from orchestrator.ports.state import SavedAttributes
    >>> DOWN = np.array([0.0, 0.0, -1.0])
    >>> BALL = Shape("ball", "a ball", ((0.0, 0.0, 0.0, 0.5),), np.pi / 6, (np.pi / 60,) * 3)
    >>> class Ball(SavedAttributes):
    ...     STATE = (
    ...         "z_m", "velocity_m_per_s", "surface_m", "surface_J", "weight_N_s", "weight_J", "deepest_m"
    ...     )
    ...
    ...     def __init__(self, z_m, grain, stiffness_N_per_m, step_s):
    ...         self.z_m, self.velocity_m_per_s, self.surface_m = z_m, 0.0, 0.0
    ...         self.grain, self.mass_kg, self.radius_m = grain, grain.mass_kg, grain.bounding_radius_m
    ...         self.stiffness_N_per_m, self.step_s = stiffness_N_per_m, step_s
    ...         self.surface_J = self.weight_N_s = self.weight_J = self.deepest_m = 0.0
    ...
    ...     def contact_N(self, surface_m, z_m):
    ...         overlap_m = max(surface_m + self.radius_m - z_m, 0.0)
    ...         self.deepest_m = max(self.deepest_m, overlap_m)
    ...         return self.stiffness_N_per_m * overlap_m
    ...
    ...     def initial(self):
    ...         return Load(np.outer(np.ones(3), self.contact_N(0.0, self.z_m) / 3 * DOWN))
    ...
    ...     def advance(self, interval, path):
    ...         steps = interval.steps(self.step_s)
    ...         step_s, impulse_N_s = interval.length_s / steps, 0.0
    ...         for n in range(steps):
    ...             place_m = path.position_m((n + 0.5) / steps)[:, 2].mean()
    ...             push_N = self.contact_N(place_m, self.z_m + step_s / 2 * self.velocity_m_per_s)
    ...             gained = step_s * (push_N / self.mass_kg - 9.81)
    ...             moved_m = step_s * (self.velocity_m_per_s + gained / 2)
    ...             surface_m = path.position_m((n + 1) / steps)[:, 2].mean()
    ...             self.surface_J += push_N * (surface_m - self.surface_m)
    ...             self.weight_N_s -= 9.81 * step_s * self.mass_kg
    ...             self.weight_J -= 9.81 * self.mass_kg * moved_m
    ...             self.z_m, self.surface_m = self.z_m + moved_m, surface_m
    ...             self.velocity_m_per_s += gained
    ...             impulse_N_s += step_s * push_N
    ...         return Load(np.outer(np.ones(3), impulse_N_s / interval.length_s / 3 * DOWN))
    ...
    ...     def snapshot(self):
    ...         place_m, velocity = np.array([[0.0, 0.0, self.z_m]]), -self.velocity_m_per_s * DOWN[None]
    ...         grains = self.grain.of_sizes(np.array([self.grain.sieve_size_m]))
    ...         return ParticleSnapshot(np.array([1]), place_m, velocity, np.zeros((1, 3)), grains)
    ...
    ...     def removed(self):
    ...         return sort_removed([], self.grain.shapes)
    ...
    ...     def overlaps(self):
    ...         deepest_m, self.deepest_m = self.deepest_m, 0.0
    ...         return Overlaps(surface_m=deepest_m, surface_per_diameter=deepest_m / self.grain.sieve_size_m)
    ...
    ...     def crossings(self):
    ...         return Crossings.none()
    ...
    ...     def account(self):
    ...         overlap_m = max(self.surface_m + self.radius_m - self.z_m, 0.0)
    ...         stored_J = {
    ...             "kinetic": self.mass_kg / 2 * self.velocity_m_per_s**2,
    ...             "contact": self.stiffness_N_per_m / 2 * overlap_m**2,
    ...         }
    ...         momentum_kg_m_per_s = -self.mass_kg * self.velocity_m_per_s * DOWN
    ...         return Account(
    ...             momentum_kg_m_per_s, -self.weight_N_s * DOWN, stored_J,
    ...             supplied_J={"gravity": self.weight_J}, received_J={"surface": self.surface_J},
    ...         )
    >>> glass = Grain(0.02, 2500.0, material=0, shape=0, shapes=ShapeTable.of([BALL]))
    >>> ball = Ball(z_m=0.01, grain=glass, stiffness_N_per_m=1e4, step_s=1e-5)
    >>> triangle = Motion(np.array([[0.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]), np.zeros((3, 3)))
    >>> load = ball.initial()
    >>> for n in range(10):
    ...     load = ball.advance(Interval(n, 1e-4), HermitePath(triangle, triangle, 1e-4))
    >>> bool(load.force_N[0, 2] < 0)  # it pushes the surface down
    True
    >>> round(ball.snapshot().position_m[0, 2], 4)
    0.01
    """

    def initial(self) -> Load:
        """Return the particles' force on the surface at t = 0.

        Returns
        -------
        Load
            Force in N, (surface points, 3).
        """
        ...

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        """Carry the particles over one sync interval, while the surface follows a path.

        Parameters
        ----------
        interval
            The interval to pass; it begins where the last one ended.
        path
            How the surface points move during it.  Where the surface's motion was extrapolated, the
            path may begin elsewhere than the last one ended; the work of this small jump counts as
            received, too.

        Returns
        -------
        Load
            The particles' mean force on the surface points, in N: down where they lie on it.

        Raises
        ------
        SolverFailed
            The particles cannot be moved.
        """
        ...

    def snapshot(self) -> ParticleSnapshot:
        """Return all particles at this sync point, complete on rank 0 only."""
        ...

    def removed(self) -> Removed:
        """Return the particles that were taken out since the last call, complete on rank 0 only."""
        ...

    def overlaps(self) -> Overlaps:
        """Return the deepest contacts of all steps since the last call, or since t = 0.

        Returns
        -------
        Overlaps
            Alike on every rank; the call is collective under MPI.
        """
        ...

    def crossings(self) -> Crossings:
        """Return how often particles went through the surface since t = 0.

        Returns
        -------
        Crossings
            Looked for in every step.  Alike on every rank, and known there without communication.
        """
        ...


class Wearing(Protocol):
    """Particles that wear the surface, built from a plan that asks for it."""

    def worn_m3(self) -> Array:
        """Return the volume worn off since t = 0, in m3, (surface vertices,), alike on every rank."""
        ...


class Predicting(Protocol):
    """Particles that predict their load, built from a plan that asks for it (``predicts_load``)."""

    def contact_tangent(self, length_s: float) -> ContactTangent:
        """Predict how the mean load over the next interval depends on the surface's velocity.

        The call changes nothing.  It comes at a sync point and is collective under MPI.

        Parameters
        ----------
        length_s
            The interval's length in s.

        Returns
        -------
        ContactTangent
            Alike on every rank.
        """
        ...
