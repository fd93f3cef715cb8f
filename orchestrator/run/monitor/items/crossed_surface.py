"""Particles whose centres went through the surface."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.run.monitor.item import MonitorItem, Observation


class CrossedSurface(MonitorItem):
    """How often a particle went through the surface elsewhere than through an opening."""

    name = "crossed_surface"
    limit_key = "most_crossings"
    message = (
        "{value:.0f} times a particle went through the surface, its centre to the other side, the "
        "first time {where}: contacts too soft (particles.largest_youngs_modulus_Pa) or steps too "
        "long"
    )

    def observe(self) -> Iterator[Observation]:
        particles = self.subject.machine.solvers.particles
        if particles is not None and (crossings := particles.crossings()).number:
            yield Observation(crossings.number, crossings.first_in_words())
