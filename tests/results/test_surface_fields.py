"""Fields of the surface for ParaView against closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.records.surface_fields import SurfaceFields
from orchestrator.ports import Array, Load, Motion

# a square of 0.2 m x 0.1 m of two triangles, whose normals point up, and a point that belongs to none
FLAT = np.array([[0, 0, 0], [0.2, 0, 0], [0.2, 0.1, 0], [0, 0.1, 0], [9, 9, 9]], dtype=float)
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def moved(position_m: Array) -> Motion:
    return Motion(position_m, np.zeros_like(position_m))


def test_a_uniform_load_is_a_uniform_pressure_on_a_tilted_surface() -> None:
    """Each point bears the pressure on a third of its triangles' area, along the normal."""
    tilt = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    position_m = FLAT @ tilt
    share_m2 = 0.01 / 3 * np.array([2, 1, 2, 1, 0])
    force_N = -np.outer(500 * share_m2, np.array([0, 0, 1]) @ tilt)
    fields = SurfaceFields(FLAT, TRIANGLES, 1e-3).at_points(
        moved(position_m), Motion(FLAT, np.full_like(FLAT, 0.5)), Load(force_N)
    )
    np.testing.assert_allclose(fields["load_pressure_Pa"], [500, 500, 500, 500, 0])
    np.testing.assert_allclose(fields["displacement_m"], position_m - FLAT)
    np.testing.assert_allclose(fields["acceleration_m_per_s2"], -500.0)


@pytest.mark.parametrize(("along", "across", "largest"), [(1.1, 1.0, 10), (1.02, 1.05, 5), (0.9, 0.95, -5)])
def test_the_larger_stretch_counts(along: float, across: float, largest: float) -> None:
    """A rotation changes nothing."""
    turn = np.array([[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]])
    stretched = moved(FLAT * [along, across, 1.0] @ turn)
    stretch_percent = SurfaceFields(FLAT, TRIANGLES, 1e-3).stretch_percent(stretched)
    np.testing.assert_allclose(stretch_percent, largest, rtol=1e-9)


def test_a_surface_at_rest_has_no_stretch() -> None:
    np.testing.assert_allclose(
        SurfaceFields(FLAT, TRIANGLES, 1e-3).stretch_percent(moved(FLAT)), 0, atol=1e-12
    )
