"""The parts of LIGGGHTS's box that ranks own.  No solver needed."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from adapters.particles.liggghts.domain_cuts import (
    Places,
    cuts_on_the_way,
    even_cuts,
    first_cuts,
    processor_grid,
)
from adapters.particles.liggghts.input import cutoff_m, input_text, smallest_box_m
from tests.particles.liggghts_bed import bed_plan
from tests.particles.liggghts_plans import flat, make_plan, spheres

BOX_M = np.array([[0.0, 0.0, 0.0], [1.0, 0.4, 2.0]])
RANDOM = np.random.default_rng(3)


def on_the_floor(number=2000):
    """Spheres all over the floor of a box that is higher than it is long."""
    return spheres(RANDOM.uniform([0.0, 0.0, 0.0], [0.1, 0.1, 0.02], (number, 3)))


def test_a_high_box_is_not_cut_in_height():
    """LIGGGHTS would cut this one in height, with all particles in the lower part."""
    domain_m = np.array([[0.0, 0.0, 0.0], [0.1, 0.1, 0.5]])
    plan = make_plan(flat(), on_the_floor(), domain_m=domain_m)
    box_m = np.array([[-0.01, -0.01, 0.0], [0.11, 0.11, 0.5]])
    for ranks in (2, 4, 8):
        assert processor_grid(plan, box_m, ranks, 6e-3)[2] == 1
    assert processor_grid(plan, box_m, 4, 6e-3) == (2, 2, 1)


def test_the_input_names_the_grid_of_several_ranks_alone():
    plan = bed_plan(communicator=SimpleNamespace(size=2))
    assert "processors      2 1 1\nregion" in input_text(plan)
    assert "processors" not in input_text(bed_plan())


def test_parts_hold_equal_shares():
    at = Places.of_particles(np.column_stack([RANDOM.beta(2, 8, 9000), RANDOM.uniform(0, 0.4, (9000, 2))]))
    cuts = even_cuts(at.in_slices(BOX_M), (4, 2, 1), BOX_M, 1e-3)
    assert [len(cut) for cut in cuts] == [5, 3, 2]
    for side, cut, length_m in zip(at.position_m.T, cuts, BOX_M[1], strict=True):
        held, _ = np.histogram(side, np.array(cut) * length_m)
        np.testing.assert_allclose(held / 9000, 1 / len(held), atol=2e-3)


def test_no_part_is_narrower_than_the_cutoff():
    """All particles in one place: three cuts stand one cutoff apart, the fourth part has the rest."""
    for place, expected in ((0.01, [0.0, 0.05, 0.1, 0.15, 1.0]), (0.99, [0.0, 0.85, 0.9, 0.95, 1.0])):
        crowd = Places.of_particles(np.full((100, 3), place))
        cuts = even_cuts(crowd.in_slices(BOX_M), (4, 1, 1), BOX_M, 0.05)[0]
        assert np.diff(cuts).min() >= 0.05 - 1e-12
        assert cuts[0] == 0.0
        assert cuts[-1] == 1.0
        assert max(abs(np.array(cuts) - expected)) < 0.06


def test_without_particles_the_deck_is_divided():
    surface = flat()
    full_plan = make_plan(surface, spheres([0.0, 0.0, 0.01]), communicator=SimpleNamespace(size=2))
    plan = replace(full_plan, particles=spheres(np.zeros((0, 3))))
    box_m = smallest_box_m(plan)
    cut = first_cuts(plan, (2, 1, 1), box_m, cutoff_m(plan))[0][1]
    middle_m = surface.position_m[:, 0].mean()
    assert box_m[0, 0] + cut * np.ptp(box_m[:, 0]) == pytest.approx(middle_m, abs=1e-3)


def test_a_cut_goes_halfway_into_a_neighbouring_part_at_most():
    """LIGGGHTS hands particles to the ranks beside a rank."""
    now, wanted = (
        [[0.0, 0.2, 0.4, 1.0], [0.0, 1.0], [0.0, 1.0]],
        [[0.0, 0.6, 0.9, 1.0], [0.0, 1.0], [0.0, 1.0]],
    )
    np.testing.assert_allclose(cuts_on_the_way(now, wanted)[0], [0.0, 0.3, 0.7, 1.0])
    wanted[0][1:3] = [0.25, 0.3]
    np.testing.assert_allclose(cuts_on_the_way(now, wanted)[0], [0.0, 0.25, 0.3, 1.0])
