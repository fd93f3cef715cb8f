"""Free frames as matrices: their mass, the panels as springs, bushings, and what they carry."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag, eigh

from orchestrator.case import solvers
from orchestrator.ports import Array
from orchestrator.ports.plans import FramesPlan
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import (
    Joint,
    assembled,
    bushing_N_per_m,
    free_frames,
    mass_of,
    numbered,
    panel_joints,
)


@dataclass(frozen=True)
class FrameMatrices:
    """Square, over all coordinates of the free frames (3 each, or 6 with rotations):
    ``mass`` of the frames alone, ``carried`` of the panels whose ends are on them, ``panels_N_per_m``
    taut and at their stiffest, ``bushings_N_per_m`` and their ``damping_N_s_per_m``."""

    mass: Array
    carried: Array
    panels_N_per_m: Array
    bushings_N_per_m: Array
    damping_N_s_per_m: Array
    freedoms: int

    @property
    def lightest_kg(self) -> float:
        """The least of the frames' masses."""
        return float(np.min(np.diag(self.mass)[:: self.freedoms]))

    def modes(self) -> tuple[Array, Array]:
        """Angular frequencies, and shapes as columns, of frames with panels on them."""
        square, shapes = eigh(self.panels_N_per_m + self.bushings_N_per_m, self.mass + self.carried)
        return np.sqrt(np.maximum(square, 0.0)), shapes


def frame_matrices(scene: Scene) -> FrameMatrices | None:
    """None where no frame is free to be pushed."""
    case, plan = scene.case, scene.plan
    solver = solvers.frames(case)
    if not (solver.moved_by_forces and free_frames(plan)):
        return None
    freedoms = 6 if solver.rotates else 3
    springs = [
        replace(spring, stiffness_N_per_m=panel.taut_stiffness_N_per_m * panel.stiffening)
        for spring, panel in zip(scene.springs, scene.panels, strict=True)
    ]
    if not solvers.panel(case).yields:  # no springs
        springs = []
    bodies = {body.name: body for body in plan.bodies}
    masses = [mass_of(bodies[name])[:freedoms, :freedoms] for name in free_frames(plan)]
    halves = [
        Joint(("ground", name), (end_m, end_m), panel.whole_mass_kg / 2 * np.eye(3))
        for spring, panel in zip(scene.springs, scene.panels, strict=True)
        for name, end_m in zip(spring.frames, spring.ends_m, strict=True)
    ]
    joints = [(one, (one.position_m, one.position_m)) for one in plan.bushings]
    static = [Joint(b.bodies, places, bushing_N_per_m(b, 0.0, None)) for b, places in joints]
    at_one = [Joint(b.bodies, places, bushing_N_per_m(b, 1.0, None)) for b, places in joints]
    return FrameMatrices(
        mass=np.asarray(block_diag(*masses)),
        carried=_free(plan, halves, freedoms).real,
        panels_N_per_m=_free(plan, panel_joints(springs), freedoms).real,
        bushings_N_per_m=_free(plan, static, freedoms).real,
        damping_N_s_per_m=_free(plan, at_one, freedoms).imag,
        freedoms=freedoms,
    )


def _free(plan: FramesPlan, joints: Iterable[Joint], freedoms: int) -> Array:
    """Assembled over the free frames' coordinates, one after the other."""
    numbers = numbered(plan)
    free = [numbers[name] for name in free_frames(plan)]
    every, size = range(freedoms), freedoms * len(free)
    whole = assembled(plan, joints, freedoms)[np.ix_(free, every, free, every)]
    return np.asarray(whole.reshape(size, size))
