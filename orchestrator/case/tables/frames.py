"""The table ``[screen.frames]``, and the tables of drives, bushings, exciters and their motors.

All of them are in deck axes, which screen.py defines.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from annotated_types import Ge, Gt, Le
from pydantic import Field, Strict, StringConstraints

from orchestrator.case.tables.quantities import (
    NotNegative,
    NotNegativeVector,
    Number,
    OneLine,
    Positive,
    Switch,
    Table,
    Vector,
    Vectors,
)


class Drive(Table):
    """The prescribed harmonic motion of a frame.  Each component is amplitude * sin(speed * t + phase),
    and the motion grows smoothly during the run-up."""

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
    center_m: Vector | None = None
    """Centre of the rotation.  A drive with ``rotation_rad`` needs it."""
    run_up_s: NotNegative = 0.0
    """Time in which the motion grows to its full size."""

    @property
    def moves(self) -> bool:
        """Whether any amplitude is not zero; a drive without amplitude holds its frame."""
        return any((*self.amplitude_m, *self.rotation_rad))

    @property
    def jumps(self) -> dict[str, float]:
        """How far the frame would jump at t = 0 without a run-up, in m and rad, by the key of the phase."""
        pairs = {
            "phase_rad": zip(self.amplitude_m, self.phase_rad, strict=True),
            "rotation_phase_rad": zip(self.rotation_rad, self.rotation_phase_rad, strict=True),
        }
        far = {key: max(abs(size * math.sin(phase)) for size, phase in of) for key, of in pairs.items()}
        return {key: jump for key, jump in far.items() if jump > 1e-9}


class Frame(Table):
    """A rigid body.  A free frame has mass, and exciters, bushings and panels move it; a driven frame
    moves as its ``drive`` prescribes, whatever pushes it.  One machine may have both kinds with the
    solver "exudyn"."""

    center_of_mass_m: Vector | None = None
    """Centre of mass at t = 0.  A free frame needs it, unless its solver knows no rotation.  For a driven
    frame it is only the point whose motion is recorded, by default the origin."""
    mass_kg: Positive | None = None
    """Mass without panels and particles."""
    inertia_kg_m2: tuple[Positive, Positive, Positive] | None = None
    """Moments of inertia about the deck axes through the centre of mass."""
    products_of_inertia_kg_m2: Vector = (0.0, 0.0, 0.0)
    """Elements xy, xz and yz of the inertia tensor."""
    drive: Drive | None = None
    """Prescribed motion, which the solver "two-mass" does not know.  A driven frame may have no mass and
    no inertia, because these have no effect on its motion."""

    @property
    def recorded_point_m(self) -> Vector:
        """The point whose motion is recorded: the centre of mass, or the origin where none is given."""
        return self.center_of_mass_m or (0.0, 0.0, 0.0)


class CurvePoint(Table):
    """A harmonic test of a bushing: the deformation, and the force that it took."""

    amplitude_m: Annotated[float, Strict(), Ge(1e-7), Le(1)]
    """Amplitude of the deformation, which is half of its range."""
    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e4)]
    """Frequency."""
    stiffness_N_per_m: Positive
    """Amplitude of the force in phase with the deformation, divided by ``amplitude_m``."""
    loss_factor: Annotated[float, Strict(), Ge(0), Le(10)] | None = None
    """Energy lost in a cycle, divided by pi ``stiffness_N_per_m`` ``amplitude_m`` squared."""
    damping_N_s_per_m: NotNegative | None = None
    """Damping of the viscous damper that loses as much in a cycle; given in place of ``loss_factor``."""


class FrictionElement(Table):
    """A spring and a slider in series.  The slider holds until the spring is stretched by ``slip_m``."""

    stiffness_N_per_m: Positive
    """Stiffness of the spring."""
    slip_m: Positive
    """Stretch of the spring at which the slider slips."""


class MaxwellElement(Table):
    """A spring and a damper in series."""

    stiffness_N_per_m: Positive
    """Stiffness of the spring."""
    relaxation_s: Positive
    """Relaxation time, which is the damping divided by the stiffness."""


class BushingCurve(Table):
    """Measured stiffness and loss of one bushing over amplitude and frequency.  A spring with friction and
    Maxwell elements in parallel is fitted to the points when the case is read, unless
    ``elastic_N_per_m`` gives them.  The solver "exudyn" moves frames by this law."""

    axes: Annotated[str, StringConstraints(pattern=r"^[xyz]{1,3}$")] = "x"
    """Axes of the bushing to which the curve belongs, such as "xz"."""
    points: tuple[CurvePoint, ...] = ()
    """Measured points."""
    file: OneLine | tuple[OneLine, ...] | None = None
    """Table in the case's folder with the points, in place of ``points``, or several of them: a text such as
    CSV, whose columns have the names of the points' keys or those of testing machines ("Amplitude [mm]").  A
    loop of force over displacement gives one point (how-to/come-from-another-program.md)."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """What columns of ``file`` are, where their names leave it open: "k" = "stiffness / kN/mm"; "ignore"
    leaves one out."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark of ``file``, where it leaves it open."""
    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e4)] | None = None
    """Frequency of a loop in ``file`` that has no times."""
    elastic_N_per_m: Positive | None = None
    """Stiffness of the spring alone, at a large amplitude and a low frequency."""
    friction: tuple[FrictionElement, ...] = ()
    """Friction elements."""
    maxwell: tuple[MaxwellElement, ...] = ()
    """Maxwell elements."""


class Characteristic(Table):
    """The elastic force of one bushing over its deformation: a progressive spring, a spring with a gap, or a
    stop.  It is linear between the points and beyond the outer ones, and takes the place of
    ``stiffness_N_per_m`` in the frames' motion; the damping stays."""

    axes: Annotated[str, StringConstraints(pattern=r"^[xyz]{1,3}$")] = "x"
    """Axes of the bushing to which the characteristic belongs, such as "xz"."""
    deformation_m: tuple[Number, ...] = ()
    """Deformations of the points, which grow from point to point: how far the second of the two frames has
    moved against the first along the axis.  Zero is the bushing without load."""
    force_N: tuple[Number, ...] = ()
    """Forces of the points, which do not fall from point to point and are zero at zero deformation."""
    symmetric: Switch = False
    """true: the points begin at zero, and the other side is alike."""
    file: OneLine | None = None
    """Table in the case's folder with the points, in place of ``deformation_m`` and ``force_N``: a text such
    as CSV with a column of displacements and one of forces (how-to/come-from-another-program.md)."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """What columns of ``file`` are, where their names leave it open."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark of ``file``, where it leaves it open."""


class BushingTemperature(Table):
    """The stiffness of a bushing over its temperature.  It scales stiffness, damping, curves and
    characteristics alike, so that loss factors stay as they are."""

    works_at_degC: Number
    """Temperature at which the bushing works."""
    measured_degC: tuple[Number, ...]
    """Temperatures of the tests, which grow from one to the next."""
    stiffness_ratio: tuple[Positive, ...]
    """Stiffness in each test over the stiffness that the case gives."""

    @property
    def ratio(self) -> float:
        """The stiffness where the bushing works over the given one, linear between the tests."""
        return float(np.interp(self.works_at_degC, self.measured_degC, self.stiffness_ratio))


class Bushing(Table):
    """Equal bushings between two frames: a spring and a damper at each position."""

    between: tuple[str, str]
    """The two frames, or a frame and "ground"."""
    positions_m: Vectors
    """Positions of the bushings, with a row for each."""
    stiffness_N_per_m: NotNegativeVector
    """Stiffness of one bushing, along each of its axes.  Along an axis with a curve or a characteristic,
    estimates use it; linear solvers use it in place of a curve."""
    damping_N_s_per_m: NotNegativeVector = (0.0, 0.0, 0.0)
    """Viscous damping of one bushing, along each of its axes.  Along an axis with a curve, estimates and
    linear solvers use it."""
    rotation_deg: Vector = (0.0, 0.0, 0.0)
    """Rotation of the bushing's axes from the deck axes: about x, then y, then z."""
    curves: tuple[BushingCurve, ...] = ()
    """Measured curves of the bushing, for one or more of its axes each."""
    characteristics: tuple[Characteristic, ...] = ()
    """Force over deformation, for one or more axes without a curve each."""
    temperature: BushingTemperature | None = None
    """Stiffness over temperature."""


class Motor(Table):
    """An induction motor on the ground that turns an exciter's shaft, whose speed then drops under load.
    The solver "exudyn" computes it; other solvers turn the shaft at ``speed_rad_per_s``."""

    rated_power_W: Positive
    """Rated power of all motors of the shaft together."""
    synchronous_speed_rad_per_s: Positive
    """Speed of the shaft without any load, after all gears and belts."""
    rated_slip: Annotated[float, Strict(), Gt(0), Le(0.2)]
    """Lag behind the synchronous speed at rated power, as a share of the synchronous speed."""
    breakdown_ratio: Annotated[float, Strict(), Ge(1), Le(10)] = 2.5
    """Breakdown torque divided by rated torque."""
    moment_of_inertia_kg_m2: Positive
    """Moment of inertia of all rotating parts, with the unbalance and the rotor, at the speed of the
    shaft."""
    bearing_loss_N_m_s: NotNegative = 0.0
    """Torque of the bearings divided by the speed of the shaft."""


class Bearings(Table):
    """The roller bearings of an exciter's shaft, which bear the force of its unbalance evenly.  ``check`` and
    the page give their basic rating life; nothing else depends on them."""

    dynamic_rating_N: Positive
    """Basic dynamic load rating of one bearing, C."""
    count: Annotated[int, Strict(), Ge(1), Le(100)] = 2
    """Number of bearings that share the force."""


class Exciter(Table):
    """A rotating unbalance on a frame."""

    frame: str
    """Frame that carries the exciter."""
    position_m: Vector
    """Position of the exciter's axis."""
    mass_moment_kg_m: Positive
    """Unbalanced mass times its eccentricity; the force is this product times the speed squared."""
    speed_rad_per_s: Positive
    """Speed after the run-up."""
    axis: Vector = (0.0, 1.0, 0.0)
    """Direction of the shaft; the unbalance turns about it in the positive sense."""
    start: Vector = (0.0, 0.0, 1.0)
    """Direction in which the force points at angle ``phase_rad``; normal to ``axis``."""
    phase_rad: Number = 0.0
    """Angle at t = 0."""
    start_s: NotNegative = 0.0
    """Time at which the exciter starts.  Until then it stands still, so that particles and frames can
    settle."""
    run_up_s: NotNegative = 0.0
    """Time from ``start_s`` to full speed; with a motor, the time in which the motor's synchronous speed
    reaches its full value."""
    stop_s: NotNegative | None = None
    """Time at which the exciter begins to run down, after its run-up.  By default, it never does."""
    run_down_s: NotNegative = 0.0
    """Time from ``stop_s`` to standstill; with a motor, the time in which the motor's synchronous speed falls
    to zero."""
    motor: Motor | None = None
    """Motor that turns the shaft.  Without a motor, the speed of the shaft is prescribed."""
    bearings: Bearings | None = None
    """Bearings of the shaft."""
