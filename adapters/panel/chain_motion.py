"""A chain in motion: explicit velocity Verlet, with Maxwell branches for damping.

Scheme: Hairer, Lubich, Wanner, Acta Numerica 12, 2003, 399-450, doi 10.1017/S0962492902000144.
The held rows follow their path; internal forces act on them with the trapezoidal rule, as they
do on the free ones, so that momentum is exact.  Across, a strip is stiff like a deep beam, which
no useful step resolves: there the free rows follow the clamps, linearly along the strip, and
what pushes them across goes to the clamps at once.
"""

from __future__ import annotations

import numpy as np

from adapters.panel.chain import Chain
from adapters.panel.maxwell import Branches
from orchestrator.hermite import Path
from orchestrator.ports import Array, Saved
from orchestrator.state import put_back, taken

_STATE = ("position_m", "velocity_m_s", "internal_N", "_strain")


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
        across: Array,
    ) -> None:
        self._chain, self._mass_kg, self._across = chain, mass_kg[:, None], across
        self._share = shares(chain)
        self.held = np.flatnonzero(chain.held >= 0)
        self._free = slice(chain.springs.start + 1, chain.springs.stop - 1)
        self.position_m = position_m
        self.velocity_m_s = np.zeros_like(position_m)
        springs, bends = chain.springs.stop - chain.springs.start - 1, len(chain.bending_N_m3)
        axial_N_m = chain.material.youngs_modulus_Pa * chain.area_m2 / chain.rest_m
        self._stiffness = np.concatenate([axial_N_m, np.repeat(chain.bending_N_m3, 3)])
        self._springs = springs
        self._branches = Branches(branches, springs + 3 * bends)
        self._strain = self._new_strain = self._elastic()[1]
        self.internal_N = self._internal()

    def run(self, path: Path, outside_N: Array, steps: int) -> tuple[Array, float]:
        """Move over ``path`` (of the held rows) under ``outside_N`` (r, 3), constant.

        Returns the impulse (held, 3) that the chain gives to the clamps, and its work on them.
        """
        step_s, free = path.length_s / steps, self._free
        start_m_s, impulse_N_s, work_J = self.velocity_m_s, np.zeros_like(outside_N), 0.0
        rate = step_s / 2 / self._mass_kg[free]
        velocity_m_s = self._planar(start_m_s[free])
        for step in range(1, steps + 1):
            before_m, before_N = self.position_m, self.internal_N
            half_m_s = velocity_m_s + rate * (before_N + outside_N)[free]
            self.position_m = self._next(path.position_m(step / steps), half_m_s, step_s)
            self._branches.begin(step_s, self._stiffness * self._strain)
            self.internal_N = self._internal()
            self._end_step()
            velocity_m_s = self._planar(half_m_s + rate * (self.internal_N + outside_N)[free])
            mean_N = (before_N + self.internal_N) / 2
            impulse_N_s += step_s * mean_N
            work_J += self._work_J(mean_N + outside_N, self.position_m - before_m)
        self.velocity_m_s = self._spread(path.end.velocity_m_s)
        self.velocity_m_s[free] += velocity_m_s
        impulse_N_s += path.length_s * outside_N
        impulse_N_s -= self._mass_kg * (self.velocity_m_s - start_m_s)
        work_J -= self._gain_J(start_m_s)
        return self.onto_held(impulse_N_s), work_J

    def save(self) -> Saved:
        return taken(self, *_STATE) | {"branches": self._branches.save()}

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_STATE)
        self._branches.restore(saved["branches"])

    def stretches(self) -> tuple[float, float]:
        """The smallest and the largest of the springs."""
        stretch = self._strain[: self._springs] / self._chain.rest_m
        return float(stretch.min()), float(stretch.max())

    def stored_J(self) -> dict[str, float]:
        """Elastic energy, and that of the branches' springs."""
        curvature_1_m = self._chain.curvature_1_m(self.position_m)
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
        curvature_1_m = self._chain.curvature_1_m(self.position_m)
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

    def _next(self, held_m: Array, half_m_s: Array, step_s: float) -> Array:
        """Positions (r, 3) a step on: held rows as given, free ones in the plane by Verlet."""
        position_m = self.position_m + self._spread(held_m - self.position_m[self.held])
        position_m[self._free] += step_s * self._planar(half_m_s)
        return position_m

    def _spread(self, held: Array) -> Array:
        """Motion (r, 3) that the held rows' (held, 3) imposes: all of it there, and what is
        across on the free rows."""
        moved = np.outer(self._share @ (held @ self._across), self._across)
        moved[self.held] = held
        return moved

    def onto_held(self, force: Array) -> Array:
        """(held, 3): the transpose of ``_spread``."""
        held = np.outer(self._share.T @ (force @ self._across), self._across)
        return np.asarray(held + self._planar(force[self.held]))

    def _planar(self, vector: Array) -> Array:
        return np.asarray(vector - np.outer(vector @ self._across, self._across))

    def _work_J(self, force_N: Array, moved_m: Array) -> float:
        """Work on imposed motion: of held rows in the plane, of all rows across."""
        work_J = np.sum(self._planar(force_N[self.held]) * moved_m[self.held])
        return float(work_J + (force_N @ self._across) @ (moved_m @ self._across))

    def _gain_J(self, start_m_s: Array) -> float:
        """Kinetic energy gained in imposed motion."""
        before, after = (self._imposed_J(v) for v in (start_m_s, self.velocity_m_s))
        return after - before

    def _imposed_J(self, velocity_m_s: Array) -> float:
        return self._work_J(self._mass_kg * velocity_m_s, velocity_m_s) / 2


def shares(chain: Chain) -> Array:
    """(rows, held rows): a quantity that varies linearly between the clamps' inner edges and is
    the held rows' own under the clamps."""
    held = np.flatnonzero(chain.held >= 0)
    share = (np.arange(len(chain.rows_m))[:, None] == held).astype(float)
    along = np.clip(chain.rows_m / chain.rows_m[chain.springs][-1], 0.0, 1.0)
    free = chain.held < 0
    second = int((chain.held == 0).sum())
    share[free, second - 1], share[free, second] = 1 - along[free], along[free]
    return np.asarray(share)
