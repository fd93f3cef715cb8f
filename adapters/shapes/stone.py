"""A bulky stone without symmetry, such as crushing leaves behind."""

from __future__ import annotations

from orchestrator.ports.clumps import clump

ADAPTER = clump(
    "stone",
    "a bulky stone without symmetry: four spheres at the corners of an uneven tetrahedron",
    [(0.9, 0.0, -0.4, 0.9), (-0.6, 0.8, -0.4, 0.8), (-0.6, -0.8, -0.3, 0.9), (0.0, 0.1, 0.8, 0.7)],
)
