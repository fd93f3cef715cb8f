"""What is looked at at output times: stretch of the panels, surfaces that they have gone through,
overlaps, and motion per step."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.coupling.machine import PanelPoints
from orchestrator.coupling.schemes.exchange import State
from orchestrator.ports import Array, Motion, ParticleSnapshot
from orchestrator.ports.particle_records import Bed
from orchestrator.ports.penetration import Penetrations
from orchestrator.run.monitor.limits import Figures


class OutputWatch:
    """``step_s``: the particles' step."""

    def __init__(self, panels: Sequence[PanelPoints], penetrations: Penetrations, step_s: float) -> None:
        self._panels, self._penetrations, self._step_s = panels, penetrations, step_s

    def look(self, figures: Figures, time_s: float, state: State, bed: Bed | None) -> None:
        surface = state.panel.surface
        for panel in self._panels:
            stretch = largest_stretch(panel, surface.position_m)
            figures.look("stretched_panels", stretch, time_s, panel.name)
        if (through := self._penetrations.deepest(surface.position_m)) is not None:
            where = f"{through.panel} has gone through {through.surface}"
            figures.look("penetrated_surfaces", through.thicknesses, time_s, where)
        if bed is not None and len(bed[0].id):
            particles, overlaps = bed
            deepest = 2 * max(overlaps.between_per_diameter, overlaps.surface_per_diameter)
            figures.look("deep_overlaps", deepest, time_s)
            share, number = self._longest(particles)
            figures.look("long_steps", share, time_s, f"particle {number}")
            share = self._step_s * _fastest_m_per_s(surface) / (particles.diameter_m.min() / 2)
            figures.look("long_steps", share, time_s, "the surface")

    def _longest(self, particles: ParticleSnapshot) -> tuple[float, int]:
        """The longest motion in a step, of the particle's own radius, and whose it is."""
        speed_m_per_s = np.linalg.norm(particles.velocity_m_per_s, axis=1)
        share = self._step_s * speed_m_per_s / (particles.diameter_m / 2)
        row = int(np.argmax(share))
        return float(share[row]), int(particles.id[row])


def largest_stretch(panel: PanelPoints, surface_m: Array) -> float:
    """Of all edges of the panel's triangles, over their stress-free lengths, less one."""
    ends_m = surface_m[panel.edges]
    length_m = np.linalg.norm(ends_m[:, 1] - ends_m[:, 0], axis=1)
    return float((length_m / panel.edge_length_m).max()) - 1.0


def _fastest_m_per_s(surface: Motion) -> float:
    return float(np.sqrt(np.einsum("ij,ij->i", *2 * [surface.velocity_m_per_s]).max(initial=0.0)))
