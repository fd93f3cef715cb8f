"""The shape in which a chain hangs at rest between its clamps: the least potential energy."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from adapters.panel.strip.chain import Chain
from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle
from orchestrator.ports.plans import SolverFailed

NEWTON_ITERATIONS = 20
NEGLIGIBLE_MOVE = 1e-10  # of the length; rounding leaves 1e-11 in thin slack strips


@dataclass(frozen=True)
class Potential:
    """Energy of a chain under ``weight_N`` (r, 3) over the unknowns: displacements of the free
    rows in the plane, from ``start_m`` (r, 3).  ``columns`` (unknowns, 3 r) maps them there."""

    chain: Chain
    start_m: Array
    weight_N: Array
    columns: Array

    def placed(self, unknown_m: Array) -> Array:
        return np.asarray(self.start_m + (unknown_m @ self.columns).reshape(-1, 3))

    def energy_J(self, unknown_m: Array) -> float:
        position_m = self.placed(unknown_m)
        stored_J = self.chain.membrane_J(self.chain.stretched(position_m)[1])
        stored_J += self.chain.bending_J(self.chain.curvature_1_m(position_m))
        return stored_J - float(np.sum(self.weight_N * (position_m - self.start_m)))

    def gradient_N(self, unknown_m: Array) -> Array:
        force_N = elastic_N(self.chain, self.placed(unknown_m)) + self.weight_N
        return np.asarray(-self.columns @ force_N.ravel())

    def tangent_N_per_m(self, unknown_m: Array) -> Array:
        tangent = self.chain.tangent_N_per_m(self.placed(unknown_m))
        return np.asarray(self.columns @ tangent @ self.columns.T)


def settled(chain: Chain, start_m: Array, weight_N: Array, rectangle: Rectangle, name: str) -> Array:
    """Return positions (r, 3) in balance with ``weight_N`` (r, 3); held rows, and all rows across, stay as in
    ``start_m``.

    A trust-region Newton method finds the valley (the straight slack chain is no minimum),
    plain Newton iterations the bottom.  SolverFailed if there is none.
    """
    plane = np.stack([rectangle.along, rectangle.normal])
    columns = np.kron(np.eye(len(start_m))[chain.held < 0], plane)
    potential = Potential(chain, start_m, weight_N, columns)
    unknown_m = minimize(
        potential.energy_J,
        np.zeros(len(columns)),
        method="trust-exact",
        jac=potential.gradient_N,
        hess=potential.tangent_N_per_m,
        options={"gtol": 1e-6 * (np.abs(weight_N).sum() + 1e-3), "initial_trust_radius": 1e-3},
    ).x
    for _ in range(NEWTON_ITERATIONS):
        move_m = np.linalg.solve(potential.tangent_N_per_m(unknown_m), potential.gradient_N(unknown_m))
        unknown_m = unknown_m - move_m
        if np.abs(move_m).max() < NEGLIGIBLE_MOVE * rectangle.length_m:
            return potential.placed(unknown_m)
    raise SolverFailed(f"panel {name}, t = 0: no resting shape; still moving by {np.abs(move_m).max():.1e} m")


def elastic_N(chain: Chain, position_m: Array) -> Array:
    """Return the elastic force (r, 3) on the rows."""
    along, length_m = chain.stretched(position_m)
    moment = chain.bending_N_m3[:, None] * chain.curvature_1_m(position_m)
    return chain.force_N(along, chain.tension_N(length_m), moment)


def first_guess_m(chain: Chain, rectangle: Rectangle, gravity_m_per_s2: Array) -> Array:
    """Return positions (r, 3): straight if taut; a slack chain is a cosine wave of the right length to second
    order, bulging with gravity or, without it, downwards."""
    middle = np.full_like(chain.rows_m, rectangle.width_m / 2)
    position_m = rectangle.mounted(np.column_stack([chain.rows_m, middle]))
    slack_m = max(rectangle.length_m - rectangle.span_m, 0.0)
    height_m = 2 / np.pi * np.sqrt(slack_m * rectangle.length_m)
    wave = (1 - np.cos(2 * np.pi * chain.rows_m / rectangle.length_m)) / 2
    side = 1.0 if gravity_m_per_s2 @ rectangle.normal > 0 else -1.0
    bulge_m = np.where(chain.held < 0, side * height_m * wave, 0.0)
    return np.asarray(position_m + np.outer(bulge_m, rectangle.normal))
