"""Gauss-Legendre collocation with six stages for  M x'' + C x' + K x = f(t)  with constant matrices.

The order is 12.  The error per step is about 2e-16 (w h)^13, so that steps with  w h <= 1  agree
with the closed form to rounding; and as collocation at Gauss points preserves quadratic invariants,
momentum and energy close to rounding at every step.  Everything that does not change from step to
step is one matrix product per step.

Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed. 2006, section II.1.3.
"""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array
from orchestrator.ports.linear_frames import LinearMachine

STAGES = 6


class Collocation:
    """The steps of a linear machine under loads at the nodes.

    ``step_s`` is the present length of a step; ``node_s``, ``weight_s`` (stages,) are times from the step's
    start, and weights that sum to the step.
    """

    def __init__(self, machine: LinearMachine) -> None:
        mass, n = machine.mass, len(machine.mass)
        self._rate = np.zeros((2 * n, 2 * n))  # y' = rate y + push f
        self._rate[:n, n:] = np.eye(n)
        self._rate[n:] = -np.linalg.solve(mass, np.hstack([machine.stiffness, machine.damping]))
        self._push = np.vstack([np.zeros((n, n)), np.linalg.inv(mass)])
        self.step_s = 0.0

    def set_step(self, step_s: float) -> None:
        """Make the matrices for steps of this length, unless they are there already."""
        if step_s == self.step_s:
            return
        rate, push, size = self._rate, self._push, len(self._rate)
        node, weight, integral = tableau()
        system = np.eye(STAGES * size) - step_s * np.kron(integral, rate)
        start = np.kron(np.ones((STAGES, 1)), np.eye(size))
        self._inner = np.linalg.solve(system, np.hstack([start, step_s * np.kron(integral, push)]))
        self._outer = step_s * np.kron(weight, rate) @ self._inner
        self._outer[:, :size] += np.eye(size)
        self._outer[:, size:] += step_s * np.kron(weight, push)
        self.node_s, self.weight_s = step_s * node, step_s * weight
        self.step_s = step_s

    def stages(self, x: Array, v: Array, load: Array) -> tuple[Array, Array]:
        """Return x and x' at the nodes, (stages, coordinates) each, under ``load`` (stages, coordinates)
        from x and x' at the step's start."""
        states = (self._inner @ np.concatenate([x, v, load.ravel()])).reshape(STAGES, -1)
        return states[:, : len(x)], states[:, len(x) :]

    def end(self, x: Array, v: Array, load: Array) -> tuple[Array, Array]:
        """Return x and x' at the step's end under the same load."""
        state = self._outer @ np.concatenate([x, v, load.ravel()])
        return state[: len(x)], state[len(x) :]


def tableau() -> tuple[Array, Array, Array]:
    """Return nodes and weights on (0, 1), and a_ij = the integral of basis polynomial j up to node i."""
    from scipy.special import roots_sh_legendre

    node, weight = roots_sh_legendre(STAGES)
    integral = np.array([end * (weight @ _basis(node, end * node)) for end in node])
    return node, weight, integral


def _basis(node: Array, at: Array) -> Array:
    """Return Lagrange's basis polynomials of the nodes (n,), evaluated at ``at`` (m,): (m, n).

    They follow their definition: SciPy's interpolator shuffles its nodes at random, and no two runs would be
    alike.
    """
    others = ~np.eye(len(node), dtype=bool)
    apart = np.where(others, node[:, None] - node, 1.0)
    return np.asarray(np.prod((at[:, None, None] - node) / apart, axis=2, where=others))
