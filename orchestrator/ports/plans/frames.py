"""What the frames' solver needs to know."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.ports import Array


@dataclass(frozen=True)
class BodyPlan:
    """A rigid frame: mass, inertia about the centre of mass in world axes at t = 0."""

    name: str
    mass_kg: float
    inertia_kg_m2: Array  # (3, 3)
    center_of_mass_m: Array  # (3,)


@dataclass(frozen=True)
class BushingPlan:
    """Linear spring and damper along three axes between two bodies ("ground" is the fixed one).

    ``axes`` (3, 3): its rows are the spring axes in the world at t = 0, ``stiffness_N_per_m`` and
    ``damping_N_s_per_m`` (3,) belong to them; the axes turn with the first body.  Force-free at
    t = 0 but for the preload that holds the bodies' weight when the frames are drawn at rest.
    """

    name: str
    bodies: tuple[str, str]
    position_m: Array
    axes: Array
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array


@dataclass(frozen=True)
class MotorPlan:
    """An induction motor by its rating: lags behind ``synchronous_rad_per_s`` by ``rated_slip`` of it
    at ``rated_power_W``; its breakdown torque is ``breakdown_ratio`` times the rated one.
    ``inertia_kg_m2`` of all that turns, the unbalance included; ``bearing_N_m_s`` torque lost per
    speed."""

    rated_power_W: float
    synchronous_rad_per_s: float
    rated_slip: float
    breakdown_ratio: float
    inertia_kg_m2: float
    bearing_N_m_s: float


@dataclass(frozen=True)
class ExciterPlan:
    """A rotating unbalance: force of size  mass_moment * speed^2  turning about ``axis``.

    It stands still until ``start_s``.  Then the angle runs up smoothly: with t from there,
    speed(t) = speed_rad_per_s * (1 - cos(pi t / run_up_s)) / 2 until ``run_up_s``, then constant; at
    angle = ``phase_rad`` the force points along ``start`` (a unit vector normal to ``axis``;
    positive rotation about ``axis``).  The force is the unbalance's inertia force:
    mass_moment * (speed^2 radial - d(speed)/dt tangential).  With a ``motor``, where the solver
    knows motors, the speed is what its torque makes of it, and ``run_up_s`` is that of the
    synchronous speed.
    """

    body: str
    position_m: Array
    axis: Array
    start: Array
    mass_moment_kg_m: float
    speed_rad_per_s: float
    run_up_s: float
    phase_rad: float = 0.0
    start_s: float = 0.0
    motor: MotorPlan | None = None
    name: str = ""


@dataclass(frozen=True)
class DrivePlan:
    """Prescribed harmonic motion of a body about its place at t = 0, with smooth run-up.

    Nothing turns the body from it; one drive per body.  Bodies without one are free, or stand
    still where the frames are prescribed altogether.

    Translation amplitude_m * sin(w t + phase_rad), and rotation by the vector
    rotation_rad * sin(w t + rotation_phase_rad) about ``center_m``; each (3,), component-wise.
    Both are multiplied by (1 - cos(pi t / run_up_s)) / 2 until ``run_up_s``.
    """

    body: str
    center_m: Array
    speed_rad_per_s: float
    amplitude_m: Array
    phase_rad: Array
    rotation_rad: Array
    rotation_phase_rad: Array
    run_up_s: float


@dataclass(frozen=True)
class FramesPlan:
    """Frames and the points they carry: ``points_m`` (n, 3) at t = 0, ``carrier`` (n,) names.

    ``reaction_N`` (n, 3) is the panels' force at t = 0.  With ``drawn_at_rest`` the bushings'
    preload holds weight and initial reaction, so that nothing moves until something drives;
    otherwise the machine drops onto force-free bushings.
    """

    bodies: tuple[BodyPlan, ...]
    bushings: tuple[BushingPlan, ...]
    exciters: tuple[ExciterPlan, ...]
    drives: tuple[DrivePlan, ...]
    gravity_m_per_s2: Array
    points_m: Array
    carrier: tuple[str, ...]
    reaction_N: Array
    drawn_at_rest: bool
    step_s: float
    sync_interval_s: float
