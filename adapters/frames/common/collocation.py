"""Gauss-Legendre collocation for  M x'' + C x' + K x = f(t)  with constant matrices.

Everything that does not change from step to step is one matrix product per step.
Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed. 2006, section II.1.3.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import roots_sh_legendre

from orchestrator.ports import Array

STAGES = 6


@dataclass(frozen=True)
class Gauss:
    """One step.  ``node_s``, ``weight_s`` (stages,): times from the step's start, and weights
    that sum to the step; ``integral_s`` (stages, stages): rates at the nodes to what they add up
    to there.  ``inner`` maps (state, loads) to all stage states, ``outer`` to the
    state at the end; a state is (x, x') in one vector."""

    node_s: Array
    weight_s: Array
    integral_s: Array
    inner: Array
    outer: Array

    def stages(self, x: Array, v: Array, load: Array) -> tuple[Array, Array]:
        """x and x' at the nodes, (stages, coordinates) each, for loads (stages, coordinates)."""
        states = (self.inner @ np.concatenate([x, v, load.ravel()])).reshape(len(self.node_s), -1)
        return states[:, : len(x)], states[:, len(x) :]

    def end(self, x: Array, v: Array, load: Array) -> tuple[Array, Array]:
        state = self.outer @ np.concatenate([x, v, load.ravel()])
        return state[: len(x)], state[len(x) :]


def gauss(mass: Array, damping: Array, stiffness: Array, step_s: float) -> Gauss:
    """All matrices (coordinates, coordinates); ``mass`` regular."""
    n = len(mass)
    rate = np.zeros((2 * n, 2 * n))  # y' = rate y + push f
    rate[:n, n:] = np.eye(n)
    rate[n:] = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    push = np.vstack([np.zeros((n, n)), np.linalg.inv(mass)])
    node, weight, integral = _tableau()
    system = np.eye(STAGES * 2 * n) - step_s * np.kron(integral, rate)
    start = np.kron(np.ones((STAGES, 1)), np.eye(2 * n))
    inner = np.linalg.solve(system, np.hstack([start, step_s * np.kron(integral, push)]))
    outer = step_s * np.kron(weight, rate) @ inner
    outer[:, : 2 * n] += np.eye(2 * n)
    outer[:, 2 * n :] += step_s * np.kron(weight, push)
    return Gauss(step_s * node, step_s * weight, step_s * integral, inner, outer)


def onward() -> Array:
    """(stages, stages): from values at the nodes of a step to values at those of the next, by the
    parabola that fits best."""
    node, _, _ = _tableau()
    fitted = np.linalg.pinv(np.vander(node, 3))
    return np.asarray(np.vander(node + 1, 3) @ fitted)


def _tableau() -> tuple[Array, Array, Array]:
    """Nodes and weights on (0, 1), and a_ij = the integral of basis polynomial j up to node i."""
    node, weight = roots_sh_legendre(STAGES)
    integral = np.array([end * (weight @ _basis(node, end * node)) for end in node])
    return node, weight, integral


def _basis(node: Array, at: Array) -> Array:
    """Lagrange's basis polynomials of the nodes (n,) at ``at`` (m,), (m, n).  By their definition:
    SciPy's interpolator shuffles its nodes at random, and no two runs would be alike."""
    others = ~np.eye(len(node), dtype=bool)
    apart = np.where(others, node[:, None] - node, 1.0)
    return np.asarray(np.prod((at[:, None, None] - node) / apart, axis=2, where=others))
