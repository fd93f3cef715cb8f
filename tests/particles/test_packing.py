"""Blocks: number, sizes, room and no overlaps."""

from __future__ import annotations

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.case.bed.packing import place_block
from orchestrator.case.bed.size_distribution import counts, random_sizes_m, shares, size_class
from orchestrator.case.tables.bed import Block, SizeClass
from orchestrator.ports import Array
from orchestrator.ports.plans import ParticleList
from tests.grains import one_sphere
from tests.particles.sizes import COAL, mass_shares, smallest_gap_m

CUBE_M = np.array([[0.0, -0.1, 0.2], [0.2, 0.1, 0.4]])


def filled(sizes: tuple[SizeClass, ...], count: int, box_m: Array, seed: int = 1) -> ParticleList:
    block = Block(
        material="coal",
        box_m=box_m.tolist(),
        count=count,
        sizes=sizes,
        velocity_m_per_s=(0.1, 0.0, -0.2),
        seed=seed,
    )
    return place_block(block, one_sphere(1.0, material=2))


@settings(max_examples=25, deadline=None)
@given(
    count=st.integers(1, 300),
    split=st.floats(0.05, 0.95),
    ratio=st.floats(1.0, 8.0),
    seed=st.integers(0, 2**32),
)
def test_every_sphere_is_inside_and_none_overlaps(count: int, split: float, ratio: float, seed: int) -> None:
    sizes = (size_class(0.002, 0.002 * ratio, split), size_class(0.004, 0.004 * ratio, 1.0 - split))
    packed = filled(sizes, count, np.array([[0.0, 0.0, 0.0], [0.4, 0.4, 0.4]]), seed)
    reach_m = packed.grains.sieve_size_m[:, None] / 2.0
    assert len(packed) == count
    assert smallest_gap_m(packed) >= 0.0
    assert np.all(packed.position_m >= reach_m)
    assert np.all(packed.position_m <= 0.4 - reach_m)


def test_the_mass_of_each_class_is_its_share() -> None:
    diameter_m = random_sizes_m(COAL, 20000, np.random.default_rng(3))
    np.testing.assert_allclose(mass_shares(diameter_m, COAL), [0.3, 0.3, 0.4], atol=0.02)


@given(total=st.integers(0, 10000), share=st.floats(0.01, 0.99))
def test_class_counts_add_up(total: int, share: float) -> None:
    number = counts((size_class(0.001, 0.002, share), size_class(0.005, 0.006, 1.0 - share)), total)
    assert number.sum() == total
    assert (number >= 0).all()


def test_the_same_seed_gives_the_same_block() -> None:
    first, again, other = (filled(COAL, 200, CUBE_M, seed) for seed in (5, 5, 6))
    np.testing.assert_array_equal(first.position_m, again.position_m)
    np.testing.assert_array_equal(first.grains.sieve_size_m, again.grains.sieve_size_m)
    assert not np.array_equal(first.position_m, other.position_m)


def test_a_full_box_is_an_error() -> None:
    small_m = np.array([[0.0, 0.0, 0.0], [0.02, 0.02, 0.02]])
    with pytest.raises(ValueError, match=r"\b100\b"):
        filled((size_class(0.005, 0.005, 1.0),), 100, small_m)


def test_limits_out_of_order_are_refused() -> None:
    with pytest.raises(ValueError, match=r"\b0\.2\b.*\b0\.1\b"):
        shares((size_class(0.2, 0.1, 1.0),))


def test_shares_must_add_up_to_one() -> None:
    with pytest.raises(ValueError, match=r"\b0\.4\b.*\b0\.5\b"):
        shares((size_class(0.1, 0.2, 0.4), size_class(0.2, 0.3, 0.5)))


def test_fifty_thousand_particles_take_seconds() -> None:
    """The packing fills 20 % of the volume in processor time; measured 1.2 s."""
    volume_m3 = np.pi / 6.0 * np.sum(random_sizes_m(COAL, 50000, np.random.default_rng(1)) ** 3) / 0.2
    box_m = np.array([[0.0, 0.0, 0.0], 3 * [volume_m3 ** (1 / 3)]])
    start = time.process_time()
    packed = filled(COAL, 50000, box_m)
    assert time.process_time() - start < 10.0
    assert smallest_gap_m(packed) >= 0.0
