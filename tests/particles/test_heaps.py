"""Heaps of spheres that stand for grains of a shape, beside published angles of repose.

Sliding friction and restitution are the library's of the material on itself, and the rolling friction is that
of its shape class.  The class `angular` was chosen by the heap of coal, `rounded` by that of pebbles; that of
crushed limestone, with other sliding friction, is a prediction.

EN 1991-4:2006, Eurocode 1, Actions on structures, part 4, Table E.1 (coal); Conveyor Equipment Manufacturers
Association, Belt Conveyors for Bulk Materials, chapter 3 (crushed limestone, gravel pebbles).
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import t as student

from orchestrator.case import solvers
from orchestrator.case.materials.library import materials, pairs, shapes
from orchestrator.ports.adapters import ParticlesAdapter
from tests.particles.contract import LIGGGHTS_ALONE
from tests.particles.heap import poured_slopes_deg

ASKED = LIGGGHTS_ALONE

pytestmark = pytest.mark.slow

PUBLISHED_DEG = {"coal": 36.0, "limestone": 38.0, "gravel": 30.0}
TOLERANCE_DEG = 2.0
"""Tables of repose give whole degrees, and those of different authors differ by two and more."""


CRUSHED_DEG = 38.0, 42.0
"""Angles of repose of crushed stone in tables: CEMA has 38 degrees for crushed limestone."""


def interval_deg(slopes_deg: list[float]) -> tuple[float, float]:
    """Return Student's interval of 95 % for the mean of heaps, which differ by avalanches."""
    count = len(slopes_deg)
    half_deg = student.ppf(0.975, count - 1) * np.std(slopes_deg, ddof=1) / np.sqrt(count)
    return np.mean(slopes_deg) - half_deg, np.mean(slopes_deg) + half_deg


def test_a_heap_of_clumps_has_the_slope_of_crushed_stone_and_spheres_have_not(
    module: ParticlesAdapter,
) -> None:
    """Without any rolling friction: four overlapping spheres hold each other by their shape.  Sliding
    friction is the library's of limestone.  The interval of the stones' mean, which is sure to two or three
    degrees, meets the tables' range; that of the spheres' lies below both."""
    friction = pairs()[frozenset(["limestone"])].quantities["sliding_friction"].value
    stones, spheres = (
        interval_deg(
            poured_slopes_deg(
                module,
                sliding_friction=friction,
                rolling_friction=0.0,
                restitution=0.4,
                radius_diameters=8.0,
                heaps=4,
                shape=solvers.shape(name),
            )
        )
        for name in ("stone", "sphere")
    )
    least_deg, most_deg = CRUSHED_DEG
    assert stones[0] <= most_deg, stones
    assert stones[1] >= least_deg, stones
    assert spheres[1] < min(stones[0], least_deg), (spheres, stones)


@pytest.mark.parametrize("name", PUBLISHED_DEG)
def test_a_heap_has_the_published_slope_by_its_shape_class(module: ParticlesAdapter, name: str) -> None:
    """The interval of the mean of four heaps, which differ by avalanches, meets the tables' range.  With the
    rolling friction of the published screen, 0.08, coal heaps at 29 degrees."""
    itself = pairs()[frozenset([name])].quantities
    least_deg, most_deg = interval_deg(
        poured_slopes_deg(
            module,
            sliding_friction=itself["sliding_friction"].value,
            rolling_friction=shapes()[materials()[name].shape].rolling_friction.value,
            restitution=itself["restitution"].value,
            radius_diameters=8.0,
            heaps=4,
        )
    )
    assert least_deg <= PUBLISHED_DEG[name] + TOLERANCE_DEG, (least_deg, most_deg)
    assert most_deg >= PUBLISHED_DEG[name] - TOLERANCE_DEG, (least_deg, most_deg)
