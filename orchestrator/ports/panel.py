"""The port of a panel: a surface between clamps that frames hold."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol, runtime_checkable

from orchestrator.ports.clock import Interval
from orchestrator.ports.interface_records import Array, Inertia, Known, Load, Motion, Mount, PanelState
from orchestrator.ports.interpolation import Interpolation
from orchestrator.ports.state import Solver

Ahead = Callable[[Interval, Known], Known]
JointAdvance = Callable[[Interval, Motion, Load], PanelState]
"""A call that advances several panels: its records have the points of one panel after the other."""


class Panel(Solver, Protocol):
    """A deformable surface that frames hold at its clamp points.

    ``initial`` comes first, then one ``advance`` per interval.  Within an interval the clamps move
    smoothly, cubic Hermite in position and velocity (``HermitePath``), from the motion given last to
    the motion given now; before the first interval they rest where ``mount`` has them.
    ``received_J`` of the account has the keys "load" (work of the particles) and "clamps" (of the
    frames).

    Attributes
    ----------
    mount : Mount
        The clamp points at t = 0, and the frame that holds each.

    Examples
    --------
    Two points, each on a spring at a clamp of its own, moved by drift-kick-drift steps.

    >>> import numpy as np
    >>> from orchestrator.ports import Account, HermitePath, Interval, Load, Motion, Mount, PanelState
    >>> from orchestrator.ports.state import SavedAttributes
    >>> class SpringPanel(SavedAttributes):
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
        """Return the panel at rest between its clamps at t = 0.

        Returns
        -------
        PanelState
            The surface points' motion, and the static force on the clamps.
        """
        ...

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        """Carry the panel over one sync interval.

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


class MeshedPanel(Panel, Protocol):
    """A panel with a mesh of its own, to which the particles' triangles are mapped."""

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        """Return how other points of the panel, and points beside it, follow from the surface points.

        Parameters
        ----------
        coordinates_m
            Material coordinates in m, as ``geometry.Rectangle`` defines them: (n, 2), or (n, 3) with the
            offset from the surface along the panel's normal, positive on the side of the bed.  A wall of an
            opening has points with offsets of both signs.

        Returns
        -------
        Interpolation
            The matrix H of the points' feet, and the slopes of the surface under points with an offset.

        Raises
        ------
        ValueError
            A coordinate is outside of the panel.
        """
        ...


@runtime_checkable
class Following(Protocol):
    """A panel with surface points that its clamps alone move, whatever loads them."""

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Tell where the points whose clamps are known are at the interval's end.

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
class Joinable(Protocol):
    """A panel that one call may advance together with others of its kind, which is quicker."""

    def join(self, panels: Sequence[Panel]) -> JointAdvance | None:
        """Return the call that advances panels together.

        Parameters
        ----------
        panels
            This panel and others.

        Returns
        -------
        JointAdvance or None
            It does what ``advance`` of one panel after the other does.  None if one of the panels is of
            another kind.
        """
        ...


@runtime_checkable
class Inert(Protocol):
    """A panel that tells the masses behind its surface points."""

    def inertia(self) -> Inertia:
        """Return the free masses that carry the surface points; they never change."""
        ...


def surface_ahead(panel: Panel) -> Ahead:
    """Return ``panel.ahead``, or for a panel without it a call that knows no point ahead."""
    if isinstance(panel, Following):
        return panel.ahead
    nothing = Known.nothing(len(panel.initial().surface))
    return lambda interval, clamps: nothing


def surface_inertia(panel: Panel) -> Inertia:
    """Return the masses behind a panel's surface points, or unknown masses for a panel that tells none."""
    if isinstance(panel, Inert):
        return panel.inertia()
    return Inertia.unknown(len(panel.initial().surface))
