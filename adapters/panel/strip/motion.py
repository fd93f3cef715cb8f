"""A chain in motion: explicit velocity Verlet with Maxwell branches, compiled (``kernel/``).

Scheme: Hairer, Lubich, Wanner, Acta Numerica 12, 2003, 399-450, doi 10.1017/S0962492902000144.
The held rows follow their path.  Internal forces act on them by the trapezoidal rule, as they act on the
free rows, so that momentum is exact.  Across, a strip is as stiff as a deep beam, which no useful step
resolves.  In this direction the free rows follow the clamps, linearly along the strip, and the forces on them
go to the clamps at once.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from adapters.panel.common.compiled_body import CompiledBody, kernel
from adapters.panel.strip.chain import Chain
from orchestrator.ports import Array
from orchestrator.ports.plans import PanelPlan


class ChainMotion(CompiledBody):
    """A chain that starts at rest and relaxed at ``position_m`` (r, 3), under the gravity of ``plan``.

    ``internal_N`` (r, 3) is the present force of springs and branches on the rows.  Branches act on spring
    lengths, with the springs' stiffness at rest, and on curvatures; their stresses are kept over their
    ratios.  ``clamp_half_m`` (held, 3) are the half widths of the held rows, from the middle to y = width.
    """

    kernel: kernel.Chain

    def __init__(
        self, chain: Chain, plan: PanelPlan, position_m: Array, clamp_half_m: Array, step_s: float
    ) -> None:
        across, branches = plan.rectangle.across, plan.material.branches
        self._chain, self._across, self.share = chain, across, shares(chain)
        self._springs = len(chain.area_m2)
        strains = self._springs + 3 * len(chain.bending_N_m3)
        memory = {
            "strain": np.zeros(strains),
            "stress": np.zeros((len(branches), strains)),
            "energy_J": np.zeros(len(branches)),
            "clamp_half_m": clamp_half_m.copy(),
            "received_J": np.zeros(2),
        }
        rows = {
            "mass_kg": chain.mass_kg,
            "weight_N": chain.mass_kg[:, None] * plan.gravity_m_per_s2,
            "free": np.flatnonzero(chain.clamp_of_row < 0).astype(np.int32),
            "across": across,
            "share": self.share,
        }
        held = np.flatnonzero(chain.clamp_of_row >= 0)
        resting_N_per_m = chain.rate_N_per_m(chain.spring_directions(position_m)[1])
        constants = _links(chain) | rows | {"branch_N_per_m": resting_N_per_m}
        rows_shape = (len(chain.mass_kg), 3)
        super().__init__(kernel.Chain, step_s, rows_shape, chain.mass_kg, held, branches, constants, memory)
        self.rest(position_m)

    def stretches(self) -> tuple[float, float]:
        """Return the smallest and the largest stretch of the springs."""
        stretch = self.memory["strain"][: self._springs] / self._chain.rest_m
        return float(stretch.min()), float(stretch.max())

    def stored_J(self) -> dict[str, float]:
        return {
            "membrane": self._chain.membrane_J(self.position_m),
            "bending": self._chain.bending_J(self.position_m),
            "maxwell": float(self.memory["energy_J"].sum()),
        }

    def onto_held(self, force_N: Array) -> Array:
        """Return the effect (held, 3) of forces (r, 3) on the held rows, across all of them."""
        held_N, across = force_N[self.held], self._across
        handed_N = self.share.T @ (force_N @ across) - held_N @ across
        return np.asarray(held_N + np.outer(handed_N, across))


def shares(chain: Chain) -> Array:
    """Return the shares (rows, held rows) by which rows follow the held rows.

    They belong to a quantity that varies linearly between the clamps' inner edges and is the held rows' own
    under the clamps.
    """
    held = np.flatnonzero(chain.clamp_of_row >= 0)
    share = (np.arange(len(chain.rows_m))[:, None] == held).astype(float)
    along = np.clip(chain.rows_m / chain.rows_m[chain.springs][-1], 0.0, 1.0)
    free = chain.clamp_of_row < 0
    second = int((chain.clamp_of_row == 0).sum())
    share[free, second - 1], share[free, second] = 1 - along[free], along[free]
    return np.asarray(share)


def _links(chain: Chain) -> dict[str, Any]:
    """Return springs and bending springs; each bending spring joins three rows."""
    bends = np.arange(len(chain.bending_N_m3))
    at_clamp = np.zeros(len(bends), dtype=np.int32)
    at_clamp[chain.at_clamps] = 1
    along = np.zeros((len(bends), 3))
    along[chain.at_clamps] = chain.clamp_along
    return {
        "first": chain.springs.start,
        "rest_m": chain.rest_m,
        "c10_Pa": chain.law.c10_Pa,
        "c01_Pa": chain.law.c01_Pa,
        "sheared_Pa": chain.law.sheared_Pa,
        "area_m2": chain.area_m2,
        "bending_N_m3": chain.bending_N_m3,
        "curvature_1_m2": chain.curvature_1_m2[bends[:, None], bends[:, None] + np.arange(3)],
        "at_clamp": at_clamp,
        "along": along,
        "gap_m": chain.gap_m,
        "moulded_N_m": chain.moulded_N_m,
    }
