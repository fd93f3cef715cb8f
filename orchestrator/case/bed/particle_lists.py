"""Lists of particles to create: none, and several as one."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.ports.plans import ParticleList


def nobody() -> ParticleList:
    places, nothing = np.empty((0, 3)), np.empty(0)
    return ParticleList(places, places, places, nothing, nothing, nothing.astype(np.int64))


def joined(lists: Sequence[ParticleList]) -> ParticleList:
    """One list of at least one list, in order."""
    return ParticleList(
        np.concatenate([one.position_m for one in lists]),
        np.concatenate([one.velocity_m_per_s for one in lists]),
        np.concatenate([one.spin_rad_per_s for one in lists]),
        np.concatenate([one.diameter_m for one in lists]),
        np.concatenate([one.density_kg_per_m3 for one in lists]),
        np.concatenate([one.material for one in lists]),
    )
