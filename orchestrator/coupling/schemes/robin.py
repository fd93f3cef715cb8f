"""The particles' contacts stand in for the particles while the surface's way is sought.

``robin`` runs each solver once in an interval, and the panel a second time, for a trial: under the
last interval's load, after which it is taken back.  With that and with what the particles foretell
of their load (``Response``) the chord is found along which the surface will go,

    v = v_trial + s H / (2 M) (push - Z v - load_before),

for all masses M of the surface at once: H / (2 M) is what a constant load moves of a free mass, s
the share of that which the panel showed in the last interval.  The particles then move on that
chord, the panel under the mean load that they give, and momentum is exact.  The chord starts where
the particles last saw the surface, so that their path has no jumps.  The name is that of Robin's
condition, which ties force to velocity (for fluids: Badia, S., Nobile, F. and Vergara, C., Journal
of Computational Physics 227, 2008, 7027-7051, doi 10.1016/j.jcp.2008.04.006).

Where nothing is known of a surface's masses it goes on as with ``particles_first``: where a drive
has it, or else at its velocity.  Where nothing is known of any (rigid panels), that is the scheme.
"""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from orchestrator.coupling.schemes.exchange import Scheme, Solvers, State
from orchestrator.coupling.schemes.staggered import particles_first
from orchestrator.coupling.schemes.steps import Ahead, ahead, ended
from orchestrator.coupling.schemes.yielding import Yielding, against
from orchestrator.ports import Array, Load, Motion, Responding, Response, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.hermite import Path
from orchestrator.ports.state import restorable, restore_attributes, save_attributes


def robin() -> Scheme:
    scheme = Robin()
    return Scheme(scheme.advance, memory=scheme)


class Robin:
    """The scheme, and what it remembers: where the particles last saw the surface (None: nowhere
    yet), and the share s, one of each direction in space."""

    def __init__(self) -> None:
        self._seen_m: Array | None = None
        self._share = np.ones(3)
        self._yielding: Yielding | None = None

    def advance(self, solvers: Solvers, interval: Interval, now: State) -> State:
        if solvers.particles is None:
            return particles_first(solvers, interval, now)
        yielding = self._yielding = self._yielding or Yielding.of(solvers.panel)
        if not yielding.known.any():
            return particles_first(solvers, interval, now)
        response = cast(Responding, solvers.particles).response(interval.length_s)
        known = ahead(solvers, interval, now)
        trial = tried(solvers, interval, now, known)
        path = known.path(self._foreseen(yielding, response, trial, interval, now))
        load = solvers.particles.advance(interval, path)
        panel = solvers.panel.advance(interval, known.clamps, load)
        self._seen_m = path.end.position_m
        more = Load(load.force_N - now.load.force_N)
        gave_m_per_s = (panel.surface.position_m - trial.position_m) / interval.length_s
        self._share = yielding.share(more, gave_m_per_s, interval.length_s, self._share)
        return ended(solvers, interval, now, panel, load)

    def _foreseen(
        self, yielding: Yielding, response: Response, trial: Motion, interval: Interval, now: State
    ) -> Path:
        """The straight path of the surface."""
        length_s, surface, known = interval.length_s, now.panel.surface, yielding.known[:, None]
        start_m = surface.position_m
        if self._seen_m is not None:
            start_m = np.where(known, self._seen_m, start_m)
        trial_m_per_s = (trial.position_m - start_m) / length_s
        velocity_m_per_s = np.where(known, trial_m_per_s, surface.velocity_m_per_s)
        excess_N = response.push_N - against(response, velocity_m_per_s) - now.load.force_N
        velocity_m_per_s += yielding.to(excess_N, response, length_s, self._share)
        end_m = start_m + length_s * velocity_m_per_s
        return Path(Motion(start_m, velocity_m_per_s), Motion(end_m, velocity_m_per_s), length_s)

    def figures(self) -> dict[str, Any]:
        """An interval is never repeated."""
        return {}

    def save(self) -> Saved:
        seen = {} if self._seen_m is None else {"seen_m": self._seen_m.copy()}
        return save_attributes(self, "_share") | seen

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "_share")
        self._seen_m = np.array(saved["seen_m"]) if "seen_m" in saved else None


def tried(solvers: Solvers, interval: Interval, now: State, known: Ahead) -> Motion:
    """The surface at the interval's end, were the load the last one's; the panel stays as it is."""
    panel = restorable(solvers.panel)
    before = panel.save()
    moved = solvers.panel.advance(interval, known.clamps, now.load)
    panel.restore(before)
    return moved.surface
