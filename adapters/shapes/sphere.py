"""Spheres."""

from __future__ import annotations

import math

from orchestrator.ports.grains import Shape

ADAPTER = Shape(
    name="sphere",
    about="a sphere",
    spheres=((0.0, 0.0, 0.0, 0.5),),
    volume=math.pi / 6,
    inertia=(math.pi / 60,) * 3,
)
