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
    """Prescribed motion: amplitude * sin(speed * t + phase); not with "two-mass"."""

    speed_rad_per_s: Positive
    """Angular frequency."""
    amplitude_m: Vector = (0.0, 0.0, 0.0)
    """Translation."""
    phase_rad: Vector = (0.0, 0.0, 0.0)
    """Its phase."""
    rotation_rad: Vector = (0.0, 0.0, 0.0)
    """Rotation vector."""
    rotation_phase_rad: Vector = (0.0, 0.0, 0.0)
    """Its phase."""
    center_m: Vector | None = None
    """Centre, which ``rotation_rad`` needs."""
    run_up_s: NotNegative = 0.0
    """Time of smooth growth."""

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
    """A rigid body, free or moved by its ``drive``; both at once with "exudyn"."""

    center_of_mass_m: Vector | None = None
    """At t = 0, if it can turn; with ``drive`` the recorded point, else the origin."""
    mass_kg: Positive | None = None
    """Without panels and particles; not with ``drive``."""
    inertia_kg_m2: tuple[Positive, Positive, Positive] | None = None
    """Moments about its centre."""
    products_of_inertia_kg_m2: Vector = (0.0, 0.0, 0.0)
    """xy, xz, yz."""
    drive: Drive | None = None
    """Prescribed motion."""

    @property
    def recorded_point_m(self) -> Vector:
        """The point whose motion is recorded: the centre of mass, or the origin where none is given."""
        return self.center_of_mass_m or (0.0, 0.0, 0.0)


class CurvePoint(Table):
    """A harmonic test of a bushing."""

    amplitude_m: Annotated[float, Strict(), Ge(1e-7), Le(1)]
    """Amplitude of the deformation."""
    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e4)]
    """Frequency."""
    stiffness_N_per_m: Positive
    """Force in phase over ``amplitude_m``."""
    loss_factor: Annotated[float, Strict(), Ge(0), Le(10)] | None = None
    """Loss of a cycle / (pi ``stiffness_N_per_m`` ``amplitude_m``^2)."""
    damping_N_s_per_m: NotNegative | None = None
    """Instead: viscous damping."""


class FrictionElement(Table):
    """A spring and a slider in series."""

    stiffness_N_per_m: Positive
    """Stiffness."""
    slip_m: Positive
    """Stretch at slip."""


class MaxwellElement(Table):
    """A spring and a damper in series."""

    stiffness_N_per_m: Positive
    """Stiffness."""
    relaxation_s: Positive
    """Damping over stiffness."""


class BushingCurve(Table):
    """Measured stiffness and loss, for "exudyn": a spring with friction and Maxwell elements in parallel,
    fitted or given."""

    axes: Annotated[str, StringConstraints(pattern=r"^[xyz]{1,3}$")] = "x"
    """Axes, as "xz"."""
    points: tuple[CurvePoint, ...] = ()
    """Measured points."""
    file: OneLine | tuple[OneLine, ...] | None = None
    """Instead: tables with the points' keys or a testing machine's names, or loops of force over
    displacement (how-to/come-from-another-program.md)."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """Unclear columns: "k" = "stiffness / kN/mm", "ignore"."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark."""
    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e4)] | None = None
    """Of a loop without times."""
    elastic_N_per_m: Positive | None = None
    """Stiffness at large amplitude, low frequency."""
    friction: tuple[FrictionElement, ...] = ()
    """Friction elements."""
    maxwell: tuple[MaxwellElement, ...] = ()
    """Maxwell elements."""


class Characteristic(Table):
    """Elastic force over deformation (progressive spring, gap, stop), linear, in place of the stiffness."""

    axes: Annotated[str, StringConstraints(pattern=r"^[xyz]{1,3}$")] = "x"
    """Axes, as "xz"."""
    deformation_m: tuple[Number, ...] = ()
    """Of the second frame against the first, growing; 0 without load."""
    force_N: tuple[Number, ...] = ()
    """Not falling; 0 at 0."""
    symmetric: Switch = False
    """Points begin at 0; both sides alike."""
    file: OneLine | None = None
    """Table instead of both (docs/how-to/come-from-another-program.md)."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """Unclear columns of ``file``."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark of ``file``."""


class BushingTemperature(Table):
    """Stiffness over temperature, which scales all forces."""

    works_at_degC: Number
    """Temperature at work."""
    measured_degC: tuple[Number, ...]
    """Temperatures of tests, growing."""
    stiffness_ratio: tuple[Positive, ...]
    """Stiffness in tests over the given one."""

    @property
    def ratio(self) -> float:
        """The stiffness where the bushing works over the given one, linear between the tests."""
        return float(np.interp(self.works_at_degC, self.measured_degC, self.stiffness_ratio))


class Bushing(Table):
    """Equal bushings between two frames, each a spring and a damper."""

    between: tuple[str, str]
    """Two frames, or one and "ground"."""
    positions_m: Vectors
    """Place of each."""
    stiffness_N_per_m: NotNegativeVector
    """Of one, along its axes; beside curves or characteristics only for estimates and linear solvers."""
    damping_N_s_per_m: NotNegativeVector = (0.0, 0.0, 0.0)
    """Viscous damping of one."""
    rotation_deg: Vector = (0.0, 0.0, 0.0)
    """Turn of its axes about x, then y, then z."""
    curves: tuple[BushingCurve, ...] = ()
    """Measured curves."""
    characteristics: tuple[Characteristic, ...] = ()
    """Force over deformation, along axes without a curve."""
    temperature: BushingTemperature | None = None
    """Stiffness over temperature."""


class Motor(Table):
    """An induction motor that slows under load, for "exudyn"."""

    rated_power_W: Positive
    """Of all the shaft's motors."""
    synchronous_speed_rad_per_s: Positive
    """Of the shaft without load, after gears."""
    rated_slip: Annotated[float, Strict(), Gt(0), Le(0.2)]
    """Lag at rated power over synchronous speed."""
    breakdown_ratio: Annotated[float, Strict(), Ge(1), Le(10)] = 2.5
    """Breakdown over rated torque."""
    moment_of_inertia_kg_m2: Positive
    """All that rotates, at the shaft's speed."""
    bearing_loss_N_m_s: NotNegative = 0.0
    """Torque over speed."""


class Bearings(Table):
    """Roller bearings that share the force, for their rating life."""

    dynamic_rating_N: Positive
    """Basic dynamic rating C."""
    count: Annotated[int, Strict(), Ge(1), Le(100)] = 2
    """Their number."""


class Exciter(Table):
    """A rotating unbalance."""

    frame: str
    """Its frame."""
    position_m: Vector
    """On its axis."""
    mass_moment_kg_m: Positive
    """Mass times eccentricity."""
    speed_rad_per_s: Positive
    """Full speed."""
    axis: Vector = (0.0, 1.0, 0.0)
    """Shaft, which turns in the positive sense."""
    start: Vector = (0.0, 0.0, 1.0)
    """Force at angle ``phase_rad``, normal to ``axis``."""
    phase_rad: Number = 0.0
    """Angle at t = 0."""
    start_s: NotNegative = 0.0
    """Start."""
    run_up_s: NotNegative = 0.0
    """From ``start_s`` to full (motor: synchronous) speed."""
    stop_s: NotNegative | None = None
    """Start of the run-down; else never."""
    run_down_s: NotNegative = 0.0
    """From ``stop_s`` to (synchronous) standstill."""
    motor: Motor | None = None
    """Motor that turns the shaft."""
    bearings: Bearings | None = None
    """Bearings of the shaft."""
