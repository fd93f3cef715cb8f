"""Two equal spheres that touch, as one rigid grain: the toy among the shapes.

On end it passes a square opening as wide as one of its spheres, whose diameter so is the sieve size 1.
"""

from __future__ import annotations

import math

from orchestrator.ports.grains import Shape

SPHERE = math.pi / 6  # the volume of each
ALONG = 2 * SPHERE / 10  # 2/5 m r^2 of each
ACROSS = ALONG + 2 * SPHERE / 4  # and m a^2, half a diameter from the middle

ADAPTER = Shape(
    name="dumbbell",
    about="two equal spheres that touch",
    spheres=((0.0, 0.0, -0.5, 0.5), (0.0, 0.0, 0.5, 0.5)),
    volume=2 * SPHERE,
    inertia=(ACROSS, ACROSS, ALONG),
)
