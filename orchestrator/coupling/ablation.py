"""Ablation: exchanges turned off one by one to show their effect (``[exchange]`` in a case).

Each class wraps one solver while the machine is built; a run with every exchange on uses none of them.
An exchange that is off leaves out physics: momentum and energy no longer close across its
interface, and the run's log says so.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.coupling.wrappers import FramesWrapper, PanelWrapper, ParticlesWrapper
from orchestrator.ports import (
    ContactTangent,
    Frames,
    HermitePath,
    Inertia,
    Known,
    Load,
    Motion,
    Panel,
    PanelState,
    Particles,
)
from orchestrator.ports.clock import Interval


class UnpushedFrames(FramesWrapper):
    """Frames that do not feel the panels.

    Their motion depends on no other member.  The first call of ``ahead`` therefore moves them, and
    ``advance`` returns the same motion.
    """

    def __init__(self, frames: Frames) -> None:
        super().__init__(frames)
        self._points = len(frames.initial())
        self._moved: Known | None = None

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        motion, self._moved = self.ahead(interval).motion, None
        return motion

    def ahead(self, interval: Interval) -> Known:
        if self._moved is None:
            motion = self._solver.advance(interval, Load.zero(self._points))
            self._moved = Known(motion, np.ones(len(motion), dtype=np.bool_))
        return self._moved


class UnloadedPanel(PanelWrapper):
    """A panel that does not feel the particles' load, and whose masses are unknown to the particles."""

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return super().advance(interval, clamps, Load.zero(len(load)))

    def inertia(self) -> Inertia:
        return Inertia.unknown(len(self.initial().surface))


class PanelBetweenStillClamps(PanelWrapper):
    """A panel with clamps that stay where they were at t = 0."""

    def __init__(self, panel: Panel) -> None:
        super().__init__(panel)
        self._still = Motion(panel.mount.position_m, 0.0 * panel.mount.position_m)

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return super().advance(interval, self._still, load)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        return super().ahead(interval, Known(self._still, np.ones(len(self._still), dtype=np.bool_)))


class ParticlesOnStillSurface(ParticlesWrapper):
    """Particles that see the surface as it was at t = 0."""

    def __init__(self, particles: Particles, surface: Motion) -> None:
        super().__init__(particles)
        self._still = Motion(surface.position_m, 0.0 * surface.velocity_m_per_s)

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        return super().advance(interval, HermitePath(self._still, self._still, path.length_s))

    def contact_tangent(self, length_s: float) -> ContactTangent:
        """Predict a load that does not depend on the surface's motion."""
        tangent = super().contact_tangent(length_s)
        return replace(tangent, impedance_N_s_per_m=0.0 * tangent.impedance_N_s_per_m)
