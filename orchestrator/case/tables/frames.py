"""``[screen.frames]`` and what moves them: drives, bushings, exciters and their motors.

In deck axes, see ``screen.py``.
"""

from __future__ import annotations

from typing import Annotated

from annotated_types import Ge, Gt, Le
from pydantic import Strict

from orchestrator.case.tables.quantities import (
    NotNegative,
    NotNegativeVector,
    Number,
    Positive,
    Table,
    Vector,
    Vectors,
)


class Drive(Table):
    """Prescribed harmonic motion of a frame, component by component:
    amplitude * sin(speed * t + phase), smoothly run up."""

    speed_rad_per_s: Positive
    """Angular frequency."""
    amplitude_m: Vector = (0.0, 0.0, 0.0)
    """Amplitude of the translation."""
    phase_rad: Vector = (0.0, 0.0, 0.0)
    """Phase of each component of the translation."""
    rotation_rad: Vector = (0.0, 0.0, 0.0)
    """Amplitude of the rotation vector."""
    rotation_phase_rad: Vector = (0.0, 0.0, 0.0)
    """Phase of each component of the rotation."""
    center_m: Vector = (0.0, 0.0, 0.0)
    """Centre of the rotation."""
    run_up_s: NotNegative = 0.0
    """Time in which the motion grows to its full size."""


class Frame(Table):
    """A rigid body: free, moved through its mass by exciters, bushings and panels; or moved as
    prescribed by ``drive``, whatever pushes it.  Both may be in one machine (solvers "planar" and
    "exudyn")."""

    center_of_mass_m: Vector = (0.0, 0.0, 0.0)
    """Centre of mass at t = 0."""
    mass_kg: Positive | None = None
    """Mass without panels and particles."""
    inertia_kg_m2: tuple[Positive, Positive, Positive] | None = None
    """Moments of inertia about the deck axes through the centre of mass."""
    products_of_inertia_kg_m2: Vector = (0.0, 0.0, 0.0)
    """Elements xy, xz and yz of the inertia tensor."""
    drive: Drive | None = None
    """Prescribed motion (not with solver "two-mass"); mass and inertia may then be left
    out, and are without effect on the motion."""


class Bushing(Table):
    """Equal springs and dampers between two frames, one at each position."""

    between: tuple[str, str]
    """The two frames, or a frame and "ground"."""
    positions_m: Vectors
    """Where they are, one row each."""
    stiffness_N_per_m: NotNegativeVector
    """Stiffness of one, along each of its axes."""
    damping_N_s_per_m: NotNegativeVector = (0.0, 0.0, 0.0)
    """Viscous damping of one, along each of its axes."""
    rotation_deg: Vector = (0.0, 0.0, 0.0)
    """Turns the bushing's axes from the deck axes: about x, then y, then z."""


class Motor(Table):
    """An induction motor on the ground that turns an exciter's shaft, so that its speed dips under
    load.  Of the solvers, "planar" and "exudyn" know it; the others turn the shaft at
    ``speed_rad_per_s``."""

    rated_power_W: Positive
    """Rated power, of all motors of the shaft."""
    synchronous_speed_rad_per_s: Positive
    """Speed of the shaft without any load; gears and belts are already in it."""
    rated_slip: Annotated[float, Strict(), Gt(0), Le(0.2)]
    """Lag behind the synchronous speed at rated power, as a share of it."""
    breakdown_ratio: Annotated[float, Strict(), Ge(1), Le(10)] = 2.5
    """Breakdown torque over rated torque."""
    moment_of_inertia_kg_m2: Positive
    """Of all that turns about the shaft, the unbalance and the rotor included, at its speed."""
    bearing_loss_N_m_s: NotNegative = 0.0
    """Torque that the bearings take, per speed."""


class Exciter(Table):
    """A rotating unbalance on a frame."""

    frame: str
    """The frame it is fixed to."""
    position_m: Vector
    """Where its axis is."""
    mass_moment_kg_m: Positive
    """Unbalanced mass times its eccentricity; the force is this times speed squared."""
    speed_rad_per_s: Positive
    """Speed once it has run up."""
    axis: Vector = (0.0, 1.0, 0.0)
    """Direction of the shaft; the unbalance turns about it in the positive sense."""
    start: Vector = (0.0, 0.0, 1.0)
    """Direction in which the force points at angle ``phase_rad``; normal to ``axis``."""
    phase_rad: Number = 0.0
    """Angle at t = 0."""
    start_s: NotNegative = 0.0
    """When it starts; until then it stands still, and what was dropped can settle."""
    run_up_s: NotNegative = 0.0
    """Time to reach full speed, from ``start_s``; of a motor, for its synchronous speed."""
    motor: Motor | None = None
    """Turns it; without, its speed is prescribed."""
