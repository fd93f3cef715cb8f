"""The steady harmonic motion of frames on bushings, with panels as springs.

    (K + i w C - w^2 M) X = F

X has the complex amplitudes of the free frames in world axes, x(t) = Re(X exp(i w t)): three
translations of each centre of mass and, with rotations, three small angles.  Driven frames have
those of their drive.  docs/theory/effects.md has the theory.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from orchestrator.case.tables.quantities import GROUND
from orchestrator.ports import Array, Indices, linear_frames
from orchestrator.ports.plans import BushingPlan, ExciterPlan, FramesPlan

LEAST_LOSS = 1e-12  # loss factor of all springs: at its own frequency an undamped mode has a limit


@dataclass(frozen=True)
class PanelSpring:
    """A panel between two frames as a spring along itself, with half of its free mass at each end.

    ``ends_m`` (2, 3) has the middles of the clamps' inner edges.
    """

    frames: tuple[str, str]
    ends_m: Array
    along: Array
    stiffness_N_per_m: float
    mass_kg: float

    def bushing(self) -> BushingPlan:
        """Return the same spring as a bushing; its place along its own line has no influence."""
        axes = np.vstack([self.along, np.zeros((2, 3))])
        stiffness_N_per_m = np.array([self.stiffness_N_per_m, 0.0, 0.0])
        return BushingPlan("", self.frames, self.ends_m[0], axes, stiffness_N_per_m, np.zeros(3))


@dataclass(frozen=True)
class Shaking:
    """The complex amplitudes (3,) of all frames and the ground at one speed of excitation."""

    speed_rad_per_s: float
    amplitude_m: dict[str, Array]
    angle_rad: dict[str, Array]

    def relative_m(self, frames: tuple[str, str]) -> Array:
        """Return the amplitude (3,) of the second frame against the first."""
        return self.amplitude_m[frames[1]] - self.amplitude_m[frames[0]]


def solve_shakings(
    plan: FramesPlan, springs: Sequence[PanelSpring] = (), loss_factor: float | None = None, freedoms: int = 3
) -> tuple[Shaking, ...]:
    """Return the steady motion at each speed of exciters and drives.

    ``loss_factor`` replaces the damping of all bushings; 0 is no damping, None keeps their own.  A
    frame has 3 ``freedoms``, or 6 with rotations.
    """
    speeds = {exciter.speed_rad_per_s for exciter in plan.exciters}
    speeds |= {drive.speed_rad_per_s for drive in plan.drives}
    return tuple(_shaking(plan, springs, loss_factor, freedoms, w) for w in sorted(speeds))


def free_frames(plan: FramesPlan) -> list[str]:
    """Return the names of the frames that have a mass and no drive."""
    return [plan.bodies[number].name for number in _free(plan)]


def _free(plan: FramesPlan) -> Indices:
    driven = {drive.body for drive in plan.drives}
    free = [n for n, body in enumerate(plan.bodies) if body.name not in driven and body.mass_kg > 0]
    return np.array(free, dtype=np.int64)


def exciter_N(exciter: ExciterPlan) -> Array:
    """Return the complex amplitude (3,) of an exciter's force, which turns from ``start`` about ``axis``."""
    size_N = exciter.mass_moment_kg_m * exciter.speed_rad_per_s**2 * np.exp(1j * exciter.phase_rad)
    return np.asarray(size_N * (exciter.start - 1j * np.cross(exciter.axis, exciter.start)))


def exciter_power_W(exciter: ExciterPlan, shaking: Shaking) -> float:
    """Return the mean power of an exciter's force in the frame's motion at the exciter's own speed."""
    if shaking.speed_rad_per_s != exciter.speed_rad_per_s:
        return 0.0
    velocity_m_per_s = 1j * exciter.speed_rad_per_s * shaking.amplitude_m[exciter.body]
    return float((exciter_N(exciter).conj() @ velocity_m_per_s).real / 2)


def _shaking(
    plan: FramesPlan,
    springs: Sequence[PanelSpring],
    loss_factor: float | None,
    freedoms: int,
    speed_rad_per_s: float,
) -> Shaking:
    every = np.arange(len(plan.bodies))
    whole = carry_panels(_with_loss(plan, loss_factor, speed_rad_per_s), springs)
    machine = linear_frames.linearise(whole, linear_frames.SPACE[:freedoms], every)
    dynamic = machine.stiffness * (1 + 1j * LEAST_LOSS) - speed_rad_per_s**2 * machine.mass
    dynamic += 1j * speed_rad_per_s * machine.damping
    amplitude, load = np.zeros((2, len(every), freedoms), dtype=complex)
    for drive in plan.drives:
        if drive.speed_rad_per_s == speed_rad_per_s:  # amplitude * sin(w t + phase)
            (number,) = linear_frames.numbers(plan, (drive.body,))
            angle = drive.rotation_rad * np.exp(1j * (drive.rotation_phase_rad - np.pi / 2))
            moved = drive.amplitude_m * np.exp(1j * (drive.phase_rad - np.pi / 2))
            moved += np.cross(angle, plan.bodies[number].center_of_mass_m - drive.center_m)
            amplitude[number] = np.hstack([moved, angle])[:freedoms]
    for exciter in plan.exciters:
        if exciter.speed_rad_per_s == speed_rad_per_s:
            (number,) = linear_frames.numbers(plan, (exciter.body,))
            arm = linear_frames.displacement(plan.bodies[number], exciter.position_m)[:, :freedoms]
            load[number] += arm.T @ exciter_N(exciter)
    free = _free(plan)
    if len(free):
        columns = (freedoms * free[:, None] + np.arange(freedoms)).ravel()
        load = load.ravel() - dynamic @ amplitude.ravel()
        moved = np.linalg.solve(dynamic[np.ix_(columns, columns)], load[columns])
        amplitude[free] = moved.reshape(-1, freedoms)
    still = np.zeros(3, dtype=complex)
    rows = {body.name: row for body, row in zip(plan.bodies, amplitude, strict=True)}
    return Shaking(
        speed_rad_per_s,
        {name: row[:3] for name, row in rows.items()} | {GROUND: still},
        {name: row[3:] if freedoms > 3 else still for name, row in rows.items()} | {GROUND: still},
    )


def _with_loss(plan: FramesPlan, loss_factor: float | None, speed_rad_per_s: float) -> FramesPlan:
    if loss_factor is None:
        return plan
    per_speed_s = loss_factor / speed_rad_per_s
    lossy = (replace(row, damping_N_s_per_m=per_speed_s * row.stiffness_N_per_m) for row in plan.bushings)
    return replace(plan, bushings=tuple(lossy))


def carry_panels(plan: FramesPlan, springs: Sequence[PanelSpring]) -> FramesPlan:
    """Return the plan with panels as bushings, and with their masses at the frames' centres of mass."""
    bodies = []
    for body in plan.bodies:
        carried_kg = sum(
            spring.mass_kg / 2 for spring in springs for end in spring.frames if end == body.name
        )
        bodies.append(replace(body, mass_kg=body.mass_kg + carried_kg))
    bushings = (*plan.bushings, *(spring.bushing() for spring in springs))
    return replace(plan, bodies=tuple(bodies), bushings=bushings)
