"""Rigid bodies on bushings, linearised about their drawn position:  M x'' + C x' + K x = load.

Every body has the same coordinates, a choice from six: three translations of its centre of mass, then three
small rotations about world axes.  A bushing between bodies a and b (place p, rows of ``axes`` = spring axes)
is stretched by  axes (u_b - u_a)  with  u = x + rotation x (p - centre).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import BodyPlan, FramesPlan

IN_BALANCE = 1e-6  # of the forces in play: ten times what panels at rest are out of balance by
TRANSLATIONS = (0, 1, 2)
SPACE = (0, 1, 2, 3, 4, 5)


@dataclass(frozen=True)
class LinearMachine:
    """A machine of linear equations in its bodies' coordinates.

    ``stretch`` (3 bushings, coordinates): elongations along the spring axes per coordinate;
    ``stiffness_N_per_m``, ``damping_N_s_per_m`` (3 bushings,); ``mass`` (coordinates, coordinates).
    """

    stretch: Array
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array
    mass: Array

    @property
    def stiffness(self) -> Array:
        """The matrix K (coordinates, coordinates)."""
        return np.asarray(self.stretch.T @ (self.stiffness_N_per_m[:, None] * self.stretch))

    @property
    def damping(self) -> Array:
        """The matrix C (coordinates, coordinates)."""
        return np.asarray(self.stretch.T @ (self.damping_N_s_per_m[:, None] * self.stretch))

    def fastest_rad_per_s(self) -> float:
        """Return the highest undamped natural frequency, 0 without bushings or without free bodies."""
        import scipy.linalg

        if not len(self.mass):
            return 0.0
        highest = scipy.linalg.eigh(self.stiffness, self.mass, eigvals_only=True)[-1]
        return float(np.sqrt(max(highest, 0.0)))

    def sag(self, load: Array, in_play_N: float) -> Array:
        """Return the static coordinates (coordinates,) under a constant load, the sum of forces whose sizes
        add up to ``in_play_N``.

        Residuals from rounding, and from the tolerance of the panels' resting shapes, need not be held: a
        body without load may float freely in zero gravity.

        Raises ValueError if the bushings cannot hold the load.
        """
        if not load.any():
            return np.zeros_like(load)
        static, residual = self.hold(load)
        unheld = np.abs(residual).max()
        if unheld > 1e-8 * np.abs(load).max() + IN_BALANCE * in_play_N:
            raise ValueError(
                f"the bushings cannot hold {unheld:.3g} N or N m of the bodies' weight and of the "
                "panels' pull: one moves freely; add bushings that hold it, or let the machine "
                "start from the places in which it is drawn, unloaded: screen.drawn_at_rest = false"
            )
        return static

    def hold(self, load: Array) -> tuple[Array, Array]:
        """Return the static coordinates under a load and the part of it that no bushing holds."""
        static: Array = np.linalg.lstsq(self.stiffness, load, rcond=1e-12)[0]
        return static, load - self.stiffness @ static


def linearise(plan: FramesPlan, coordinates: tuple[int, ...], moving: Indices | None = None) -> LinearMachine:
    """Return the linear machine of some bodies with the selected ones of their six coordinates, in that
    order.

    ``moving`` has the numbers of the bodies that move, by default all bodies without a drive; the others
    stand still.
    """
    import scipy.linalg

    each = len(coordinates)
    stretch = np.zeros((len(plan.bushings), 3, each * len(plan.bodies)))
    for row, bushing in zip(stretch, plan.bushings, strict=True):
        for sign, number in zip((-1.0, 1.0), numbers(plan, bushing.bodies), strict=True):
            if number >= 0:
                moved = displacement(plan.bodies[number], bushing.position_m)[:, coordinates]
                row[:, each * number : each * (number + 1)] += sign * bushing.axes @ moved
    blocks = [_mass(body)[np.ix_(coordinates, coordinates)] for body in plan.bodies]
    bodies = free(plan) if moving is None else moving
    columns = (each * bodies[:, None] + np.arange(each)).ravel()
    return LinearMachine(
        stretch.reshape(3 * len(plan.bushings), each * len(plan.bodies))[:, columns],
        np.array([bushing.stiffness_N_per_m for bushing in plan.bushings]).reshape(-1),
        np.array([bushing.damping_N_s_per_m for bushing in plan.bushings]).reshape(-1),
        scipy.linalg.block_diag(*blocks)[np.ix_(columns, columns)],
    )


def displacement(body: BodyPlan, place_m: Array) -> Array:
    """Return the matrix (3, 6) of a body point's displacement per translation and small rotation."""
    return np.hstack([np.eye(3), -skew(place_m - body.center_of_mass_m)])


def skew(vector: Array) -> Array:
    """Return the matrix (3, 3) that multiplies as  vector x  does."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def numbers(plan: FramesPlan, names: tuple[str, ...]) -> Indices:
    """Return the bodies' places in the plan, -1 for "ground".  Raises ValueError for an unknown name."""
    known = {body.name: number for number, body in enumerate(plan.bodies)} | {"ground": -1}
    if unknown := set(names) - set(known):
        raise ValueError(f"no such body: {sorted(unknown)}; there are {sorted(known)}")
    return np.array([known[name] for name in names], dtype=np.int64)


def driven(plan: FramesPlan) -> Indices:
    """Return the numbers of the bodies that drives move, in the order of the drives.

    Raises ValueError for a body that is unknown, driven twice, or driven and excited.
    """
    names = tuple(drive.body for drive in plan.drives)
    bodies = numbers(plan, names)
    if (bodies < 0).any():
        raise ValueError("the ground cannot be driven")
    if len(set(names)) < len(names):
        raise ValueError(f"one drive per body, got drives for {names}")
    if both := set(names) & {exciter.body for exciter in plan.exciters}:
        raise ValueError(f"driven and excited: {sorted(both)}; a drive leaves no choice")
    return bodies


def free(plan: FramesPlan) -> Indices:
    """Return the numbers of the bodies that no drive moves."""
    return np.setdiff1d(np.arange(len(plan.bodies)), driven(plan))


def _mass(body: BodyPlan) -> Array:
    import scipy.linalg

    return np.asarray(scipy.linalg.block_diag(body.mass_kg * np.eye(3), body.inertia_kg_m2))
