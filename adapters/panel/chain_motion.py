"""A chain in motion: explicit velocity Verlet, with Maxwell branches for damping.

Scheme: Hairer, Lubich, Wanner, Acta Numerica 12, 2003, 399-450, doi 10.1017/S0962492902000144.
The held rows follow their path; internal forces act on them with the trapezoidal rule, as they
do on the free ones, so that momentum is exact.
"""

from __future__ import annotations

import numpy as np

from adapters.panel.chain import Chain
from adapters.panel.maxwell import Branches
from orchestrator.hermite import Path
from orchestrator.ports import Array


class ChainMotion:
    """Starts at rest and relaxed at ``position_m`` (r, 3); ``mass_kg`` (r,).

    ``internal_N`` (r, 3) is the force of springs and branches on the rows, now.  Branches act on
    spring lengths, with the springs' stiffness at no stretch, and on curvatures."""

    def __init__(
        self,
        chain: Chain,
        mass_kg: Array,
        position_m: Array,
        branches: tuple[tuple[float, float], ...],
    ) -> None:
        self._chain, self._mass_kg = chain, mass_kg[:, None]
        self.held = np.flatnonzero(chain.held >= 0)
        self._free = slice(chain.springs.start + 1, chain.springs.stop - 1)
        self.position_m = position_m
        self.velocity_m_s = np.zeros_like(position_m)
        springs, bends = chain.springs.stop - chain.springs.start - 1, len(chain.bending_N_m3)
        axial_N_m = chain.material.youngs_modulus_Pa * chain.area_m2 / chain.rest_m
        self._stiffness = np.concatenate(
            [np.full(springs, axial_N_m), np.repeat(chain.bending_N_m3, 3)]
        )
        self._springs = springs
        self._branches = Branches(branches, springs + 3 * bends)
        self._strain = self._new_strain = self._elastic()[1]
        self.internal_N = self._internal()

    def run(self, path: Path, outside_N: Array, steps: int) -> tuple[Array, float]:
        """Move over ``path`` (of the held rows) under ``outside_N`` (r, 3), constant.

        Returns the impulse (held, 3) of the internal forces on the held rows, and their work
        on them.
        """
        step_s, free, held = path.length_s / steps, self._free, self.held
        impulse_N_s, work_J = np.zeros((len(held), 3)), 0.0
        rate = step_s / 2 / self._mass_kg[free]
        outside_N = outside_N[free]
        for step in range(1, steps + 1):
            before_N, before_m = self.internal_N, self.position_m
            half_m_s = self.velocity_m_s[free] + rate * (before_N[free] + outside_N)
            self.position_m = before_m.copy()
            self.position_m[free] += step_s * half_m_s
            self.position_m[held] = path.position_m(step / steps)
            self._branches.begin(step_s, self._stiffness * self._strain)
            self.internal_N = self._internal()
            self._end_step()
            self.velocity_m_s[free] = half_m_s + rate * (self.internal_N[free] + outside_N)
            on_held_N = (before_N[held] + self.internal_N[held]) / 2
            impulse_N_s += step_s * on_held_N
            work_J += float(np.sum(on_held_N * (self.position_m[held] - before_m[held])))
        self.velocity_m_s[held] = path.end.velocity_m_s
        return impulse_N_s, work_J

    def stored_J(self) -> dict[str, float]:
        """Elastic energy, and that of the branches' springs."""
        curvature_1_m = self._chain.curvature_1_m2 @ self.position_m
        return {
            "membrane": self._chain.membrane_J(self._chain.stretched(self.position_m)[1]),
            "bending": self._chain.bending_J(curvature_1_m),
            "maxwell": float(self._branches.energy_J.sum()),
        }

    def lost_J(self) -> float:
        return self._branches.lost_J

    def _elastic(self) -> tuple[Array, Array]:
        """Directions of the springs (c, 3); their lengths and all curvatures in one vector."""
        along, length_m = self._chain.stretched(self.position_m)
        curvature_1_m = self._chain.curvature_1_m2 @ self.position_m
        return along, np.concatenate([length_m, curvature_1_m.ravel()])

    def _internal(self) -> Array:
        along, self._new_strain = self._elastic()
        springs, strain = self._springs, self._new_strain
        linear = self._stiffness * strain
        over = self._branches.share * linear + self._branches.history
        tension_N = self._chain.tension_N(strain[:springs]) + over[:springs]
        moment = (linear[springs:] + over[springs:]).reshape(-1, 3)
        return self._chain.force_N(along, tension_N, moment)

    def _end_step(self) -> None:
        change = self._new_strain - self._strain
        self._branches.end(change, self._stiffness * change)
        self._strain = self._new_strain
