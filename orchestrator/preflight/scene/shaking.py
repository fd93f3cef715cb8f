"""The steady harmonic motion of frames on bushings, with panels as springs.

    (K + i w C - w^2 M) X = F

Complex amplitudes X of the free frames in world axes, x(t) = Re(X exp(i w t)): three translations
of the centre of mass each or, with rotations, three small angles besides.  Driven frames have
their drive's translation (its rotation is left out).  Theory: docs/theory/effects.md.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from orchestrator.case.tables.quantities import GROUND
from orchestrator.ports import Array
from orchestrator.ports.plans import BodyPlan, BushingPlan, ExciterPlan, FramesPlan


@dataclass(frozen=True)
class PanelSpring:
    """A panel between two frames as a spring along itself; its free part's mass rides with both
    ends by half.  ``ends_m`` (2, 3): the middles of its clamps' inner edges."""

    frames: tuple[str, str]
    ends_m: Array
    along: Array
    stiffness_N_per_m: float
    mass_kg: float


@dataclass(frozen=True)
class Shaking:
    """Amplitudes (3,), complex, of all frames and the ground at one speed of excitation."""

    speed_rad_per_s: float
    amplitude_m: dict[str, Array]
    angle_rad: dict[str, Array]

    def relative_m(self, frames: tuple[str, str]) -> Array:
        """Of the second frame against the first."""
        return self.amplitude_m[frames[1]] - self.amplitude_m[frames[0]]


@dataclass(frozen=True)
class Joint:
    """A bushing or panel between two frames: complex stiffness (3, 3) between two places."""

    frames: tuple[str, str]
    places_m: tuple[Array, Array]
    stiffness_N_per_m: Array


def solve_shakings(
    plan: FramesPlan, springs: Sequence[PanelSpring] = (), loss_factor: float | None = None, freedoms: int = 3
) -> tuple[Shaking, ...]:
    """One for each speed of exciters and drives.  ``loss_factor``: of all bushings, in place of
    their own damping (0: none).  ``freedoms`` 3, or 6 with rotations."""
    speeds = {one.speed_rad_per_s for one in plan.exciters} | {one.speed_rad_per_s for one in plan.drives}
    return tuple(_shaking(plan, springs, loss_factor, freedoms, w) for w in sorted(speeds))


def free_frames(plan: FramesPlan) -> list[str]:
    """Frames with a mass that no drive moves."""
    driven = {drive.body for drive in plan.drives}
    return [body.name for body in plan.bodies if body.name not in driven and body.mass_kg > 0]


def _exciter_N(exciter: ExciterPlan, speed_rad_per_s: float) -> Array:
    """Complex amplitude (3,): the force turns from ``start`` about ``axis``."""
    size_N = exciter.mass_moment_kg_m * speed_rad_per_s**2 * np.exp(1j * exciter.phase_rad)
    return np.asarray(size_N * (exciter.start - 1j * np.cross(exciter.axis, exciter.start)))


def _joints(
    plan: FramesPlan, springs: Sequence[PanelSpring], loss_factor: float | None, speed_rad_per_s: float
) -> Iterator[Joint]:
    for bushing in plan.bushings:
        place_m = bushing.position_m
        stiffness = bushing_N_per_m(bushing, speed_rad_per_s, loss_factor)
        yield Joint(bushing.bodies, (place_m, place_m), stiffness)
    yield from panel_joints(springs)


def panel_joints(springs: Iterable[PanelSpring]) -> Iterator[Joint]:
    """Panels as springs along themselves."""
    for spring in springs:
        stiffness = spring.stiffness_N_per_m * np.outer(spring.along, spring.along)
        yield Joint(spring.frames, (spring.ends_m[0], spring.ends_m[1]), stiffness)


def bushing_N_per_m(bushing: BushingPlan, speed_rad_per_s: float, loss_factor: float | None) -> Array:
    """Complex stiffness (3, 3) in world axes."""
    if loss_factor is None:
        along = bushing.stiffness_N_per_m + 1j * speed_rad_per_s * bushing.damping_N_s_per_m
    else:
        along = bushing.stiffness_N_per_m * (1 + 1j * loss_factor)
    return np.asarray(bushing.axes.T @ (along[:, None] * bushing.axes))


def _moved(body: BodyPlan, place_m: Array, freedoms: int) -> Array:
    """(3, freedoms): displacement of a body's point per coordinate."""
    x, y, z = place_m - body.center_of_mass_m
    turned = np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])
    return np.hstack([np.eye(3), turned])[:, :freedoms]


def _shaking(
    plan: FramesPlan,
    springs: Sequence[PanelSpring],
    loss_factor: float | None,
    freedoms: int,
    speed_rad_per_s: float,
) -> Shaking:
    numbers = frame_numbers(plan)
    joints = _joints(plan, springs, loss_factor, speed_rad_per_s)
    dynamic = assemble_stiffness(plan, joints, freedoms)
    for number, body in enumerate(plan.bodies):
        dynamic[number, :, number] -= speed_rad_per_s**2 * mass_matrix(body, springs)[:freedoms, :freedoms]
    found = _solved(plan, numbers, dynamic, speed_rad_per_s)
    still = np.zeros(3, dtype=complex)
    turned = {name: row[3:] if freedoms > 3 else still for name, row in found.items()}
    moved = {name: row[:3] for name, row in found.items()}
    return Shaking(speed_rad_per_s, moved | {GROUND: still}, turned | {GROUND: still})


def frame_numbers(plan: FramesPlan) -> dict[str, int]:
    """The number of each frame."""
    return {body.name: number for number, body in enumerate(plan.bodies)}


def assemble_stiffness(plan: FramesPlan, joints: Iterable[Joint], freedoms: int) -> Array:
    """Stiffness (frames, freedoms, frames, freedoms), complex, of joints between all frames."""
    numbers = frame_numbers(plan)
    whole = np.zeros((len(numbers), freedoms, len(numbers), freedoms), dtype=complex)
    for joint in joints:
        ends = [
            (numbers[name], sign * _moved(plan.bodies[numbers[name]], place_m, freedoms))
            for name, place_m, sign in zip(joint.frames, joint.places_m, (-1, 1), strict=True)
            if name in numbers
        ]
        for (row, one), (column, two) in product(ends, ends):
            whole[row, :, column] += one.T @ joint.stiffness_N_per_m @ two
    return whole


def mass_matrix(body: BodyPlan, springs: Sequence[PanelSpring] = ()) -> Array:
    """(6, 6) of a frame; the panels' share rides at the centre of mass."""
    from scipy.linalg import block_diag

    halves_kg = [spring.mass_kg / 2 for spring in springs for end in spring.frames if end == body.name]
    return np.asarray(block_diag((body.mass_kg + sum(halves_kg)) * np.eye(3), body.inertia_kg_m2))


def _solved(
    plan: FramesPlan, numbers: dict[str, int], dynamic: Array, speed_rad_per_s: float
) -> dict[str, Array]:
    """Amplitudes: driven frames as given, free ones from the equations, others stand still."""
    freedoms = dynamic.shape[1]
    amplitude = np.zeros((len(numbers), freedoms), dtype=complex)
    load = np.zeros_like(amplitude)
    for drive in plan.drives:
        if drive.speed_rad_per_s == speed_rad_per_s:  # amplitude * sin(w t + phase)
            phasor = drive.amplitude_m * np.exp(1j * (drive.phase_rad - np.pi / 2))
            amplitude[numbers[drive.body], :3] = phasor
    for exciter in plan.exciters:
        if exciter.speed_rad_per_s == speed_rad_per_s:
            number = numbers[exciter.body]
            arm = _moved(plan.bodies[number], exciter.position_m, freedoms)
            load[number] += arm.T @ _exciter_N(exciter, speed_rad_per_s)
    free = [numbers[name] for name in free_frames(plan)]
    if free:
        load = load - np.einsum("aibj,bj->ai", dynamic, amplitude)
        size = freedoms * len(free)
        every = range(freedoms)
        matrix = dynamic[np.ix_(free, every, free, every)].reshape(size, size)
        amplitude[free] = np.linalg.solve(matrix, load[free].ravel()).reshape(-1, freedoms)
    return dict(zip(numbers, amplitude, strict=True))
