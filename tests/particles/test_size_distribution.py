"""Curves, and what becomes of the fines."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from orchestrator.case.bed.size_distribution import (
    CurveClass,
    classes,
    faults,
    finer_share,
    mean_cube_m3,
    random_sizes_m,
    sample_of,
    share_between,
    share_left_out,
    size_class,
    size_m,
)
from orchestrator.case.tables.bed import Block, Feed

CURVE = [(0.002, 0.0), (0.004, 0.3), (0.01, 0.9), (0.02, 1.0)]


def source(**given: Any) -> Block:
    table = {"material": "coal", "box_m": [[0, 0, 0], [1, 1, 1]], "count": 1, **given}
    return Block.model_validate(table)


def curve(points: list[tuple[float, float]] = CURVE, **given: Any) -> Block:
    rows = [{"sieve_size_m": d, "passing": share} for d, share in points]
    return source(curve=rows, **given)


def sizes(*rows: tuple[float, float, float], **given: Any) -> Block:
    names = ("smallest_m", "largest_m", "mass_fraction")
    return source(sizes=[dict(zip(names, row, strict=True)) for row in rows], **given)


def passing(block: Block, at_m: float) -> float:
    """Return the share that passes by mass, of many particles."""
    drawn_m = random_sizes_m(classes(block), 200_000, np.random.default_rng(1))
    return float(np.sum(drawn_m[drawn_m <= at_m] ** 3) / np.sum(drawn_m**3))


WIDE = [(0.004, 0.0), (0.008, 0.4), (0.016, 1.0)]  # few points, far apart


@pytest.mark.parametrize("points", [CURVE, WIDE])
@pytest.mark.parametrize("at_m", [0.0025, 0.003, 0.004, 0.006, 0.0067, 0.0072, 0.008, 0.01, 0.0148, 0.015])
def test_a_curve_is_followed_at_its_points_and_between_them(
    points: list[tuple[float, float]], at_m: float
) -> None:
    """The classes follow it without an error, drawn particles as far as their number goes: the mass below a
    diameter is a share of a sum whose largest parts are single particles."""
    wanted = np.interp(at_m, *np.transpose(points))
    block = curve(points)
    below = sum(row.mass_fraction * share_between(row, 0.0, at_m) for row in classes(block))
    assert below == pytest.approx(wanted, abs=1e-12)
    assert passing(block, at_m) == pytest.approx(wanted, abs=0.006)


def test_the_mean_cube_is_that_of_the_particles_drawn() -> None:
    """The limits are far apart, for both kinds of classes."""
    for row in (
        size_class(0.002, 0.02, 1.0),
        CurveClass(smallest_m=0.002, largest_m=0.02, mass_fraction=1.0),
    ):
        middle = (np.arange(2_000_000) + 0.5) / 2_000_000
        assert mean_cube_m3([row])[0] == pytest.approx(np.mean(size_m(row, middle) ** 3), rel=1e-5)


def test_a_flat_piece_of_a_curve_has_no_particles() -> None:
    block = curve([(0.002, 0.0), (0.004, 0.5), (0.01, 0.5), (0.012, 1.0)])
    assert not any(0.004 < (row.smallest_m + row.largest_m) / 2 < 0.01 for row in classes(block))


def test_fines_are_left_out() -> None:
    block = curve(smallest_fed_m=0.004)
    assert finer_share(block) == pytest.approx(0.3)
    assert share_left_out(block) == pytest.approx(0.3)
    assert sum(row.mass_fraction for row in classes(block)) == pytest.approx(1.0)
    assert min(row.smallest_m for row in classes(block)) == pytest.approx(0.004)
    assert passing(block, 0.01) == pytest.approx(0.6 / 0.7, abs=0.006)


def test_a_class_is_cut_where_its_diameters_are() -> None:
    """A class of 2 to 4 mm, evenly spread by number, has (3^4 - 2^4) / (4^4 - 2^4) of the mass below 3."""
    block = sizes((0.002, 0.004, 0.5), (0.004, 0.005, 0.5), smallest_fed_m=0.003)
    assert share_left_out(block) == pytest.approx(0.5 * (81 - 16) / (256 - 16))
    assert classes(block)[0].smallest_m == 0.003


def test_fines_are_made_of_the_next_class() -> None:
    rows = ((0.002, 0.003, 0.2), (0.005, 0.006, 0.3), (0.006, 0.008, 0.5))
    block = sizes(*rows, smallest_fed_m=0.004, finer="next-class")
    assert share_left_out(block) == 0.0
    assert [row.mass_fraction for row in classes(block)] == pytest.approx([0.5, 0.5])
    assert classes(block)[0].smallest_m == 0.005


@pytest.mark.parametrize(
    ("block", "key", "clue"),
    [
        (source(), "sizes", "missing"),
        (sizes((0.1, 0.2, 1.0), curve=[{"sieve_size_m": 0.1, "passing": 1}]), "curve", "sizes"),
        (curve(CURVE[:1]), "curve", "rising"),
        (curve(CURVE[::-1]), "curve", "rising"),
        (curve(CURVE[1:]), "curve", "0.3"),
        (curve(CURVE[:3]), "curve", "0.9"),
        (curve(smallest_fed_m=0.03), "smallest_fed_m", "0.03"),
    ],
)
def test_what_is_no_distribution_is_refused(block: Block, key: str, clue: str) -> None:
    (fault,) = faults(block)
    assert fault[0] == key
    assert clue in fault[1]


def test_good_ones_have_no_faults() -> None:
    assert list(faults(curve(smallest_fed_m=0.003))) == []
    assert list(faults(sizes((0.1, 0.2, 1.0)))) == []


def feed(points: list[tuple[float, float]] = CURVE, **given: Any) -> Feed:
    rows = [{"sieve_size_m": d, "passing": share} for d, share in points]
    table = {"material": "coal", "box_m": [[0, 0, 0], [1, 1, 1]], "rate_kg_per_s": 2.0, "curve": rows}
    return Feed.model_validate(table | given)


def test_a_sample_has_as_many_particles_as_if_all_had_one_diameter() -> None:
    """Particles of 2 to 5 mm, 40 % of the mass, are as many as of 8 mm: of 2.1 mm, one in (8/2.1)^3.

    In a narrow class all have the same chance, that of the mean cube of its diameters.
    """
    block = feed(sampled_below_m=0.005, sampled_as_m=0.008)
    rows, comes = classes(block), 1.0 - share_left_out(block)
    fine = [row for row in rows if row.largest_m <= 0.005]
    assert (
        max(row.largest_m for row in fine) == min(row.smallest_m for row in rows if row not in fine) == 0.005
    )
    number = [row.mass_fraction / mean_cube_m3([row])[0] for row in fine]
    assert sum(number) * comes == pytest.approx(0.4 / 0.008**3)
    whole = {row.smallest_m: row.mass_fraction for row in classes(feed())}
    first = min(fine, key=lambda row: row.smallest_m)
    one_in = whole[first.smallest_m] / (first.mass_fraction * comes)
    assert one_in == pytest.approx((0.008 / 0.0022) ** 3, rel=0.3)
    coarse = sum(row.mass_fraction for row in rows if row not in fine) * comes
    assert coarse == pytest.approx(0.6)
    sample = sample_of(block)
    assert sample is not None
    assert (sample.share, sample.computed) == pytest.approx((0.4, comes - 0.6))
    assert sample.one_in[1] == pytest.approx(one_in)
    assert sample.in_words.startswith(
        "of the particles of 2 to 5 mm (40.0% of the mass) one in 4.56 to 49.5 is"
    )
    assert sample_of(feed()) is None


def test_the_next_whole_class_takes_over_what_is_not_computed() -> None:
    """Its mass is that of all which is finer, less what the sample computes."""
    given = {"smallest_fed_m": 0.003, "sampled_below_m": 0.005, "sampled_as_m": 0.008}
    out, taken = feed(**given), feed(**given, finer="next-class")
    assert share_left_out(taken) == 0.0
    assert sum(row.mass_fraction for row in classes(taken)) == pytest.approx(1.0)
    rest = share_left_out(out)
    for first, second in zip(classes(out), classes(taken), strict=True):
        more = rest if second.smallest_m == 0.005 else 0.0
        assert second.mass_fraction == pytest.approx(first.mass_fraction * (1.0 - rest) + more)


@pytest.mark.parametrize(
    ("given", "key", "clue"),
    [
        ({"sampled_as_m": 0.004}, "sampled_as_m", "sampled_below_m"),
        ({"sampled_below_m": 0.004, "sampled_as_m": 0.003}, "sampled_as_m", "0.003"),
        ({"sampled_below_m": 0.002}, "sampled_below_m", "0.002"),
        ({"sampled_below_m": 0.004, "smallest_fed_m": 0.004}, "sampled_below_m", "finer"),
        ({"sampled_below_m": 0.03, "finer": "next-class"}, "sampled_below_m", "class"),
    ],
)
def test_what_cannot_be_sampled_is_refused(given: dict[str, Any], key: str, clue: str) -> None:
    (fault,) = faults(feed(**given))
    assert fault[0] == key
    assert clue in fault[1]


def test_samples_without_faults() -> None:
    assert list(faults(feed(sampled_below_m=0.004))) == []
    assert list(faults(feed(sampled_below_m=0.03))) == []
