"""The forces on a machine's supports, at rest and in steady motion, and the power that its exciters give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.case.tables.quantities import GROUND
from orchestrator.ports import linear_frames
from orchestrator.preflight.scene.frame_motion import largest_m, spatial_shakings
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import carry_panels, exciter_power_W, free_frames


@dataclass(frozen=True)
class SupportForce:
    """The size of a bushing's force on the ground: at rest, under frames and panels, and its amplitude."""

    name: str
    static_N: float
    dynamic_N: float


def support_forces(scene: Scene) -> tuple[SupportForce, ...]:
    """Return the forces of all bushings that stand on the ground; none where a drive moves a frame.

    What moves a driven frame stands on the ground, too, and its force is not known.
    """
    plan = scene.plan
    if plan.drives or not scene.case.frames.adapter.moved_by_forces:
        return ()
    shakings, freedoms = spatial_shakings(scene)
    names = tuple(free_frames(plan))
    whole = carry_panels(plan, scene.springs)
    machine = linear_frames.linearise(
        whole, linear_frames.SPACE[:freedoms], linear_frames.numbers(plan, names)
    )
    weight_N = np.zeros((len(names), freedoms))
    weight_N[:, :3] = [body.mass_kg * plan.gravity_m_per_s2 for body in whole.bodies if body.name in names]
    sag, _ = machine.hold(weight_N.ravel())
    static_N = machine.stiffness_N_per_m * (machine.stretch @ sag)
    amplitudes_N = []
    for shaking in shakings:
        motions = [
            np.hstack([shaking.amplitude_m[name], shaking.angle_rad[name]])[:freedoms] for name in names
        ]
        stretch_m = machine.stretch @ np.hstack(motions)
        stiffness = machine.stiffness_N_per_m + 1j * shaking.speed_rad_per_s * machine.damping_N_s_per_m
        amplitudes_N.append((stiffness * stretch_m).reshape(-1, 3))
    return tuple(
        SupportForce(
            bushing.name,
            float(np.linalg.norm(static_N.reshape(-1, 3)[number])),
            sum(largest_m(force_N[number]) for force_N in amplitudes_N),
        )
        for number, bushing in enumerate(plan.bushings)
        if GROUND in bushing.bodies
    )


def power_W(scene: Scene) -> float:
    """Return the mean power of the exciters in the steady motion, which goes into the bushings' damping."""
    return sum(
        exciter_power_W(exciter, shaking) for exciter in scene.plan.exciters for shaking in scene.shaken
    )
