"""Mass, density and slope of the grains in a box, of beds whose answers are known."""

from __future__ import annotations

import math

import numpy as np
import pytest

from orchestrator.case.tables.case import Bulk
from orchestrator.output.records.bulk import measure_bulk
from orchestrator.ports import Array, ParticleSnapshot
from tests.grains import sphere_kg, spheres

D_M = 0.008
SIDE = 12  # grains along each side of the bed


def bed(place_m: Array) -> ParticleSnapshot:
    still = np.zeros_like(place_m)
    return ParticleSnapshot(
        np.arange(1, len(place_m) + 1), place_m, still, still, spheres(np.full(len(place_m), D_M))
    )


def cubic() -> Array:
    """Grains on a cubic lattice that touch: their density is pi / 6 of their own."""
    ends = (np.arange(SIDE) + 0.5) * D_M
    return np.stack(np.meshgrid(ends, ends, ends), axis=-1).reshape(-1, 3)


@pytest.mark.parametrize("moved", [0.0, 0.1, 0.25, 0.37, 0.5])
def test_a_lattice_has_its_density_wherever_the_box_cuts_it(moved: float) -> None:
    low, high = (3 + moved) * D_M, (8 + moved) * D_M
    answer = measure_bulk(Bulk(box_m=((low,) * 3, (high,) * 3)), bed(cubic()))
    assert answer["density_kg_per_m3"] == pytest.approx(1430.0 * math.pi / 6, rel=0.01)
    assert answer["mass_kg"] == pytest.approx(5**3 * sphere_kg(D_M), rel=0.01)


def test_a_grain_that_a_box_halves_counts_half() -> None:
    answer = measure_bulk(
        Bulk(box_m=((-1.0, -1.0, 0.0), (1.0, 1.0, 1.0))), bed(np.array([[0.01, 0.02, 0.0]]))
    )
    assert answer["mass_kg"] == pytest.approx(sphere_kg(D_M) / 2, rel=1e-9)
    assert math.isnan(answer["slope_deg"])


@pytest.mark.parametrize("slope_deg", [0.0, 20.0, 35.0])
@pytest.mark.parametrize("way_deg", [0.0, 90.0, 30.0])
def test_the_slope_is_that_of_the_highest_grains(slope_deg: float, way_deg: float) -> None:
    """A smooth slope of grains above a bed; what lies deeper does not count."""
    way = math.radians(way_deg)
    place_m = cubic()
    top_m = place_m[place_m[:, 2] == place_m[:, 2].max()].copy()
    along_m = top_m[:, 0] * math.cos(way) + top_m[:, 1] * math.sin(way)
    top_m[:, 2] = 0.2 - along_m * math.tan(math.radians(slope_deg))
    answer = measure_bulk(
        Bulk(box_m=((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))), bed(np.concatenate([place_m, top_m]))
    )
    assert answer["slope_deg"] == pytest.approx(slope_deg, abs=1e-6)
