"""The geometry that panel solvers, frames and the particles' surface share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.ports import Array, Indices


@dataclass(frozen=True)
class Rectangle:
    """A flat rectangular panel and where it is mounted.

    Material coordinates (s, y) in m: s runs along the free length, 0 at the inner edge of the
    first clamp and ``length_m`` at the inner edge of the second, and goes ``clamp_m`` further
    under each clamp; y runs across, 0 ... ``width_m``.

    ``corner_m`` is the world position of (s, y) = (0, 0); ``along`` and ``across`` are unit
    vectors; ``along x across`` is the normal that points up, to the bed.  ``length_m`` is the
    stress-free length; the clamps' inner edges are mounted ``span_m`` apart: longer is
    stretched, shorter is slack.
    """

    corner_m: Array
    along: Array
    across: Array
    length_m: float
    span_m: float
    width_m: float
    clamp_m: float

    @property
    def normal(self) -> Array:
        return np.cross(self.along, self.across)

    def mounted(self, coordinates_m: Array) -> Array:
        """World positions (n, 3) of material coordinates (n, 2) with the panel straight between
        its clamps (a slack panel is compressed to ``span_m`` here; solvers find its sag)."""
        s, y = coordinates_m[:, 0], coordinates_m[:, 1]
        free = np.clip(s, 0.0, self.length_m)
        x = free * (self.span_m / self.length_m) + (s - free)
        return np.asarray(self.corner_m + np.outer(x, self.along) + np.outer(y, self.across))

    def end(self, coordinates_m: Array) -> Array:
        """0 for points under the first clamp, 1 under the second, NaN for free points.

        The inner edges themselves belong to the clamps.
        """
        s = coordinates_m[:, 0]
        slack = 1e-9 * self.length_m
        return np.where(s <= slack, 0.0, np.where(s >= self.length_m - slack, 1.0, np.nan))


@dataclass(frozen=True)
class TriangleSurface:
    """What particles touch: ``position_m`` (n, 3) at t = 0, ``triangles`` (m, 3) of point
    numbers, ``material`` (m,) the index of each triangle's material.  Triangles are two-sided.
    Points that no triangle uses (probes) are allowed."""

    position_m: Array
    triangles: Indices
    material: Indices
