"""The ports: what crosses between solvers, and the calls that every solver answers.

Start here to connect a solver of your own: write a class with the methods of ``Frames``, ``Panel``
or ``Particles``, and a function ``build(plan)`` that makes one from a plan (``ports/plans``).  Each
protocol below shows a complete small solver that runs.

**What crosses.**  Everything that crosses is a list of points with a vector at each (``Motion``,
``Load``), in SI units and in one world frame, so the power through any interface is the sum of
F . v.  Motion runs down (frames -> panels -> particles), load runs up (particles -> panels ->
frames).

**Signs.**  A ``Load`` is the force that its *giver* exerts on its *receiver*: of the particles on the
surface, of the panel on the frames.  A load that crosses is the mean over the sync interval
(impulse / length), never a sample, so momentum is handed over exactly.

**Order of calls.**  A solver is built from a plan and then asked for ``initial``, once or several
times, before anything else.  After that, ``advance`` carries it over one sync interval after the
other.  All other calls come at sync points and change nothing, ``restore`` excepted.  ``close`` comes
last, also after a failure.

**Going back.**  Some coupling schemes repeat an interval.  They take a solver back to its start by
``save`` and ``restore`` (``Restorable``), so every solver must have both; ``ports/state.py`` makes
them one line each.

**Failures.**  A solver that cannot go on raises ``SolverFailed`` (``ports/failures.py``) with the
reason; records refuse wrong shapes and values that are not finite by ``BrokenRecord``.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from orchestrator.ports.clock import Interval
from orchestrator.ports.interface_records import (
    Account,
    AngularAccount,
    Array,
    BrokenRecord,
    ContactTangent,
    HermitePath,
    Indices,
    Inertia,
    Known,
    Load,
    Motion,
    Mount,
    PanelState,
    check_point_count,
)
from orchestrator.ports.particle_records import Crossings, Overlaps, ParticleSnapshot, Removed, sort_removed

if TYPE_CHECKING:
    from scipy.sparse import csr_array

__all__ = [
    "Account",
    "AngularAccount",
    "Array",
    "BrokenRecord",
    "ContactTangent",
    "Crossings",
    "Following",
    "Frames",
    "HermitePath",
    "Indices",
    "Inert",
    "Inertia",
    "Interval",
    "Known",
    "Load",
    "MeshedPanel",
    "Motion",
    "Mount",
    "Overlaps",
    "Panel",
    "PanelState",
    "ParticleSnapshot",
    "Particles",
    "Predicting",
    "Removed",
    "Restorable",
    "Saved",
    "Scheduled",
    "Wearing",
    "check_point_count",
    "sort_removed",
]


class Frames(Protocol):
    """Rigid bodies that carry points: clamps, walls and probes.

    The points and their carriers are given in the plan (``FramesPlan.points_m``, ``carrier``); their
    number and order never change.  ``initial`` comes first, then one ``advance`` per interval with
    the load of the panels.  Frames that drives move should be ``Scheduled``, too.

    Examples
    --------
    A frame on springs that only translates, by the exact solution for a constant load.

    >>> import numpy as np
    >>> from orchestrator.ports import Account, Interval, Load, Motion
    >>> from orchestrator.ports.state import restore_attributes, save_attributes
    >>> class SwingingFrame:
    ...     STATE = ("offset_m", "velocity_m_per_s", "reaction_J", "springs_N_s")
    ...
    ...     def __init__(self, points_m, mass_kg, stiffness_N_per_m):
    ...         self.points_m, self.mass_kg, self.stiffness_N_per_m = points_m, mass_kg, stiffness_N_per_m
    ...         self.offset_m, self.velocity_m_per_s = np.zeros(3), np.zeros(3)
    ...         self.reaction_J, self.springs_N_s = 0.0, np.zeros(3)
    ...
    ...     def initial(self):
    ...         places_m = self.points_m + self.offset_m
    ...         return Motion(places_m, np.tile(self.velocity_m_per_s, (len(places_m), 1)))
    ...
    ...     def advance(self, interval, reaction):
    ...         force_N, before_m = reaction.force_N.sum(axis=0), self.offset_m
    ...         momentum_N_s = self.mass_kg * self.velocity_m_per_s
    ...         w = np.sqrt(self.stiffness_N_per_m / self.mass_kg)
    ...         c, s = np.cos(w * interval.length_s), np.sin(w * interval.length_s)
    ...         rest_m = force_N / self.stiffness_N_per_m
    ...         self.offset_m = rest_m + c * (before_m - rest_m) + s / w * self.velocity_m_per_s
    ...         self.velocity_m_per_s = c * self.velocity_m_per_s - s * w * (before_m - rest_m)
    ...         self.reaction_J += float(force_N @ (self.offset_m - before_m))
    ...         gained_N_s = self.mass_kg * self.velocity_m_per_s - momentum_N_s
    ...         self.springs_N_s = self.springs_N_s + gained_N_s - interval.length_s * force_N
    ...         return self.initial()
    ...
    ...     def account(self):
    ...         stored_J = {
    ...             "kinetic": self.mass_kg / 2 * float(self.velocity_m_per_s @ self.velocity_m_per_s),
    ...             "springs": self.stiffness_N_per_m / 2 * float(self.offset_m @ self.offset_m),
    ...         }
    ...         return Account(
    ...             self.mass_kg * self.velocity_m_per_s, self.springs_N_s, stored_J,
    ...             received_J={"reaction": self.reaction_J},
    ...         )
    ...
    ...     def save(self):
    ...         return save_attributes(self, *self.STATE)
    ...
    ...     def restore(self, saved):
    ...         restore_attributes(self, saved, *self.STATE)
    ...
    ...     def close(self):
    ...         pass
    >>> frame = SwingingFrame(np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]]), 100.0, 4e5)
    >>> start, saved = frame.initial(), frame.save()
    >>> pulled = Load(np.array([[0.0, 0.0, 40.0], [0.0, 0.0, 40.0]]))
    >>> moved = frame.advance(Interval(0, 1e-3), pulled)
    >>> round(moved.velocity_m_per_s[0, 2], 6)  # 80 N for 1 ms on 100 kg
    0.000799
    >>> frame.restore(saved)
    >>> bool((frame.advance(Interval(0, 1e-3), pulled).position_m == moved.position_m).all())
    True
    """

    def initial(self) -> Motion:
        """Returns the motion of the carried points at t = 0.

        Returns
        -------
        Motion
            Positions in m and velocities in m/s, (points, 3) each, in the order of the plan.
        """
        ...

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        """Carries the bodies over one sync interval.

        Parameters
        ----------
        interval
            The interval to pass; it begins where the last one ended.
        reaction
            The mean force of the panels on the carried points over the interval, in N: one row for
            each carried point, zero where no panel is.

        Returns
        -------
        Motion
            The carried points at the interval's end.

        Raises
        ------
        SolverFailed
            The bodies cannot be moved; the message says why.
        """
        ...

    def account(self) -> Account:
        """Returns what the frames own now, and what went through them since t = 0.

        Returns
        -------
        Account
            ``received_J`` has the key "reaction": the work of the panels on the frames.
        """
        ...

    def close(self) -> None:
        """Releases what the solver holds; no call follows."""
        ...


class Panel(Protocol):
    """A deformable surface that frames hold at its clamp points.

    ``initial`` comes first, then one ``advance`` per interval.  Within an interval the clamps move
    smoothly, cubic Hermite in position and velocity (``HermitePath``), from the motion given last to
    the motion given now; before the first interval they rest where ``mount`` has them.

    Attributes
    ----------
    mount : Mount
        The clamp points at t = 0, and the frame that holds each.

    Examples
    --------
    Two points, each on a spring at a clamp of its own, moved by drift-kick-drift steps.

    >>> import numpy as np
    >>> from orchestrator.ports import Account, HermitePath, Interval, Load, Motion, Mount, PanelState
    >>> from orchestrator.ports.state import restore_attributes, save_attributes
    >>> class SpringPanel:
    ...     STATE = ("points_m", "velocity_m_per_s", "clamps", "load_J", "clamps_J")
    ...
    ...     def __init__(self, clamps_m, frame, mass_kg, stiffness_N_per_m, step_s):
    ...         self.mount = Mount(clamps_m, (frame,) * len(clamps_m))
    ...         self.mass_kg, self.stiffness_N_per_m, self.step_s = mass_kg, stiffness_N_per_m, step_s
    ...         self.points_m, self.velocity_m_per_s = clamps_m.copy(), np.zeros_like(clamps_m)
    ...         self.clamps = Motion(clamps_m, np.zeros_like(clamps_m))
    ...         self.load_J = self.clamps_J = 0.0
    ...
    ...     def initial(self):
    ...         return PanelState(Motion(self.points_m, self.velocity_m_per_s), Load.zero(len(self.points_m)))
    ...
    ...     def advance(self, interval, clamps, load):
    ...         path = HermitePath(self.clamps, clamps, interval.length_s)
    ...         steps = interval.steps(self.step_s)
    ...         step_s, pull_N_s = interval.length_s / steps, np.zeros_like(self.points_m)
    ...         for n in range(steps):
    ...             middle_m = self.points_m + step_s / 2 * self.velocity_m_per_s
    ...             spring_N = self.stiffness_N_per_m * (path.position_m((n + 0.5) / steps) - middle_m)
    ...             gained = step_s / self.mass_kg * (load.force_N + spring_N)
    ...             moved_m = step_s * (self.velocity_m_per_s + gained / 2)
    ...             clamps_m = path.position_m((n + 1) / steps) - path.position_m(n / steps)
    ...             self.load_J += float(np.vdot(load.force_N, moved_m))
    ...             self.clamps_J += float(np.vdot(spring_N, clamps_m))
    ...             self.points_m = self.points_m + moved_m
    ...             self.velocity_m_per_s = self.velocity_m_per_s + gained
    ...             pull_N_s += step_s * spring_N
    ...         self.clamps = clamps
    ...         surface = Motion(self.points_m, self.velocity_m_per_s)
    ...         return PanelState(surface, Load(-pull_N_s / interval.length_s))  # on the frames
    ...
    ...     def account(self):
    ...         stretch_m = self.points_m - self.clamps.position_m
    ...         speeds_m_per_s = np.linalg.norm(self.velocity_m_per_s, axis=1)
    ...         stored_J = {
    ...             "kinetic": self.mass_kg / 2 * float(speeds_m_per_s @ speeds_m_per_s),
    ...             "springs": self.stiffness_N_per_m / 2 * float(np.vdot(stretch_m, stretch_m)),
    ...         }
    ...         momentum_kg_m_per_s = self.mass_kg * self.velocity_m_per_s.sum(axis=0)
    ...         received_J = {"load": self.load_J, "clamps": self.clamps_J}
    ...         return Account(momentum_kg_m_per_s, np.zeros(3), stored_J, received_J=received_J)
    ...
    ...     def save(self):
    ...         return save_attributes(self, *self.STATE)
    ...
    ...     def restore(self, saved):
    ...         restore_attributes(self, saved, *self.STATE)
    ...
    ...     def close(self):
    ...         pass
    >>> clamps_m = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.0]])
    >>> panel = SpringPanel(clamps_m, "deck", mass_kg=0.1, stiffness_N_per_m=1e4, step_s=1e-5)
    >>> surface = panel.initial().surface
    >>> pushed = Load(np.array([[0.0, 0.0, -5.0], [0.0, 0.0, -5.0]]))  # the particles push down
    >>> still = Motion(clamps_m, np.zeros((2, 3)))
    >>> for n in range(10):
    ...     state = panel.advance(Interval(n, 1e-3), still, pushed)
    >>> bool((state.surface.position_m[:, 2] < 0).all() and (state.reaction.force_N[:, 2] < 0).all())
    True
    """

    mount: Mount

    def initial(self) -> PanelState:
        """Returns the panel at rest between its clamps at t = 0.

        Returns
        -------
        PanelState
            The surface points' motion, and the static force on the clamps.
        """
        ...

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        """Carries the panel over one sync interval.

        Parameters
        ----------
        interval
            The interval to pass; it begins where the last one ended.
        clamps
            The clamp points at the interval's end, in the order of ``mount``.
        load
            The mean force of the particles on the surface points, in N, constant over the interval.

        Returns
        -------
        PanelState
            The surface at the interval's end, and the panel's mean force on the frames.

        Raises
        ------
        SolverFailed
            The panel cannot be moved, or its motion is no longer finite.
        """
        ...

    def account(self) -> Account:
        """Returns what the panel owns now, and what went through it since t = 0.

        Returns
        -------
        Account
            ``received_J`` has the keys "load" (work of the particles) and "clamps" (of the frames).
        """
        ...

    def close(self) -> None:
        """Releases what the solver holds; no call follows."""
        ...


class MeshedPanel(Panel, Protocol):
    """A panel with a mesh of its own, to which the particles' triangles are mapped."""

    def interpolation(self, coordinates_m: Array) -> csr_array:
        """Returns the matrix that takes values at the surface points to other points of the panel.

        Parameters
        ----------
        coordinates_m
            Material coordinates (n, 2) in m, as ``geometry.Rectangle`` defines them.

        Returns
        -------
        csr_array
            H of shape (n, surface points).  Its rows sum to one, so H.T hands over load without loss.
        """
        ...


class Particles(Protocol):
    """Particles that touch a triangulated surface.

    The surface's triangles are given in the plan (``TriangleSurface``); its points move as
    ``advance`` says.  ``initial`` comes first, then one ``advance`` per interval.  Under MPI all
    calls are collective, except where they say otherwise.

    Examples
    --------
    One ball on a spring contact with one triangle, which never leaves its plan.

    >>> import numpy as np
    >>> from orchestrator.ports import (
    ...     Account, Crossings, HermitePath, Interval, Load, Motion, Overlaps, ParticleSnapshot, sort_removed
    ... )
    >>> from orchestrator.ports.physics import sphere_mass_kg
    >>> from orchestrator.ports.state import restore_attributes, save_attributes
    >>> DOWN = np.array([0.0, 0.0, -1.0])
    >>> class Ball:
    ...     STATE = (
    ...         "z_m", "velocity_m_per_s", "surface_m", "surface_J", "weight_N_s", "weight_J", "deepest_m"
    ...     )
    ...
    ...     def __init__(self, z_m, diameter_m, stiffness_N_per_m, step_s):
    ...         self.z_m, self.velocity_m_per_s, self.surface_m = z_m, 0.0, 0.0
    ...         self.diameter_m, self.mass_kg = diameter_m, sphere_mass_kg(diameter_m, 2500.0)
    ...         self.stiffness_N_per_m, self.step_s = stiffness_N_per_m, step_s
    ...         self.surface_J = self.weight_N_s = self.weight_J = self.deepest_m = 0.0
    ...
    ...     def contact_N(self, surface_m, z_m):
    ...         overlap_m = max(surface_m + self.diameter_m / 2 - z_m, 0.0)
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
    ...         one = np.ones(1)
    ...         return ParticleSnapshot(
    ...             np.array([1]), place_m, velocity, np.zeros((1, 3)), self.diameter_m * one, 2500.0 * one,
    ...             np.array([0]),
    ...         )
    ...
    ...     def removed(self):
    ...         return sort_removed([])
    ...
    ...     def overlaps(self):
    ...         deepest_m, self.deepest_m = self.deepest_m, 0.0
    ...         return Overlaps(surface_m=deepest_m, surface_per_diameter=deepest_m / self.diameter_m)
    ...
    ...     def crossings(self):
    ...         return Crossings.none()
    ...
    ...     def account(self):
    ...         overlap_m = max(self.surface_m + self.diameter_m / 2 - self.z_m, 0.0)
    ...         stored_J = {
    ...             "kinetic": self.mass_kg / 2 * self.velocity_m_per_s**2,
    ...             "contact": self.stiffness_N_per_m / 2 * overlap_m**2,
    ...         }
    ...         momentum_kg_m_per_s = -self.mass_kg * self.velocity_m_per_s * DOWN
    ...         return Account(
    ...             momentum_kg_m_per_s, -self.weight_N_s * DOWN, stored_J,
    ...             supplied_J={"gravity": self.weight_J}, received_J={"surface": self.surface_J},
    ...         )
    ...
    ...     def save(self):
    ...         return save_attributes(self, *self.STATE)
    ...
    ...     def restore(self, saved):
    ...         restore_attributes(self, saved, *self.STATE)
    ...
    ...     def close(self):
    ...         pass
    >>> ball = Ball(z_m=0.01, diameter_m=0.02, stiffness_N_per_m=1e4, step_s=1e-5)
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
        """Returns the particles' force on the surface at t = 0.

        Returns
        -------
        Load
            Force in N, (surface points, 3).
        """
        ...

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        """Carries the particles over one sync interval, while the surface follows a path.

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
        """Returns all particles as they are at this sync point, complete on rank 0 only."""
        ...

    def removed(self) -> Removed:
        """Returns the particles that were taken out since the last call, complete on rank 0 only."""
        ...

    def overlaps(self) -> Overlaps:
        """Returns the deepest contacts of all steps since the last call, or since t = 0.

        Returns
        -------
        Overlaps
            Alike on every rank; the call is collective under MPI.
        """
        ...

    def crossings(self) -> Crossings:
        """Returns how often particles went through the surface since t = 0.

        Returns
        -------
        Crossings
            Looked for in every step.  Alike on every rank, and known there without communication.
        """
        ...

    def account(self) -> Account:
        """Returns what the particles own now, and what went through them since t = 0.

        Returns
        -------
        Account
            ``received_J`` has the key "surface": the work of the surface on the particles.
        """
        ...

    def close(self) -> None:
        """Releases what the solver holds; no call follows."""
        ...


class Wearing(Protocol):
    """Particles that wear the surface, built from a plan that asks for it."""

    def worn_m3(self) -> Array:
        """Returns the volume worn off since t = 0, in m3, (surface points,), alike on every rank."""
        ...


class Predicting(Protocol):
    """Particles that predict their load, built from a plan that asks for it (``predicts_load``)."""

    def contact_tangent(self, length_s: float) -> ContactTangent:
        """Predicts how the mean load over the next interval depends on the surface's velocity.

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


@runtime_checkable
class Scheduled(Protocol):
    """Frames of which a drive moves some points by a schedule that no reaction changes."""

    def ahead(self, interval: Interval) -> Known | None:
        """Tells where the driven points are at the interval's end.  The call changes nothing.

        Parameters
        ----------
        interval
            The next interval.

        Returns
        -------
        Known or None
            The exact motion of the driven points; None where nothing is driven, since what stands
            still needs no schedule.
        """
        ...


@runtime_checkable
class Following(Protocol):
    """A panel with surface points that its clamps alone move, whatever loads them."""

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Tells where the points whose clamps are known are at the interval's end.

        The answer is what ``advance`` with such clamps will give.  The call changes nothing.

        Parameters
        ----------
        interval
            The next interval.
        clamps
            What is known of the clamps at its end.

        Returns
        -------
        Known
            One row per surface point.
        """
        ...


@runtime_checkable
class Inert(Protocol):
    """A panel that tells the masses behind its surface points."""

    def inertia(self) -> Inertia:
        """Returns the free masses that carry the surface points; they never change."""
        ...


Saved = dict[str, Any]
"""A solver's state: arrays by name, or dictionaries of the same (``ports/state.py``)."""


@runtime_checkable
class Restorable(Protocol):
    """A solver that can be taken back to a sync point, or another one brought there.

    A run that goes on after ``restore`` is, bit for bit, the one that never stopped.  So a restore
    must undo everything that later calls depend on: motion, histories of material and contact,
    random numbers, counters, and all sums behind ``account``.  Both calls are collective under MPI;
    what each rank saves is its own.
    """

    def save(self) -> Saved:
        """Returns copies of all that decides how the solver goes on.  The call changes nothing.

        Returns
        -------
        Saved
            Arrays that later calls of the solver leave alone.
        """
        ...

    def restore(self, saved: Saved) -> None:
        """Takes this solver to the sync point at which ``saved`` was made.

        Parameters
        ----------
        saved
            What ``save`` of this solver gave, or of another one built from the same plan.
        """
        ...
