"""Maxwell branches: springs in series with dashpots beside the elastic material.

Branch i has ``g_i`` times the elastic stiffness and the relaxation time ``tau_i``.  Its overstress
obeys  dq/dt + q/tau = g dS/dt  for the elastic stress S of the strain it acts on.  Over a step h
in which the strain changes linearly,  q <- exp(-h/tau) q + g (tau/h)(1 - exp(-h/tau)) dS  is exact.
Source of the update: Kaliske and Rothert, Computational Mechanics 19 (1997) 228-239,
doi:10.1007/s004660050171.
"""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.state import SavedAttributes


def check_branches(branches: tuple[tuple[float, float], ...]) -> tuple[Array, Array]:
    """Return ratios and relaxation times in s, (branches,) each.  Raises ValueError if one is not
    positive."""
    if any(ratio <= 0.0 or time_s <= 0.0 for ratio, time_s in branches):
        raise ValueError(f"Maxwell branches need positive pairs (ratio, s), got {branches}")
    ratio, time_s = np.array(branches, dtype=float).reshape(-1, 2).T.copy()
    return ratio, time_s


class Branches(SavedAttributes):
    """All branches on one field of ``size`` strain components.

    Call ``begin`` with a step's length, then ``end`` with the changes of strain and elastic stress
    in it.  Between the two the overstress is ``share * (elastic stress) + history``.  Strain and
    stress may be any two vectors whose product is an energy.
    """

    STATE = ("_stress", "energy_J", "lost_J")

    def __init__(self, branches: tuple[tuple[float, float], ...], size: int) -> None:
        self.ratio, self.time_s = check_branches(branches)
        self.history = np.zeros(size)
        self.share = 0.0
        self.energy_J = np.zeros(len(branches))
        self.lost_J = 0.0
        self._step_s = 0.0
        self._stress = np.zeros((len(branches), size))  # of each branch, divided by its ratio
        self._change = np.zeros(size)

    def begin(self, step_s: float, elastic_stress: Array) -> None:
        """Set ``share`` and ``history`` for a step that starts at ``elastic_stress`` (size,)."""
        if step_s != self._step_s:
            self._step_s = step_s
            self._decay = np.exp(-step_s / self.time_s)
            self._gain = -np.expm1(-step_s / self.time_s) * self.time_s / step_s
            self.share = float(self.ratio @ self._gain)
        np.dot(self.ratio * self._decay, self._stress, out=self.history)
        np.multiply(elastic_stress, self.share, out=self._change)
        self.history -= self._change

    def end(self, strain_change: Array, stress_change: Array) -> None:
        """Accept a step; both changes have shape (size,).  Books stored and lost energy."""
        cross = self._stress @ strain_change
        square = float(strain_change @ stress_change)
        self._book(cross, square)
        for stress, decay, gain in zip(self._stress, self._decay, self._gain, strict=True):
            stress *= decay
            np.multiply(stress_change, gain, out=self._change)
            stress += self._change

    def _book(self, cross: Array, square: float) -> None:
        """Book the work of each branch on the linear path, less the energy that it stores, as lost."""
        h, tau, a, d = self._step_s, self.time_s, self._gain, self._decay
        work = self.ratio * (tau / h * (1.0 - a) * square + a * cross)
        energy = d**2 * self.energy_J + self.ratio * (a * d * cross + 0.5 * a**2 * square)
        self.lost_J += float((work + self.energy_J - energy).sum())
        self.energy_J = energy
