"""Gravity, which always matters, except in a case of driven frames alone.

The number compares it with the throw.
"""

from __future__ import annotations

import math

from orchestrator.case.tables.case import has_particles
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames


def judge(scene: Scene) -> Verdict:
    """Judge gravity, which matters wherever particles, panels or free frames have weight."""
    needed = has_particles(scene.case) or bool(scene.panels) or bool(free_frames(scene.plan))
    return Verdict(
        number="1 / throw",
        value=1 / scene.throw if scene.throw else math.inf,
        threshold="always",
        matters=needed,
        why="particles fall, panels and frames hang" if needed else "nothing here can fall",
        cost="nothing",
    )


EFFECT = Effect(
    part="machine",
    judge=judge,
    described=lambda case: any(case.gravity_m_per_s2),
    key="gravity_m_per_s2",
    checked_by="frames_throw",
)
