"""What the frames' solver needs of a case."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.deck.panels import axes, to_world, unit
from orchestrator.case.tables import frames as tables
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.ports.plans import BodyPlan, BushingPlan, DrivePlan, ExciterPlan, FramesPlan, MotorPlan


def frames_plan(case: Case, points_m: Array, carrier: tuple[str, ...], reaction_N: Array) -> FramesPlan:
    """``points_m`` (n, 3) in the world at t = 0 with their ``carrier`` frames, ``reaction_N``
    (n, 3) the panels' force on them at t = 0.

    Frames that forces do not move get drives only: no bushings, no exciters.
    """
    forces = solvers.frames(case).moved_by_forces
    frames = case.screen.frames
    return FramesPlan(
        bodies=tuple(_body(case, name, frame) for name, frame in frames.items()),
        bushings=tuple(bushings(case)) if forces else (),
        exciters=tuple(_exciters(case)) if forces else (),
        drives=tuple(_drives(case)),
        gravity_m_per_s2=np.array(case.gravity_m_per_s2),
        points_m=points_m,
        carrier=carrier,
        reaction_N=reaction_N,
        drawn_at_rest=case.screen.drawn_at_rest,
        step_s=case.frames.step_s,
        sync_interval_s=case.coupling.sync_interval_s,
    )


def _body(case: Case, name: str, frame: tables.Frame) -> BodyPlan:
    """Driven frames need no mass: it is 0 where the case gives none."""
    tensor = np.diag(frame.inertia_kg_m2 or (0.0, 0.0, 0.0))
    upper = np.zeros((3, 3))
    upper[[0, 0, 1], [1, 2, 2]] = frame.products_of_inertia_kg_m2
    turn = axes(case)
    return BodyPlan(
        name=name,
        mass_kg=frame.mass_kg or 0.0,
        inertia_kg_m2=turn @ (tensor + upper + upper.T) @ turn.T,
        center_of_mass_m=to_world(case, frame.center_of_mass_m),
    )


def bushings(case: Case) -> list[BushingPlan]:
    """One by one, in world axes."""
    from scipy.spatial.transform import Rotation

    return [
        BushingPlan(
            name=name if len(row.positions_m) == 1 else f"{name}-{number + 1}",
            bodies=row.between,
            position_m=to_world(case, position),
            axes=to_world(case, Rotation.from_euler("xyz", row.rotation_deg, True).as_matrix().T),
            stiffness_N_per_m=np.array(row.stiffness_N_per_m),
            damping_N_s_per_m=np.array(row.damping_N_s_per_m),
        )
        for name, row in case.screen.bushings.items()
        for number, position in enumerate(row.positions_m)
    ]


def _exciters(case: Case) -> list[ExciterPlan]:
    """One by one, in world axes; solvers that know no motors turn their shafts at full speed."""
    motors = solvers.frames(case).motors
    return [
        ExciterPlan(
            body=exciter.frame,
            position_m=to_world(case, exciter.position_m),
            axis=to_world(case, unit(exciter.axis)),
            start=to_world(case, unit(exciter.start)),
            mass_moment_kg_m=exciter.mass_moment_kg_m,
            speed_rad_per_s=exciter.speed_rad_per_s,
            run_up_s=exciter.run_up_s,
            phase_rad=exciter.phase_rad,
            start_s=exciter.start_s,
            motor=_motor(exciter.motor) if motors else None,
            name=name,
        )
        for name, exciter in case.screen.exciters.items()
    ]


def _motor(motor: tables.Motor | None) -> MotorPlan | None:
    if motor is None:
        return None
    return MotorPlan(
        rated_power_W=motor.rated_power_W,
        synchronous_rad_per_s=motor.synchronous_speed_rad_per_s,
        rated_slip=motor.rated_slip,
        breakdown_ratio=motor.breakdown_ratio,
        inertia_kg_m2=motor.moment_of_inertia_kg_m2,
        bearing_N_m_s=motor.bearing_loss_N_m_s,
    )


def _drives(case: Case) -> list[DrivePlan]:
    return [_drive(case, name, f.drive) for name, f in case.screen.frames.items() if f.drive]


def _drive(case: Case, name: str, drive: tables.Drive) -> DrivePlan:
    amplitude_m, phase_rad = _turned(case, drive.amplitude_m, drive.phase_rad)
    rotation_rad, rotation_phase_rad = _turned(case, drive.rotation_rad, drive.rotation_phase_rad)
    return DrivePlan(
        body=name,
        center_m=to_world(case, drive.center_m),
        speed_rad_per_s=drive.speed_rad_per_s,
        amplitude_m=amplitude_m,
        phase_rad=phase_rad,
        rotation_rad=rotation_rad,
        rotation_phase_rad=rotation_phase_rad,
        run_up_s=drive.run_up_s,
    )


def _turned(case: Case, size: Sequence[float], phase_rad: Sequence[float]) -> tuple[Array, Array]:
    """Sizes and phases along the world axes of an oscillation given along the deck axes."""
    phasor = axes(case) @ (np.array(size) * np.exp(1j * np.array(phase_rad)))
    return np.abs(phasor), np.angle(phasor)
