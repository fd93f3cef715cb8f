"""A flat grain: a plate with a round edge."""

from __future__ import annotations

import math

from orchestrator.ports.clumps import clump

SIXTHS = [k * math.pi / 3 for k in range(6)]

ADAPTER = clump(
    "flake",
    "a plate with a round edge, three times as wide as thick: six spheres about a seventh",
    [(0.0, 0.0, 0.0, 1.0), *((2 * math.cos(angle), 2 * math.sin(angle), 0.0, 1.0) for angle in SIXTHS)],
)
