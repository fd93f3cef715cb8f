"""The masses behind surface points, of any panel and of several as one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.sparse import block_diag, csr_array

from orchestrator.ports import Inert, Inertia, Panel


def inertia_of(panel: Panel) -> Inertia:
    """What a panel tells of its masses; unknown if nothing."""
    if isinstance(panel, Inert):
        return panel.inertia()
    return Inertia.unknown(len(panel.initial().surface))


def joined(parts: Sequence[Inertia]) -> Inertia:
    """Points and masses of all, one after the other."""
    return Inertia(
        csr_array(block_diag([part.shapes for part in parts])),
        np.concatenate([part.mass_kg for part in parts]),
        np.concatenate([part.held for part in parts]),
    )
