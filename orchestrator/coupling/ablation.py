"""Ablation: hand-overs turned off one by one, to see what each of them does (``[exchange]`` in a case).

Each is a wrapper around one solver, put on while the machine is built; a run with every
hand-over on knows nothing of this file.  What is turned off is physics left out: momentum and
energy no longer close across that interface, and the run's log says so.
"""

from __future__ import annotations

from dataclasses import replace
from typing import cast

import numpy as np

from orchestrator.coupling.altered_panel import AlteredPanel
from orchestrator.ports import (
    Account,
    ContactTangent,
    Crossings,
    Frames,
    HermitePath,
    Inertia,
    Known,
    Load,
    Motion,
    Overlaps,
    Panel,
    PanelState,
    Particles,
    ParticleSnapshot,
    Predicting,
    Removed,
    Saved,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import surface_ahead


class UnpushedFrames:
    """Frames that do not feel the panels, so that nothing has to be awaited to know where they go:
    they are moved as soon as that is asked for, and ``advance`` says it again."""

    def __init__(self, frames: Frames) -> None:
        self._frames, self._points = frames, len(frames.initial())
        self._moved: Known | None = None

    def initial(self) -> Motion:
        return self._frames.initial()

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        motion, self._moved = self.ahead(interval).motion, None
        return motion

    def ahead(self, interval: Interval) -> Known:
        if self._moved is None:
            motion = self._frames.advance(interval, Load.zero(self._points))
            self._moved = Known(motion, np.ones(len(motion), dtype=np.bool_))
        return self._moved

    def account(self) -> Account:
        return self._frames.account()

    def save(self) -> Saved:
        return self._frames.save()

    def restore(self, saved: Saved) -> None:
        self._frames.restore(saved)

    def close(self) -> None:
        self._frames.close()


def ignore_load(panel: Panel) -> AlteredPanel:
    """Returns the panel without the particles' load; its masses are not told to them."""

    def advance(interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return panel.advance(interval, clamps, Load.zero(len(load)))

    def inertia() -> Inertia:
        return Inertia.unknown(len(panel.initial().surface))

    return AlteredPanel(panel, advance, inertia=inertia)


def fix_clamps(panel: Panel) -> AlteredPanel:
    """Returns the panel with clamps that stay where they were at t = 0."""
    still = Motion(panel.mount.position_m, 0.0 * panel.mount.position_m)
    known = Known(still, np.ones(len(still), dtype=np.bool_))
    follow = surface_ahead(panel)

    def advance(interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return panel.advance(interval, still, load)

    def ahead(interval: Interval, clamps: Known) -> Known:
        return follow(interval, known)

    return AlteredPanel(panel, advance, ahead=ahead)


class ParticlesOnStillSurface:
    """Particles that see the surface as it was at t = 0."""

    def __init__(self, particles: Particles, surface: Motion) -> None:
        self._particles = particles
        self._still = Motion(surface.position_m, 0.0 * surface.velocity_m_per_s)

    def initial(self) -> Load:
        return self._particles.initial()

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        return self._particles.advance(interval, HermitePath(self._still, self._still, path.length_s))

    def contact_tangent(self, length_s: float) -> ContactTangent:
        """Predicts a load that does not depend on the surface's motion."""
        told = cast(Predicting, self._particles).contact_tangent(length_s)
        return replace(told, impedance_N_s_per_m=0.0 * told.impedance_N_s_per_m)

    def snapshot(self) -> ParticleSnapshot:
        return self._particles.snapshot()

    def removed(self) -> Removed:
        return self._particles.removed()

    def overlaps(self) -> Overlaps:
        return self._particles.overlaps()

    def crossings(self) -> Crossings:
        return self._particles.crossings()

    def account(self) -> Account:
        return self._particles.account()

    def save(self) -> Saved:
        return self._particles.save()

    def restore(self, saved: Saved) -> None:
        self._particles.restore(saved)

    def close(self) -> None:
        self._particles.close()
