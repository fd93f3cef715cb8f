"""Schemes that repeat each interval until particles and panel agree on the load.

The particles see the surface move on a chord, the straight path from its present place to the panel's place
at the interval's end, and the panel ends there under their mean load.  This load then does the same work on
both sides, so that no energy is created.  (If a drive carries the surface, its true path is known and
replaces the chord.)  The load F is the unknown, a fixed point of

    F -> load of the particles on the chord which the panel moves along under F,

and the iteration starts from the load of the last interval; ``acceleration.py`` has the methods.  Momentum is
exact after any number of iterations, since the panel finally moves under the load that the particles gave.
"""

from __future__ import annotations

import logging
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.tables.case import Case
from orchestrator.coupling.schemes.scheme import Forecast, Solvers, State, chord, finish_interval, forecast
from orchestrator.ports import Array, Load, PanelState, Restorable, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.state import restore_attributes, save_attributes

LOG = logging.getLogger("flipflow")
_COUNTS = ("_intervals", "_runs", "_longest", "_unsolved", "_worst")


@dataclass(frozen=True)
class Effort:
    """The tolerance of the iteration, and the largest number of runs.

    An interval is solved when the load that the particles give differs from the load that the panel moved
    under by at most ``tolerance`` of its size, or by ``floor_N``; sizes are Euclidean norms over all surface
    points.  An interval is run at most ``most`` times.
    """

    tolerance: float = 1e-3
    floor_N: float = 0.0
    most: int = 20


def case_effort(case: Case) -> Effort:
    """Return the effort that a case asks for; the floor is the tolerance of the lightest particle's
    weight."""
    masses_kg = [each.mass_kg for each in smallest_grains(case).values()]
    weight_N = min(masses_kg, default=0.0) * float(np.linalg.norm(case.gravity_m_per_s2))
    tolerance = case.coupling.tolerance
    return Effort(tolerance, tolerance * weight_N, case.coupling.most_iterations)


class Acceleration(Restorable, Protocol):
    """A method that computes the load for the next try; it begins anew in each interval."""

    def begin(self) -> None: ...

    def next(self, tried_N: Array, answer_N: Array) -> Array:
        """Return the next try, after the particles answered ``tried_N`` with ``answer_N``; any shape."""
        ...


class Iterated:
    """A scheme that iterates on the load in each interval, and counts the runs."""

    def __init__(self, effort: Effort, acceleration: Acceleration) -> None:
        self._effort, self._acceleration = effort, acceleration
        self._intervals = self._runs = self._longest = self._unsolved = 0
        self._worst = 0.0

    def advance(self, solvers: Solvers, interval: Interval, now: State) -> State:
        known = forecast(solvers, interval, now)
        if solvers.particles is None:
            panel, load = solvers.panel.advance(interval, known.clamps, now.load), now.load
        else:
            panel, load = self._solve_interval(solvers, interval, now, known)
        return finish_interval(solvers, interval, now, panel, load)

    def _solve_interval(
        self, solvers: Solvers, interval: Interval, now: State, known: Forecast
    ) -> tuple[PanelState, Load]:
        assert solvers.particles is not None
        particles, panel = solvers.particles, solvers.panel
        particles_before, panel_before = particles.save(), panel.save()
        self._acceleration.begin()
        tried = now.load
        for run in range(1, self._effort.most + 1):
            moved = solvers.panel.advance(interval, known.clamps, tried)
            path = known.path(chord(now.panel.surface, moved.surface, interval.length_s))
            load = solvers.particles.advance(interval, path)
            off_N = norm_N(load.force_N - tried.force_N)
            solved = off_N <= max(self._effort.tolerance * norm_N(load.force_N), self._effort.floor_N)
            solved = solved or known.is_settled  # any other load would have the same answer
            if solved or run == self._effort.most:
                break
            tried = Load(self._acceleration.next(tried.force_N, load.force_N))
            particles.restore(particles_before)
            panel.restore(panel_before)
        self._count(run, solved, off_N, load, interval)
        if off_N > 0:
            panel.restore(panel_before)
            moved = solvers.panel.advance(interval, known.clamps, load)
        return moved, load

    def figures(self) -> dict[str, Any]:
        """Return the entry of ``summary.json``: the numbers of runs and of unsolved intervals."""
        mean = self._runs / self._intervals if self._intervals else 0.0
        return {"mean": mean, "most": self._longest, "unsolved": self._unsolved, "worst": self._worst}

    def save(self) -> Saved:
        return save_attributes(self, *_COUNTS) | {"relaxation": self._acceleration.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_COUNTS)
        self._acceleration.restore(saved["relaxation"])

    def _count(self, runs: int, solved: bool, off_N: float, load: Load, interval: Interval) -> None:
        self._intervals += 1
        self._runs += runs
        self._longest = max(self._longest, runs)
        if solved:
            return
        self._unsolved += 1
        residual = off_N / max(norm_N(load.force_N), off_N)
        self._worst = max(self._worst, residual)
        if self._unsolved == 1:
            LOG.warning(
                "the interval at t = %g s is not solved after %d iterations: the load is off by "
                "%.2g of its size; said once, summary.json counts them",
                interval.start_s,
                runs,
                residual,
            )


def norm_N(force_N: Array) -> float:
    """Return the Euclidean norm of all components."""
    return float(np.linalg.norm(force_N))
