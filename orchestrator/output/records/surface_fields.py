"""The fields of the surface for ParaView: motion and pressure at points, and stretch of triangles.

They are computed at output times only.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from orchestrator.ports import Array, Indices, Load, Motion
from orchestrator.ports.geometry import area_vectors_m2


class SurfaceFields:
    """The fields of a surface of triangles (m, 3) that is at rest at ``start_m`` (points, 3).

    ``interval_s`` is the time between two sync points.
    """

    def __init__(self, start_m: Array, triangles: Indices, interval_s: float) -> None:
        self._interval_s = interval_s
        self._start_m, self._triangles = start_m.copy(), triangles
        self._metric_m2 = _metric_m2(start_m[triangles])
        # the matrix (points, m) that gives each corner a third of its triangle
        corners, numbers = triangles.ravel(), np.repeat(np.arange(len(triangles)), 3)
        shape = (len(start_m), len(triangles))
        self._thirds = csr_array((np.full(triangles.size, 1 / 3), (corners, numbers)), shape=shape)

    def at_points(self, surface: Motion, before: Motion, load: Load) -> dict[str, Array]:
        """Return the displacement since t = 0 and the acceleration (points, 3), and the pressure of the
        particles' load (points,).

        ``before`` is the surface at the last sync point.  Acceleration and load are means over the interval
        since then.  Its component into the surface at a point counts
        over a third of the area of the triangles around the point; the pressure is positive where particles
        lie on the side of the triangles' normals.
        """
        area_m2 = self._area_vectors_m2(surface.position_m)
        size_m2 = np.linalg.norm(area_m2, axis=1)
        into_N_m2 = -np.einsum("ij,ij->i", load.force_N, area_m2)
        pressure_Pa = np.divide(into_N_m2, size_m2**2, out=np.zeros(len(size_m2)), where=size_m2 > 0)
        gained_m_per_s = surface.velocity_m_per_s - before.velocity_m_per_s
        return {
            "displacement_m": surface.position_m - self._start_m,
            "acceleration_m_per_s2": gained_m_per_s / self._interval_s,
            "load_pressure_Pa": pressure_Pa,
        }

    def stretch_percent(self, surface: Motion) -> Array:
        """Return the largest stretch of each triangle since t = 0 in per cent, (m,).

        The squares of a triangle's two stretches are the eigenvalues of the metric of its edges now against
        that at t = 0; the larger one counts.
        """
        now_m2 = _metric_m2(surface.position_m[self._triangles])
        relative = np.linalg.solve(self._metric_m2, now_m2)
        half_trace = (relative[:, 0, 0] + relative[:, 1, 1]) / 2
        root = np.sqrt(np.maximum(half_trace**2 - np.linalg.det(relative), 0.0))
        return np.asarray(100.0 * (np.sqrt(half_trace + root) - 1.0))

    def _area_vectors_m2(self, position_m: Array) -> Array:
        """Return for each point a third of the summed area vectors of its triangles, (points, 3)."""
        return np.asarray(self._thirds @ area_vectors_m2(position_m[self._triangles]))


def _metric_m2(corners_m: Array) -> Array:
    """Return the products (m, 2, 2) of the two edges of each triangle (m, 3, 3) from its first corner."""
    edges_m = corners_m[:, 1:] - corners_m[:, :1]
    return np.asarray(edges_m @ edges_m.transpose(0, 2, 1))
