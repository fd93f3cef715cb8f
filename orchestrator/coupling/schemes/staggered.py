"""Schemes that run each solver once in an interval.

``particles_first`` (the default) advances particles, then panels, then frames.  Every member acts on the
motion of the heavier member above it, which is *known* from a drive or else *extrapolated*, and hands up
its mean load over the *same* interval.  Momentum is exact at every interface.  The energy created in an
elastic contact falls with the third power of the interval between two rigid bodies, and with the second
power on a panel.

``serial_staggered`` is the conventional order (Farhat, C. and Lesoinne, M., Computer Methods in
Applied Mechanics and Engineering 182, 2000, 499-515, doi 10.1016/S0045-7825(99)00206-6): frames, then
panels, then particles, with each load one interval late.  Momentum is exact, but a load that lags
acts like negative damping: the scheme is of first order and adds energy.
"""

from __future__ import annotations

from orchestrator.coupling.schemes.scheme import Solvers, State, finish_interval, forecast, mean_acceleration
from orchestrator.ports import HermitePath, Load, Motion
from orchestrator.ports.clock import Interval


def particles_first(solvers: Solvers, interval: Interval, now: State) -> State:
    """Advance with loads handed up within the interval; motion is known ahead, or extrapolated."""
    known = forecast(solvers, interval, now)
    load = _advance_particles(solvers, interval, known.path(extrapolated_path(now, interval)), now)
    panel = solvers.panel.advance(interval, known.clamps, load)
    return finish_interval(solvers, interval, now, panel, load)


def serial_staggered(solvers: Solvers, interval: Interval, now: State) -> State:
    """Advance with motion handed down within the interval, under the load of the last interval."""
    clamps = solvers.frames.advance(interval, now.panel.reaction)
    panel = solvers.panel.advance(interval, clamps, now.load)
    path = HermitePath(now.panel.surface, panel.surface, interval.length_s)
    load = _advance_particles(solvers, interval, path, now)
    return State(clamps, mean_acceleration(now.clamps, clamps, interval), panel, load)


def extrapolated_path(now: State, interval: Interval) -> HermitePath:
    """Return the surface's path at constant velocity."""
    start, length_s = now.panel.surface, interval.length_s
    end_m = start.position_m + length_s * start.velocity_m_per_s
    return HermitePath(start, Motion.unchecked(end_m, start.velocity_m_per_s), length_s)


def _advance_particles(solvers: Solvers, interval: Interval, path: HermitePath, now: State) -> Load:
    if solvers.particles is None:
        return now.load  # zero from the start
    return solvers.particles.advance(interval, path)
