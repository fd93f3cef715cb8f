"""Particles, or points of the surface, that move too far in a step of the particles."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.case.solver_plans import particle_step_s
from orchestrator.run.monitor.item import MonitorItem, Observation, OutputTime, Subject


class LongSteps(MonitorItem):
    """The longest motion in a particle step: of particles in their own radii, of the surface in the
    smallest one."""

    name = "long_steps"
    limit_key = "largest_step_share"
    message = "{where} moves in a particle step by {value:.2g} of a radius"

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self._step_s = particle_step_s(subject.case)

    def observe_output(self, output: OutputTime) -> Iterator[Observation]:
        if output.bed is None or not len(output.bed[0].id):
            return
        particles, surface = output.bed[0], output.state.panel.surface
        radius_m = particles.diameter_m / 2
        share = self._step_s * np.linalg.norm(particles.velocity_m_per_s, axis=1) / radius_m
        farthest = int(np.argmax(share))
        yield Observation(float(share[farthest]), f"particle {particles.id[farthest]}")
        fastest_m_per_s = np.linalg.norm(surface.velocity_m_per_s, axis=1).max(initial=0.0)
        yield Observation(float(self._step_s * fastest_m_per_s / radius_m.min()), "the surface")
