"""The port of the frames: rigid bodies that carry points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from orchestrator.ports.clock import Interval
from orchestrator.ports.interface_records import Array, Known, Load, Motion, Pose
from orchestrator.ports.state import Solver


class Frames(Solver, Protocol):
    """Rigid bodies that carry points: clamps, walls and probes.

    The points and their carriers are given in the plan (``FramesPlan.points_m``, ``carrier``); their
    number and order never change.  ``initial`` comes first, then one ``advance`` per interval with
    the load of the panels.  Frames that drives move should be ``Scheduled``, too.  ``received_J`` of
    their account has the key "reaction": the work of the panels on the frames.

    Examples
    --------
    A frame on springs that only translates, by the exact solution for a constant load.

    >>> import numpy as np
    >>> from orchestrator.ports import Account, Interval, Load, Motion, Pose
    >>> from orchestrator.ports.state import SavedAttributes
    >>> class SwingingFrame(SavedAttributes):
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
    ...     def pose(self):
    ...         centre_m = self.points_m.mean(axis=0) + self.offset_m
    ...         return Pose(centre_m[None], np.eye(3)[None], self.velocity_m_per_s[None], np.zeros((1, 3)))
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
        """Return the motion of the carried points at t = 0.

        Returns
        -------
        Motion
            Positions in m and velocities in m/s, (points, 3) each, in the order of the plan.
        """
        ...

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        """Carry the bodies over one sync interval.

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

    def pose(self) -> Pose:
        """Return how the bodies stand and move at the last sync point.  The call changes nothing.

        Returns
        -------
        Pose
            A row for each body, in the order of the plan; the carried points move as it says.
        """
        ...


@runtime_checkable
class Scheduled(Protocol):
    """Frames of which a drive moves some points by a schedule that no reaction changes."""

    def ahead(self, interval: Interval) -> Known | None:
        """Tell where the driven points are at the interval's end.  The call changes nothing.

        Parameters
        ----------
        interval
            The next interval.

        Returns
        -------
        Known or None
            The exact motion of the driven points, which are the same at all times; None where nothing is
            driven, since what stands still needs no schedule.
        """
        ...


@runtime_checkable
class Hysteretic(Protocol):
    """Frames whose bushings may have friction and Maxwell elements and gap springs beside their springs."""

    def element_forces_N(self) -> Array | None:
        """Return the forces of the elements at the last sync point.  The call changes nothing.

        Returns
        -------
        Array or None
            Forces in N along the bushings' axes, (bushings, 3), in the order of the plan; None
            where no bushing has elements.
        """
        ...


@dataclass(frozen=True)
class FrameLoads:
    """The forces on the bodies at the last sync point, and their accelerations under them, in world axes.

    They belong to the end of the last interval, whose reaction still acts, too.

    Parameters
    ----------
    bushing_N, bushing_m
        (bushings, 3) each, the force of a bushing on its first body, whose opposite acts on its second body,
        and the place of both.
    exciter_N, exciter_m
        (exciters, 3) each, forces and places.
    lag_N_m
        (bodies, 3), the moments by which the solver's own loads differ from these forces at these places,
        because it extrapolates or averages lever arms.
    acceleration_m_per_s2, angular_acceleration_rad_per_s2
        (bodies, 3) each, of the centres of mass, and of the bodies.
    """

    bushing_N: Array
    bushing_m: Array
    exciter_N: Array
    exciter_m: Array
    lag_N_m: Array
    acceleration_m_per_s2: Array
    angular_acceleration_rad_per_s2: Array


@runtime_checkable
class Loaded(Protocol):
    """Frames that forces move, and that tell these forces."""

    def loads(self) -> FrameLoads | None:
        """Return the forces at the last sync point, after the first interval.  The call changes nothing.

        Returns
        -------
        FrameLoads or None
            The forces, in the order of the plan; None where a drive moves a body.
        """
        ...


class Motorised(Protocol):
    """Frames of which motors may turn shafts, which then lag behind their named speed."""

    def shaft_angles_rad(self) -> Mapping[str, float]:
        """Return how far the shafts have turned at the last sync point.  The call changes nothing.

        Returns
        -------
        Mapping
            Angles in rad by the exciters' names, in the order of the plan; empty without motors.
        """
        ...


def find_shaft_angles_rad(frames: Frames) -> Mapping[str, float]:
    """Return the angles of shafts that motors turn, for frames that are ``Motorised`` or not."""
    angles_rad = getattr(frames, "shaft_angles_rad", None)
    return angles_rad() if angles_rad is not None else {}


def find_element_forces_N(frames: Frames) -> Array | None:
    """Return the forces (bushings, 3) of such elements along the bushings' axes, for frames that are
    ``Hysteretic`` or not; None without elements."""
    return frames.element_forces_N() if isinstance(frames, Hysteretic) else None


def find_frame_loads(frames: Frames) -> FrameLoads | None:
    """Return the forces on bodies at the last sync point, for frames that are ``Loaded`` or not; None where
    they do not tell them."""
    return frames.loads() if isinstance(frames, Loaded) else None


def find_driven_points(frames: Frames, interval: Interval) -> Known | None:
    """Return the motion of driven points at the next interval's end, for frames that are ``Scheduled`` or
    not; None where nothing is driven."""
    ahead = getattr(frames, "ahead", None)  # of a Scheduled: to ask isinstance takes longer than the rest
    return ahead(interval) if ahead is not None else None
