"""The shape in which a chain hangs at rest between its clamps: the least potential energy."""

from __future__ import annotations

import pickle
from functools import lru_cache

import numpy as np
from scipy.optimize import minimize

from adapters.panel.common.moulding import side_of_sag
from adapters.panel.strip.chain import Chain
from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle
from orchestrator.ports.plans import PanelPlan, SolverFailed

NEWTON_ITERATIONS = 20
# In balance to this share of the weight.  Below it, steps lower the energy by less than its rounding, and
# a trust region shrinks to nothing.
NEARLY_BALANCED = 1e-3
REMEMBERED = 256  # shapes
NEGLIGIBLE_MOVE = 1e-10  # of the length; rounding leaves 1e-11 in thin slack strips


def settle(chain: Chain, plan: PanelPlan) -> Array:
    """Return positions (r, 3) in balance with the rows' weight; held rows, and all rows across, stay as
    mounted.

    A trust-region Newton method finds the valley (the straight slack chain is no minimum), plain Newton
    iterations the bottom.  Shapes are remembered, since many trials open the same panel.  Raises SolverFailed
    if there is none.
    """
    return _settled(pickle.dumps((chain, plan))).copy()


@lru_cache(REMEMBERED)
def _settled(pickled: bytes) -> Array:
    chain: Chain
    plan: PanelPlan
    chain, plan = pickle.loads(pickled)
    rectangle = plan.rectangle
    start_m = first_guess_m(chain, rectangle, side_of_sag(plan))
    weight_N = np.outer(chain.mass_kg, plan.gravity_m_per_s2)
    # the unknowns are displacements of the free rows in the plane
    plane = np.stack([rectangle.along, rectangle.normal])
    columns = np.kron(np.eye(len(start_m))[chain.clamp_of_row < 0], plane)

    def position_m(unknown_m: Array) -> Array:
        return np.asarray(start_m + (unknown_m @ columns).reshape(-1, 3))

    def energy_J(unknown_m: Array) -> float:
        at_m = position_m(unknown_m)
        return chain.membrane_J(at_m) + chain.bending_J(at_m) - float(np.sum(weight_N * (at_m - start_m)))

    def gradient_N(unknown_m: Array) -> Array:
        return np.asarray(-columns @ (chain.elastic_N(position_m(unknown_m)) + weight_N).ravel())

    def tangent_N_per_m(unknown_m: Array) -> Array:
        return np.asarray(columns @ chain.tangent_N_per_m(position_m(unknown_m)) @ columns.T)

    unknown_m = minimize(
        energy_J,
        np.zeros(len(columns)),
        method="trust-exact",
        jac=gradient_N,
        hess=tangent_N_per_m,
        options={"gtol": NEARLY_BALANCED * (np.abs(weight_N).sum() + 1e-3), "initial_trust_radius": 1e-3},
    ).x
    for _ in range(NEWTON_ITERATIONS):
        move_m = np.linalg.solve(tangent_N_per_m(unknown_m), gradient_N(unknown_m))
        unknown_m = unknown_m - move_m
        if np.abs(move_m).max() < NEGLIGIBLE_MOVE * rectangle.length_m:
            return position_m(unknown_m)
    raise SolverFailed(
        f"panel {plan.name}, t = 0: no resting shape; still moving by {np.abs(move_m).max():.1e} m"
    )


def first_guess_m(chain: Chain, rectangle: Rectangle, side: float) -> Array:
    """Return a first guess of positions (r, 3).

    A taut chain is straight; a slack chain is a cosine wave of the right length to second order, bulging up
    or down as ``side`` is 1 or -1.
    """
    middle = np.full_like(chain.rows_m, rectangle.width_m / 2)
    position_m = rectangle.mounted(np.column_stack([chain.rows_m, middle]))
    slack_m = max(rectangle.length_m - rectangle.span_m, 0.0)
    height_m = 2 / np.pi * np.sqrt(slack_m * rectangle.length_m)
    wave = (1 - np.cos(2 * np.pi * chain.rows_m / rectangle.length_m)) / 2
    bulge_m = np.where(chain.clamp_of_row < 0, side * height_m * wave, 0.0)
    return np.asarray(position_m + np.outer(bulge_m, rectangle.normal))
