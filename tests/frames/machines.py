"""Small machines that the tests of the frames share: numbers near those of a real screen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.ports import Array, linear_frames
from orchestrator.ports.plans import (
    BodyPlan,
    BushingPlan,
    CharacteristicPlan,
    ExciterPlan,
    FramesPlan,
    HysteresisPlan,
)

GRAVITY = np.array([0.0, 0.0, -9.81])
ALONG, ACROSS, UP = np.eye(3)
POINTS_M = np.array([[-1.2, 0.4, 0.1], [1.2, -0.4, 0.1], [-1.0, 0.4, 0.4], [1.0, -0.3, 0.4]])


def body(name: str, mass_kg: float = 764.0, center_m: Array | None = None) -> BodyPlan:
    center_m = np.zeros(3) if center_m is None else center_m
    inertia = np.diag([0.3, 0.67, 0.8]) * mass_kg
    return BodyPlan(name, mass_kg, inertia, center_m)


def bushing(
    bodies: tuple[str, str],
    position_m: Array,
    stiffness_N_per_m: tuple[float, float, float],
    loss_factor: float = 0.1,
    axes: Array | None = None,
) -> BushingPlan:
    """Damped so that a loss factor at 78.5 rad/s results."""
    k = np.array(stiffness_N_per_m)
    name = f"{bodies[0]}-{bodies[1]}-{position_m.tolist()}"
    axes = np.eye(3) if axes is None else axes
    return BushingPlan(name, bodies, position_m, axes, k, loss_factor * k / 78.5)


def exciter(speed_rad_per_s: float = 78.5, run_up_s: float = 0.0, **changed: object) -> ExciterPlan:
    given = {"body": "driving", "position_m": np.zeros(3), "axis": ACROSS, "start": UP}
    given |= {"mass_moment_kg_m": 3.5, "phase_rad": 0.0} | changed
    return ExciterPlan(speed_rad_per_s=speed_rad_per_s, run_up_s=run_up_s, **given)  # type: ignore[arg-type]


def two_bodies(
    exciters: tuple[ExciterPlan, ...] = (),
    drawn_at_rest: bool = True,
    interval_s: float = 1e-3,
    step_s: float = 0.0,
    loss_factor: float = 0.1,
) -> FramesPlan:
    """Return two bodies whose centres of mass coincide and whose bushings lie symmetrically about them, so
    that a centred exciter makes no pitch: the two-mass closed form holds for six freedoms too."""
    ground = (225e3, 225e3, 225e3)
    shear = (1.185e6, 3e6, 2.9e6)
    places = [np.array([x, y, 0.0]) for x in (-0.9, 0.9) for y in (-0.4, 0.4)]
    bushings = [bushing(("ground", "driving"), p, ground, loss_factor) for p in places]
    ends = [np.array([x, 0.0, 0.0]) for x in (-0.85, 0.85)]
    bushings += [bushing(("driving", "driven"), p, shear, loss_factor) for p in ends]
    side = [np.array([0.0, y, z]) for y in (-0.4, 0.4) for z in (-0.2, 0.2)]
    bushings += [bushing(("driving", "driven"), p, (1e0, 1e3, 1e3), loss_factor) for p in side]
    return FramesPlan(
        bodies=(body("driving"), body("driven", 287.0)),
        bushings=tuple(bushings),
        exciters=exciters,
        drives=(),
        gravity_m_per_s2=GRAVITY,
        points_m=POINTS_M,
        carrier=("driving", "driving", "driven", "driven"),
        reaction_N=np.zeros((4, 3)),
        drawn_at_rest=drawn_at_rest,
        step_s=step_s,
        sync_interval_s=interval_s,
    )


def steady_amplitudes_m(plan: FramesPlan, speed_rad_per_s: float) -> Array:
    """Complex amplitudes X (bodies, 3) of translations in the steady state at any constant speed of all
    exciters:  x(t) = Re(X exp(i speed t)), with every exciter at its ``phase_rad`` at t = 0."""
    machine = linear_frames.linearise(plan, linear_frames.TRANSLATIONS)
    force_N = np.zeros((len(plan.bodies), 3), dtype=complex)
    for exciter in plan.exciters:
        turning = exciter.start - 1j * np.cross(exciter.axis, exciter.start)
        size_N = exciter.mass_moment_kg_m * speed_rad_per_s**2 * np.exp(1j * exciter.phase_rad)
        force_N[linear_frames.numbers(plan, (exciter.body,))[0]] += size_N * turning
    dynamic = machine.stiffness + 1j * speed_rad_per_s * machine.damping
    dynamic = dynamic - speed_rad_per_s**2 * machine.mass
    return np.asarray(np.linalg.solve(dynamic, force_N.ravel()).reshape(-1, 3))


def with_elements(plan: FramesPlan) -> FramesPlan:
    """The same machine with friction and Maxwell elements along the x axes of the bushings that have more
    than 1 MN/m there, and along the z axes of those to the ground."""

    def elements(bushing: BushingPlan) -> tuple[HysteresisPlan, ...]:
        axis = 2 if "ground" in bushing.bodies else 0
        k = float(bushing.stiffness_N_per_m[axis])
        if axis == 0 and k < 1e6:
            return ()
        slip_m = np.array([2e-4, 1e-3])
        friction, maxwell = np.array([0.1, 0.1]) * k, np.array([0.1 * k])
        return (HysteresisPlan(axis, 0.8 * k, friction, slip_m, maxwell, np.array([0.01])),)

    return replace(plan, bushings=tuple(replace(b, hysteresis=elements(b)) for b in plan.bushings))


def with_gaps(plan: FramesPlan) -> FramesPlan:
    """The same machine with stops of 1 mm gap on both sides along the x axes of the bushings that have more
    than 1 MN/m there, and with bushings to the ground that stiffen at 5 mm, which their sag exceeds."""

    def characteristic(bushing: BushingPlan) -> tuple[CharacteristicPlan, ...]:
        axis = 2 if "ground" in bushing.bodies else 0
        k = float(bushing.stiffness_N_per_m[axis])
        if axis == 0 and k < 1e6:
            return ()
        side = np.array([1.0, -1.0])
        return (CharacteristicPlan(axis, k, side, np.full(2, 5e-3 if axis else 1e-3), np.full(2, 0.6 * k)),)

    changed = (replace(b, characteristics=characteristic(b)) for b in plan.bushings)
    return replace(plan, bushings=tuple(changed))
