"""A chain in motion: explicit velocity Verlet with Maxwell branches, compiled (``kernel/``).

Scheme: Hairer, Lubich, Wanner, Acta Numerica 12, 2003, 399-450, doi 10.1017/S0962492902000144.
The held rows follow their path; internal forces act on them with the trapezoidal rule, as they
do on the free ones, so that momentum is exact.  Across, a strip is stiff like a deep beam, which
no useful step resolves: there the free rows follow the clamps, linearly along the strip, and
what pushes them across goes to the clamps at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from adapters.panel._kernel import Chain as CompiledChain
from adapters.panel.common.maxwell import checked
from adapters.panel.strip.chain import Chain
from orchestrator.ports import Array, Saved
from orchestrator.ports.hermite import Path
from orchestrator.ports.state import taken

_STATE = ("position_m", "velocity_m_per_s", "internal_N", "_strain", "_stress", "_energy_J", "_lost_J")


class ChainMotion:
    """Starts at rest and relaxed at ``position_m`` (r, 3); ``mass_kg`` (r,).

    ``internal_N`` (r, 3) is the force of springs and branches on the rows, now.  Branches act on
    spring lengths, with the springs' stiffness at no stretch, and on curvatures; their stresses
    are kept over their ratios.  The compiled code works on these very arrays."""

    def __init__(
        self,
        chain: Chain,
        mass_kg: Array,
        position_m: Array,
        branches: tuple[tuple[float, float], ...],
        across: Array,
    ) -> None:
        self._chain = chain
        self.held = np.flatnonzero(chain.held >= 0)
        self._share, self._across = shares(chain), across
        self._springs = len(chain.area_m2)
        strains = self._springs + 3 * len(chain.bending_N_m3)
        self.position_m = position_m.copy()
        self.velocity_m_per_s, self.internal_N = np.zeros((2, *position_m.shape))
        self._strain, self._stress = np.zeros(strains), np.zeros((len(branches), strains))
        self._energy_J, self._lost_J = np.zeros(len(branches)), np.zeros(1)
        ratio, time_s = checked(branches)
        self._kernel = CompiledChain(
            **_links(chain),
            mass_kg=mass_kg,
            held=self.held.astype(np.int32),
            free=np.flatnonzero(chain.held < 0).astype(np.int32),
            across=across,
            share=self._share,
            ratio=ratio,
            time_s=time_s,
            state=[getattr(self, name) for name in _STATE],
        )
        self._kernel.rest()

    def run(self, path: Path, outside_N: Array, steps: int) -> tuple[Array, float]:
        """Move over ``path`` (of the held rows) under ``outside_N`` (r, 3), constant.

        Returns the impulse (held, 3) that the chain gives to the clamps, and its work on them.
        """
        impulse_N_s = np.zeros((len(self.held), 3))
        work_J = self._kernel.advance(
            path.start.position_m,
            path.start.velocity_m_per_s,
            path.end.position_m,
            path.end.velocity_m_per_s,
            outside_N,
            path.length_s,
            steps,
            impulse_N_s,
        )
        return impulse_N_s, work_J

    def save(self) -> Saved:
        return taken(self, *_STATE)

    def restore(self, saved: Saved) -> None:
        for name in _STATE:
            getattr(self, name)[:] = saved[name.lstrip("_")]

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
            "maxwell": float(self._energy_J.sum()),
        }

    def lost_J(self) -> float:
        """What the branches dissipated since the start."""
        return float(self._lost_J[0])

    def onto_held(self, force: Array) -> Array:
        """(held, 3): how forces (r, 3) act on the held rows, across all of them."""
        held, across = force[self.held], self._across
        handed = self._share.T @ (force @ across) - held @ across
        return np.asarray(held + np.outer(handed, across))


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


def _links(chain: Chain) -> dict[str, Any]:
    """Springs and bending springs; each of the latter joins three rows."""
    bends = np.arange(len(chain.bending_N_m3))
    at_clamp = np.zeros(len(bends), dtype=np.int32)
    at_clamp[chain.at_clamps] = 1
    return {
        "first": chain.springs.start,
        "rest_m": chain.rest_m,
        "c10_Pa": chain.material.c10_Pa,
        "c01_Pa": chain.material.c01_Pa,
        "area_m2": chain.area_m2,
        "bending_N_m3": chain.bending_N_m3,
        "curvature_1_m2": chain.curvature_1_m2[bends[:, None], bends[:, None] + np.arange(3)],
        "at_clamp": at_clamp,
        "along": chain.clamp_along,
    }
