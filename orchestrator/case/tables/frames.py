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
    """Prescribed motion: amplitude * sin(speed * t + phase) of each component; not with the solver
    "two-mass"."""

    speed_rad_per_s: Positive
    """Angular frequency."""
    amplitude_m: Vector = (0.0, 0.0, 0.0)
    """Amplitude of the translation."""
    phase_rad: Vector = (0.0, 0.0, 0.0)
    """Phase of each component."""
    rotation_rad: Vector = (0.0, 0.0, 0.0)
    """Amplitude of the rotation vector."""
    rotation_phase_rad: Vector = (0.0, 0.0, 0.0)
    """Phase of each component."""
    center_m: Vector | None = None
    """Centre of the rotation, which ``rotation_rad`` needs."""
    run_up_s: NotNegative = 0.0
    """Time in which the motion grows smoothly."""

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
    """A rigid body, moved by exciters, bushings and panels, or only by its ``drive``.  The solver
    "exudyn" knows both kinds at once."""

    center_of_mass_m: Vector | None = None
    """At t = 0, where the solver knows rotation; with a ``drive`` the recorded point, by default the
    origin."""
    mass_kg: Positive | None = None
    """Without panels and particles; not with a ``drive``."""
    inertia_kg_m2: tuple[Positive, Positive, Positive] | None = None
    """Moments about the deck axes through the centre of mass."""
    products_of_inertia_kg_m2: Vector = (0.0, 0.0, 0.0)
    """Elements xy, xz and yz."""
    drive: Drive | None = None
    """Prescribed motion."""

    @property
    def recorded_point_m(self) -> Vector:
        """The point whose motion is recorded: the centre of mass, or the origin where none is given."""
        return self.center_of_mass_m or (0.0, 0.0, 0.0)


class CurvePoint(Table):
    """A harmonic test of a bushing."""

    amplitude_m: Annotated[float, Strict(), Ge(1e-7), Le(1)]
    """Half the range of the deformation."""
    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e4)]
    """Frequency."""
    stiffness_N_per_m: Positive
    """Amplitude of the force in phase over ``amplitude_m``."""
    loss_factor: Annotated[float, Strict(), Ge(0), Le(10)] | None = None
    """Energy lost in a cycle / (pi ``stiffness_N_per_m`` ``amplitude_m``^2)."""
    damping_N_s_per_m: NotNegative | None = None
    """Instead: viscous damping with the same loss."""


class FrictionElement(Table):
    """A spring and a slider in series."""

    stiffness_N_per_m: Positive
    """Stiffness of the spring."""
    slip_m: Positive
    """Stretch at which the slider slips."""


class MaxwellElement(Table):
    """A spring and a damper in series."""

    stiffness_N_per_m: Positive
    """Stiffness of the spring."""
    relaxation_s: Positive
    """Damping over stiffness."""


class BushingCurve(Table):
    """Measured stiffness and loss of a bushing, for "exudyn".  A spring with friction and Maxwell
    elements in parallel is fitted, or given by ``elastic_N_per_m`` and these."""

    axes: Annotated[str, StringConstraints(pattern=r"^[xyz]{1,3}$")] = "x"
    """Axes of the bushing, such as "xz"."""
    points: tuple[CurvePoint, ...] = ()
    """Measured points."""
    file: OneLine | tuple[OneLine, ...] | None = None
    """Instead of ``points``: text tables whose columns have the points' keys or a testing machine's
    names; a loop of force over displacement is one point (how-to/come-from-another-program.md)."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """What unclear columns are: "k" = "stiffness / kN/mm", "ignore"."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark, if unclear."""
    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e4)] | None = None
    """Frequency of a loop in ``file`` without times."""
    elastic_N_per_m: Positive | None = None
    """Stiffness of the spring, at large amplitude and low frequency."""
    friction: tuple[FrictionElement, ...] = ()
    """Friction elements."""
    maxwell: tuple[MaxwellElement, ...] = ()
    """Maxwell elements."""


class Characteristic(Table):
    """Elastic force of one bushing over its deformation, as of a progressive spring, a gap or a stop: linear
    between points and beyond them, in place of ``stiffness_N_per_m``."""

    axes: Annotated[str, StringConstraints(pattern=r"^[xyz]{1,3}$")] = "x"
    """Axes of the bushing, such as "xz"."""
    deformation_m: tuple[Number, ...] = ()
    """Way of the second frame against the first along the axis, growing; 0 without load."""
    force_N: tuple[Number, ...] = ()
    """Forces, which do not fall; 0 at 0."""
    symmetric: Switch = False
    """The points begin at 0, and the other side is alike."""
    file: OneLine | None = None
    """Table with the points, in place of both (docs/how-to/come-from-another-program.md)."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """What columns of ``file`` are, where their names leave it open."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark of ``file``, where it leaves it open."""


class BushingTemperature(Table):
    """Stiffness over temperature, which scales stiffness, damping, curves and characteristics alike."""

    works_at_degC: Number
    """Temperature at work."""
    measured_degC: tuple[Number, ...]
    """Temperatures of tests, growing."""
    stiffness_ratio: tuple[Positive, ...]
    """Stiffness in each test over the given one."""

    @property
    def ratio(self) -> float:
        """The stiffness where the bushing works over the given one, linear between the tests."""
        return float(np.interp(self.works_at_degC, self.measured_degC, self.stiffness_ratio))


class Bushing(Table):
    """Equal bushings between two frames: a spring and a damper at each position."""

    between: tuple[str, str]
    """Two frames, or one and "ground"."""
    positions_m: Vectors
    """A row for each bushing."""
    stiffness_N_per_m: NotNegativeVector
    """Of one, along its axes; along an axis with a curve or a characteristic for estimates, and along an axis
    with a curve for linear solvers."""
    damping_N_s_per_m: NotNegativeVector = (0.0, 0.0, 0.0)
    """Viscous, likewise."""
    rotation_deg: Vector = (0.0, 0.0, 0.0)
    """Turn of its axes about the deck's x, then y, then z."""
    curves: tuple[BushingCurve, ...] = ()
    """Measured curves."""
    characteristics: tuple[Characteristic, ...] = ()
    """Force over deformation, along axes without a curve."""
    temperature: BushingTemperature | None = None
    """Stiffness over temperature."""


class Motor(Table):
    """An induction motor on the ground, whose speed drops under load, for "exudyn"; others turn at
    ``speed_rad_per_s``."""

    rated_power_W: Positive
    """Of all motors of the shaft."""
    synchronous_speed_rad_per_s: Positive
    """Speed of the shaft without load, after gears and belts."""
    rated_slip: Annotated[float, Strict(), Gt(0), Le(0.2)]
    """Lag at rated power, over the synchronous speed."""
    breakdown_ratio: Annotated[float, Strict(), Ge(1), Le(10)] = 2.5
    """Breakdown torque over rated torque."""
    moment_of_inertia_kg_m2: Positive
    """All rotating parts with unbalance and rotor, at the shaft's speed."""
    bearing_loss_N_m_s: NotNegative = 0.0
    """Torque of the bearings over the shaft's speed."""


class Bearings(Table):
    """Roller bearings that share the force, for their basic rating life in ``check`` and the page."""

    dynamic_rating_N: Positive
    """Basic dynamic load rating C."""
    count: Annotated[int, Strict(), Ge(1), Le(100)] = 2
    """Their number."""


class Exciter(Table):
    """A rotating unbalance on a frame."""

    frame: str
    """Its frame."""
    position_m: Vector
    """Point of its axis."""
    mass_moment_kg_m: Positive
    """Unbalanced mass times eccentricity."""
    speed_rad_per_s: Positive
    """Speed after the run-up."""
    axis: Vector = (0.0, 1.0, 0.0)
    """Direction of the shaft; it turns in the positive sense."""
    start: Vector = (0.0, 0.0, 1.0)
    """Direction of the force at angle ``phase_rad``, normal to ``axis``."""
    phase_rad: Number = 0.0
    """Angle at t = 0."""
    start_s: NotNegative = 0.0
    """Start; it stands still until then."""
    run_up_s: NotNegative = 0.0
    """Time from ``start_s`` to full speed, of a motor to full synchronous speed."""
    stop_s: NotNegative | None = None
    """Start of the run-down; never by default."""
    run_down_s: NotNegative = 0.0
    """Time from ``stop_s`` to standstill, of a motor to synchronous speed 0."""
    motor: Motor | None = None
    """Motor that turns the shaft."""
    bearings: Bearings | None = None
    """Bearings of the shaft."""
