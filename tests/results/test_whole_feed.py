"""The feed whose finest sizes are not computed, completed by a partition curve that is known."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from orchestrator.case.bed.size_distribution import finer_share
from orchestrator.case.tables.bed import Feed
from orchestrator.output.results import compute
from orchestrator.output.results.compute import compute_results
from orchestrator.output.results.events import Events, EventTable, Exits
from orchestrator.output.results.whole_feed import PartitionCurve, feed_fines, fit_partition, whole_feed
from orchestrator.ports import Array
from orchestrator.ports.physics import sphere_mass_kg
from tests.results.synthetic import folder_of

OPENING_M = 0.003
BOX = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
LAW = PartitionCurve(2.0, 0.45, OPENING_M)


def feed(limit_m: float | None = None, rate: float = 1.0, finest_m: float = 0.0005) -> Feed:
    """Half of the mass is coarse, half is spread evenly over the diameters from ``finest_m`` to 3 mm."""
    rows = [{"diameter_m": finest_m, "passing": 0.0}, {"diameter_m": 0.003, "passing": 0.5}]
    rows += [{"diameter_m": 0.004, "passing": 0.5}, {"diameter_m": 0.009, "passing": 1.0}]
    table = {"material": "coal", "box_m": BOX, "curve": rows, "rate_kg_per_s": rate}
    return Feed.model_validate(table | ({} if limit_m is None else {"smallest_fed_m": limit_m}))


def events(law: PartitionCurve, smallest_m: float, number: int = 60_000) -> Events:
    """Return particles spread evenly by mass over 100 cycles that pass two sections by a law."""
    generator = np.random.default_rng(7)
    mass_less = generator.uniform(size=number)
    diameter_m = smallest_m + (OPENING_M - smallest_m) * mass_less
    keep = generator.uniform(size=number) < (smallest_m / diameter_m) ** 3  # even by mass, not by number
    diameter_m = diameter_m[keep]
    time_s = np.sort(generator.uniform(0.1, 100.0, len(diameter_m)))
    half = PartitionCurve(law.rate / 2, law.exponent, law.opening_m).passed(diameter_m)
    drawn = generator.uniform(size=len(diameter_m))
    exit_number = np.where(drawn < half, 0, np.where(drawn < law.passed(diameter_m), 1, 2))
    mass_kg = sphere_mass_kg(diameter_m, 1430.0)
    came = EventTable(np.arange(len(diameter_m)), time_s, diameter_m, mass_kg)
    place_m = np.zeros((len(diameter_m), 3))
    left = EventTable(came.id, time_s, diameter_m, mass_kg, place_m, exit_number)
    exits = Exits(("one", "two", "end"), ("undersize", "undersize", "oversize"))
    return Events(came, left, exits, np.arange(101.0))


def mean_passed(law: PartitionCurve, low_m: float = 0.0005, high_m: float = 0.003) -> float:
    """Return the share that passes of masses that are spread evenly over the diameters."""
    diameter_m = np.linspace(low_m, high_m, 200_001)
    return float(law.passed(diameter_m).mean())


def test_a_curve_is_found_again() -> None:
    """Numbers in exact proportion: the likelihood is largest for the law itself."""
    sizes_m = np.linspace(0.001, 0.0029, 12)
    under = 1e4 * LAW.passed(sizes_m)
    found = fit_partition(sizes_m, under, 1e4 - under, OPENING_M)
    assert found is not None
    assert (found.rate, found.exponent) == pytest.approx((LAW.rate, LAW.exponent), rel=1e-5)


@pytest.mark.parametrize(
    ("sizes_m", "under", "over"),
    [
        ([0.001, 0.002], [5.0, 5.0], [0.0, 0.0]),
        ([0.001, 0.002], [0.0, 0.0], [5.0, 5.0]),
        ([0.002, 0.002], [2.0, 3.0], [5.0, 5.0]),
    ],
)
def test_what_determines_no_curve_gives_none(
    sizes_m: list[float], under: list[float], over: list[float]
) -> None:
    assert fit_partition(np.array(sizes_m), np.array(under), np.array(over), OPENING_M) is None


def test_too_large_particles_do_not_pass() -> None:
    shares: Array = LAW.passed(np.array([0.0, 0.0029, 0.003, 0.004]))
    assert shares == pytest.approx([1 - np.exp(-2.0), 1 - np.exp(-2.0 * (1 / 30) ** 0.45), 0.0, 0.0])


def test_fines_of_a_feed_are_divided_by_their_mass() -> None:
    """From 0.5 to 3 mm are half of the mass, evenly: a fifth of it is finer than 1 mm.  In a narrow class
    diameters are even by number, which moves 2 % of what a limit inside of it cuts off."""
    fines = feed_fines([feed(0.001)], OPENING_M)
    assert fines.left_out == pytest.approx(finer_share(feed(0.001)), rel=1e-12)
    assert (fines.total, fines.left_out) == (pytest.approx(0.5, rel=1e-12), pytest.approx(0.1, rel=0.02))
    assert float(fines.share @ fines.diameter_m) / fines.left_out == pytest.approx(0.00075, rel=5e-3)
    assert feed_fines([feed()], OPENING_M).left_out == 0.0
    twice = feed_fines([feed(0.001, 3.0), feed(rate=1.0)], OPENING_M)
    assert twice.left_out == pytest.approx(0.75 * fines.left_out, rel=1e-12)


def test_feeds_are_mixed_by_what_they_have_fed() -> None:
    """The first one ends after 1 s of 10 s, of which the second one feeds 9 s."""
    short = feed(0.001).model_copy(update={"start_s": 0.0, "stop_s": 1.0})
    rest = feed(rate=feed().rate_kg_per_s).model_copy(update={"start_s": 1.0})
    alone = feed_fines([feed(0.001)], OPENING_M).left_out

    def left_out(start_s: float, end_s: float) -> float:
        return feed_fines([short, rest], OPENING_M, (start_s, end_s)).left_out

    assert left_out(0.0, 10.0) == pytest.approx(0.1 * alone, rel=1e-12)
    assert left_out(0.0, 0.5) == left_out(0.8, 1.0) == pytest.approx(alone, rel=1e-12)
    assert left_out(0.9, 1.4) == pytest.approx(0.2 * alone, rel=1e-12)
    late = feed_fines([feed(0.001), feed(0.002)], OPENING_M, (0.0, 10.0))
    assert late.smallest_computed_m == pytest.approx(0.001)
    stopped = feed(0.001).model_copy(update={"start_s": 0.0, "stop_s": 1.0})
    late = feed_fines([stopped, feed(0.002)], OPENING_M, (2.0, 10.0))
    assert late.smallest_computed_m == pytest.approx(0.002)
    assert left_out(2.0, 10.0) == 0.0  # the short one, which has left long ago, counts no more
    over = feed_fines([short], OPENING_M, (2.0, 10.0))  # what leaves then was fed before
    assert over.left_out == pytest.approx(alone, rel=1e-12)


@pytest.mark.parametrize("limit_m", [0.001, 0.0015, 0.002])
def test_the_whole_feed_is_completed(limit_m: float) -> None:
    """Only particles above a limit are seen; the law gives the share of all.

    Tolerance: four standard errors.
    """
    seen = events(LAW, limit_m)
    fines = feed_fines([feed(limit_m)], OPENING_M)
    table = whole_feed(seen, fines, OPENING_M)
    placement = table["fine_placement_percent"]
    assert placement.standard_error < 2.0
    assert abs(placement.value - 100 * mean_passed(LAW)) < 4 * placement.standard_error
    assert table["efficiency_percent"].value == pytest.approx(placement.value, rel=1e-12)
    assert (table["smallest_computed_m"], table["smallest_m"]) == (pytest.approx(limit_m), 0.0005)
    one, two = table["sections"]
    half = PartitionCurve(LAW.rate / 2, LAW.exponent, OPENING_M)
    error = one["cumulative_efficiency_percent"].standard_error
    assert abs(one["cumulative_efficiency_percent"].value - 100 * mean_passed(half)) < 4 * error
    whole_yield = one["yield_percent"].value + two["yield_percent"].value
    assert whole_yield == pytest.approx(fines.total * placement.value, rel=1e-9)


def test_a_class_that_takes_over_finer_mass_counts_as_it_is_listed() -> None:
    """With "next-class", the finest computed class is heavier than in the feed, and passes most easily.

    The particles of the same law are weighed as in the feed; unweighed, more of them seem to pass.
    """
    limit_m = 0.001
    table = feed(limit_m).model_dump() | {"finer": "next-class"}
    fines = feed_fines([Feed.model_validate(table)], OPENING_M)
    seen = events(LAW, limit_m)
    finest = 0.00113  # end of the finest class of the curve that is computed
    heavier = float(fines.weights(np.array([limit_m, finest]))[0])
    assert heavier < 0.6
    more = np.where(seen.removed.diameter_m < finest, 1.0 / heavier, 1.0)
    rows = (replace(row, mass_kg=row.mass_kg * more) for row in (seen.fed, seen.removed))
    fed_more = Events(*rows, seen.exits, seen.edges_s)
    placement = whole_feed(fed_more, fines, OPENING_M)["fine_placement_percent"]
    assert abs(placement.value - 100 * mean_passed(LAW)) < 4 * placement.standard_error
    unweighed = whole_feed(fed_more, feed_fines([feed(limit_m)], OPENING_M), OPENING_M)
    assert unweighed["fine_placement_percent"].value > placement.value + 1.0


def test_coarse_grains_that_pass_lower_the_efficiency() -> None:
    """Particles above a cut size of 2 mm pass openings of 3 mm, and their share counts against the screen."""
    seen, fines = events(LAW, 0.001), feed_fines([feed(0.001)], 0.002)
    table = whole_feed(seen, fines, OPENING_M)
    coarse = seen.removed.diameter_m >= 0.002
    passed = seen.removed.mass_kg[coarse & (seen.removed.exit < 2)].sum() / seen.removed.mass_kg[coarse].sum()
    lower = table["fine_placement_percent"].value - table["efficiency_percent"].value
    assert lower == pytest.approx(100 * passed, rel=5e-3)
    assert table["efficiency_percent"].half_width > table["fine_placement_percent"].half_width


def test_openings_that_differ_have_no_common_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    """Undersize of a double deck must pass the smaller openings, through which the curve of the larger ones
    lets too much: 89 instead of 79 % of a fine class."""
    run: Any = SimpleNamespace(case=SimpleNamespace(bed=SimpleNamespace(feeds={"coal": feed(0.001)})))
    for openings_m, is_there in (((OPENING_M, OPENING_M), True), ((2 * OPENING_M, OPENING_M), False)):
        monkeypatch.setattr(compute, "smaller_sides_m", lambda _, given=openings_m: given)
        table: dict[str, Any] = {"screening": {"fine_particles": 10_000}, "missing": {}}
        compute._add_whole_feed(run, events(LAW, 0.001), OPENING_M, table)
        assert ("whole_feed" in table["screening"]) == is_there
        assert ("whole feed" in table["missing"]) != is_there


def test_a_run_that_computes_all_sizes_has_none(tmp_path_factory: pytest.TempPathFactory) -> None:
    results = compute_results(folder_of(tmp_path_factory.mktemp("whole") / "run"))
    assert "whole_feed" not in results["screening"]
    assert "whole feed" not in results["missing"]
