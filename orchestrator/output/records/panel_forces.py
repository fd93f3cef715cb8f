"""The forces of every panel over one sync interval: from the bed, and on its clamps and beams."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import csr_array

from orchestrator.coupling.machine import Machine
from orchestrator.coupling.schemes.exchange import State
from orchestrator.ports import Array, Indices

FORCES = ("load_N", "reaction_N", "first_clamp_N", "second_clamp_N", "stops_N")


class PanelForces:
    """Sums over the points of a panel, its clamps and its stops."""

    def __init__(self, machine: Machine, start: State) -> None:
        self._panels = len(machine.panels)
        kinds = ("clamps", "first_clamp", "second_clamp", "stops")
        held = [getattr(panel, kind) for kind in kinds for panel in machine.panels]
        self._loads = _sums([panel.surface for panel in machine.panels], len(start.load))
        self._reactions = _sums(held, len(start.panel.reaction))

    def at(self, state: State) -> Array:
        """(5, panels, 3), in the order of FORCES: means over the interval that ends here."""
        load_N, reaction_N = state.load.force_N, state.panel.reaction.force_N
        sums_N = np.vstack([self._loads @ load_N, self._reactions @ reaction_N])
        return np.asarray(sums_N.reshape(len(FORCES), self._panels, 3))


def _sums(parts: Sequence[slice | Indices], points: int) -> csr_array:
    """(parts, points): sums over the points of each part, all in one product."""
    numbers = [np.arange(points)[part] for part in parts]
    starts = np.cumsum([0, *map(len, numbers)])
    inside = np.concatenate([np.empty(0, dtype=np.int64), *numbers])
    return csr_array((np.ones(len(inside)), inside, starts), shape=(len(parts), points))
