"""A rod with round ends, twice as long as thick."""

from __future__ import annotations

from orchestrator.ports.clumps import clump

ADAPTER = clump(
    "rod",
    "a rod with round ends, twice as long as thick: three spheres in a row",
    [(0.0, 0.0, -1.0, 1.0), (0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0)],
)
