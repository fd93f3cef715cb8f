"""The feed whose finest sizes are not computed, completed by a partition curve that is known."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from orchestrator.case.bed.size_distribution import finer_share
from orchestrator.case.tables.bed import Feed
from orchestrator.figures.material import WholeFeed
from orchestrator.output.results import compute
from orchestrator.output.results.compute import compute_results
from orchestrator.output.results.events import Events, EventTable, Exits
from orchestrator.output.results.listed_feed import listed_feed
from orchestrator.output.results.screening import screening
from orchestrator.output.results.whole_feed import (
    TESTED_FACTOR,
    FeedFines,
    PartitionCurve,
    feed_fines,
    fit_partition,
    whole_feed,
)
from orchestrator.ports import Array
from tests.grains import sphere_kg
from tests.results.synthetic import folder_of

OPENING_M = 0.003
BOX = ((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
OPEN_SHARE = 0.3
LAW = PartitionCurve(6.0, 0.45, OPENING_M, OPEN_SHARE)


def feed(limit_m: float | None = None, rate: float = 1.0, finest_m: float = 0.0005) -> Feed:
    """Half of the mass is coarse, half is spread evenly over the diameters from ``finest_m`` to 3 mm."""
    rows = [{"sieve_size_m": finest_m, "passing": 0.0}, {"sieve_size_m": 0.003, "passing": 0.5}]
    rows += [{"sieve_size_m": 0.004, "passing": 0.5}, {"sieve_size_m": 0.009, "passing": 1.0}]
    table = {"material": "coal", "box_m": BOX, "curve": rows, "rate_kg_per_s": rate}
    return Feed.model_validate(table | ({} if limit_m is None else {"smallest_fed_m": limit_m}))


def events(law: PartitionCurve, smallest_m: float, number: int = 60_000, alike_m: float = 0.0) -> Events:
    """Return particles spread evenly by mass over 100 cycles that pass two sections by a law.

    Those finer than ``alike_m`` pass no more easily than grains of this size.
    """
    generator = np.random.default_rng(7)
    mass_less = generator.uniform(size=number)
    diameter_m = smallest_m + (OPENING_M - smallest_m) * mass_less
    keep = generator.uniform(size=number) < (smallest_m / diameter_m) ** 3  # even by mass, not by number
    diameter_m = diameter_m[keep]
    time_s = np.sort(generator.uniform(0.1, 100.0, len(diameter_m)))
    as_m = np.maximum(diameter_m, alike_m)
    half, whole = (of.passed(as_m) for of in (replace(law, attempts=law.attempts / 2), law))
    drawn = generator.uniform(size=len(diameter_m))
    exit_number = np.where(drawn < half, 0, np.where(drawn < whole, 1, 2))
    mass_kg = sphere_kg(diameter_m)
    came = EventTable(np.arange(len(diameter_m)), time_s, diameter_m, mass_kg)
    place_m = np.zeros((len(diameter_m), 3))
    left = EventTable(came.id, time_s, diameter_m, mass_kg, place_m, exit_number)
    exits = Exits(("one", "two", "end"), ("undersize", "undersize", "oversize"))
    return Events(came, left, exits, np.arange(101.0))


def mean_passed(law: PartitionCurve, alike_m: float = 0.0) -> float:
    """Return the share that passes of masses that are spread evenly from 0.5 to 3 mm."""
    diameter_m = np.linspace(0.0005, 0.003, 200_001)
    return float(law.passed(np.maximum(diameter_m, alike_m)).mean())


def test_a_curve_is_found_again() -> None:
    """Numbers in exact proportion: the likelihood is largest for the law itself."""
    sizes_m = np.linspace(0.001, 0.0029, 12)
    under = 1e4 * LAW.passed(sizes_m)
    fit = fit_partition(sizes_m, under, 1e4 - under, OPENING_M, OPEN_SHARE)
    assert fit is not None
    assert (fit.attempts, fit.exponent) == pytest.approx((LAW.attempts, LAW.exponent), rel=1e-4)


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
    assert fit_partition(np.array(sizes_m), np.array(under), np.array(over), OPENING_M, OPEN_SHARE) is None


def test_too_large_particles_do_not_pass() -> None:
    shares: Array = LAW.passed(np.array([0.0, 0.0029, 0.003, 0.004]))
    assert shares == pytest.approx([1 - 0.7**6, 1 - (1 - 0.3 * (1 / 30) ** 0.45) ** 6, 0.0, 0.0])


def test_the_finest_grain_passes_in_an_attempt_by_the_open_share() -> None:
    """Gaudin's chance of one attempt, 0.3 (1 - d/a)^2, known from half of the openings' width on, is
    continued to the share of the openings at size 0.  A law of many small chances comes to less."""
    once = PartitionCurve(1.0, 2.0, OPENING_M, OPEN_SHARE)
    sizes_m = np.linspace(0.0015, 0.0029, 12)
    under = 1e6 * once.passed(sizes_m)
    fit = fit_partition(sizes_m, under, 1e6 - under, OPENING_M, OPEN_SHARE)
    assert fit is not None
    assert float(fit.passed(np.array([0.0]))[0]) == pytest.approx(OPEN_SHARE, rel=1e-3)
    many = fit_partition(sizes_m, under, 1e6 - under, OPENING_M, 1e-4)
    assert many is not None
    assert float(many.passed(np.array([0.0]))[0]) < 0.27


def test_fines_of_a_feed_are_divided_by_their_mass() -> None:
    """Grains from 0.5 to 3 mm are half of the mass, evenly: a fifth of it is finer than 1 mm. In a narrow
    class diameters are even by number, which moves 2 % of what a limit inside of it cuts off."""
    fines = feed_fines([feed(0.001)], OPENING_M)
    assert fines.left_out == pytest.approx(finer_share(feed(0.001)), rel=1e-12)
    assert (fines.total, fines.left_out) == (pytest.approx(0.5, rel=1e-12), pytest.approx(0.1, rel=0.02))
    assert float(fines.share @ fines.size_m) / fines.left_out == pytest.approx(0.00075, rel=5e-3)
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


def completed(seen: Events, fines: FeedFines) -> WholeFeed:
    """Return the table of the whole feed."""
    table = whole_feed(seen, fines, OPENING_M, OPEN_SHARE)
    assert isinstance(table, WholeFeed), table
    return table


@pytest.mark.parametrize("limit_m", [0.001, 0.0012, 0.0015])
def test_the_whole_feed_is_completed(limit_m: float) -> None:
    """Particles above a limit only are seen; the law gives the share of all.

    Tolerance: four standard errors.
    """
    seen = events(LAW, limit_m)
    fines = feed_fines([feed(limit_m)], OPENING_M)
    table = completed(seen, fines)
    placement = table.fine_placement_percent
    assert placement.standard_error < 2.0
    assert abs(placement.value - 100 * mean_passed(LAW)) < 4 * placement.standard_error
    assert table.efficiency_percent.value == pytest.approx(placement.value, rel=1e-12)
    assert (table.smallest_computed_m, table.smallest_m) == (pytest.approx(limit_m), 0.0005)
    first, second = table.sections
    half = replace(LAW, attempts=LAW.attempts / 2)
    error = first.cumulative_efficiency_percent.standard_error
    assert abs(first.cumulative_efficiency_percent.value - 100 * mean_passed(half)) < 4 * error
    whole_yield = first.yield_percent.value + second.yield_percent.value
    assert whole_yield == pytest.approx(fines.total * placement.value, rel=1e-9)


def test_the_interval_has_the_error_of_the_continuation() -> None:
    """Grains below 1.6 mm pass no more easily than those of 1.6 mm, so that the curve of coarser ones lets
    too many of the finer ones pass: of those from 1 mm to 1.73 mm, by which it is tested, as of those from
    0.5 mm to 1 mm, to which it is continued.  The test's classes are 10 % wide in size, over which the share
    that passes changes by some points.
    """
    alike_m, fines = 0.0016, feed_fines([feed(0.001)], OPENING_M)
    steep = PartitionCurve(6.0, 1.5, OPENING_M, OPEN_SHARE)
    seen = events(steep, 0.001, 200_000, alike_m)
    table, truth = completed(seen, fines), 100 * mean_passed(steep, alike_m)
    placement, continuation = table.fine_placement_percent, table.continuation
    assert (continuation.factor, continuation.tested_factor) == pytest.approx((2.0, 3**0.5), rel=1e-6)
    seen_m, passed = seen.removed.sieve_size_m, seen.removed.exit < 2
    finer = seen_m < 0.003**0.5 * seen_m.min() ** 0.5
    law = fit_partition(seen_m[~finer], passed[~finer] * 1.0, ~passed[~finer] * 1.0, OPENING_M, OPEN_SHARE)
    assert law is not None
    kg = seen.removed.mass_kg[finer]
    too_much = 100 * np.average(law.passed(seen_m[finer]) - passed[finer], weights=kg)
    assert continuation.tested_error_percent == pytest.approx(too_much, abs=1.0)
    by_scatter = placement.standard_error * 2.3
    assert placement.value - truth > by_scatter  # what an interval without the error would say
    assert abs(placement.value - truth) < placement.half_width
    assert continuation.error_percent == pytest.approx(
        0.2 * continuation.tested_error_percent * (np.log(2) / np.log(3**0.5)) ** 2, rel=0.05
    )
    sure = completed(events(steep, 0.001, 200_000), fines)
    assert abs(sure.continuation.error_percent) < 0.3 * continuation.error_percent


def test_a_curve_that_cannot_be_tested_is_not_continued(monkeypatch: pytest.MonkeyPatch) -> None:
    """All grains of the coarser half stay above: they determine no curve, and the reason is told."""
    seen, fines = events(LAW, 0.001), feed_fines([feed(0.001)], OPENING_M)
    stays = np.where(seen.removed.sieve_size_m > 0.0017, 2, seen.removed.exit)
    none = replace(seen, removed=replace(seen.removed, exit=stays))
    assert isinstance(whole_feed(none, fines, OPENING_M, OPEN_SHARE), str)
    monkeypatch.setattr(compute, "smaller_sides_m", lambda _: [OPENING_M])
    monkeypatch.setattr(compute, "open_share", lambda _: OPEN_SHARE)
    run: Any = SimpleNamespace(case=SimpleNamespace(bed=SimpleNamespace(feeds={"coal": feed(0.001)})))
    missing: dict[str, str] = {}
    assert compute._whole_feed(run, none, OPENING_M, missing) is None
    assert "the coarser half of the fines" in missing["whole feed"]


@pytest.mark.parametrize("alike_m", [0.0, 0.95])
def test_sizes_beyond_the_tested_factor_pass_between_the_last_tested_one_and_all(alike_m: float) -> None:
    """Computed from 2 to 3 mm and listed from 0.5 mm: below 1 mm, nothing but a bound is known.

    The interval holds for grains that follow the curve, and for those that pass no more easily than the
    finest within reach, where the curve is wrong.
    """
    alike_m *= 0.001
    fines = feed_fines([feed(0.002)], OPENING_M)
    table = completed(events(LAW, 0.002), fines)
    placement, continuation = table.fine_placement_percent, table.continuation
    assert abs(placement.value - 100 * mean_passed(LAW, alike_m)) < placement.half_width
    reach_of_test = np.log(OPENING_M / 0.002) / 2
    tested = 0.6 * continuation.tested_error_percent * (np.log(TESTED_FACTOR) / reach_of_test) ** 2
    least, sizes_m = float(LAW.passed(np.array(0.001))), np.linspace(0.0005, 0.001, 20_001)
    passed = LAW.passed(sizes_m)
    doubt = 100 * 0.2 * float(np.maximum(passed - least, 1 - passed).mean())
    assert abs(continuation.error_percent) == pytest.approx(abs(tested) + doubt, abs=0.3)


def test_a_curve_of_which_too_little_is_known_is_refused() -> None:
    """A third of the fines is finer than half of what is computed, of which one in eight passes."""
    few = PartitionCurve(0.5, 0.45, OPENING_M, OPEN_SHARE)
    fines = feed_fines([feed(0.002, finest_m=5e-5)], OPENING_M)
    reason = whole_feed(events(few, 0.002, 200_000), fines, OPENING_M, OPEN_SHARE)
    assert isinstance(reason, str)
    assert "continued from 2 to 0.05 mm, may be wrong by" in reason


def test_a_class_that_takes_over_finer_mass_counts_as_it_is_listed() -> None:
    """The finest computed class with "next-class" is heavier than in the feed, and passes most easily.

    The particles of the same law are weighed as in the feed; unweighed, more of them seem to pass.
    """
    limit_m = 0.001
    table = feed(limit_m).model_dump() | {"finer": "next-class"}
    fines = feed_fines([Feed.model_validate(table)], OPENING_M)
    seen = events(LAW, limit_m)
    weight = fines.listed.weight(seen.removed.sieve_size_m)
    finest_m = 0.0005 * 6**0.4  # end of the finest class that is computed, the fourth of ten from 0.5 to 3 mm
    own = (finest_m - limit_m) / 0.0025 * 0.5
    of_finest = np.where(seen.removed.sieve_size_m < finest_m, own / (own + fines.left_out), 1.0)
    assert weight == pytest.approx(of_finest, rel=1e-9)
    rows = (replace(row, mass_kg=row.mass_kg / weight) for row in (seen.fed, seen.removed))
    fed_more = Events(*rows, seen.exits, seen.edges_s, listed=fines.listed)
    placement = completed(fed_more, fines).fine_placement_percent
    assert abs(placement.value - 100 * mean_passed(LAW)) < 4 * placement.standard_error
    unweighed = completed(replace(fed_more, listed=None), fines)
    assert unweighed.fine_placement_percent.value > placement.value + 1.0


def test_a_sampled_grain_stands_for_the_others_of_its_size() -> None:
    """All sizes are computed: those below 2 mm, most of the fines, one in (3 mm / d)^3.

    Weighed, the shares of the separation are those of all fines within four standard errors; unweighed, they
    are nearly those of the grains above 2 mm.  The rates are those of the particles that are there.
    """
    table = feed().model_dump() | {"sampled_below_m": 0.002, "sampled_as_m": 0.003}
    listed = listed_feed([Feed.model_validate(table)])
    every = events(LAW, 0.0005, 2_000_000)
    chance = 1.0 / listed.weight(every.removed.sieve_size_m)
    assert chance.min() < 0.01
    there = np.random.default_rng(3).uniform(size=len(chance)) < chance
    seen = replace(every, fed=_part(every.fed, there), removed=_part(every.removed, there), listed=listed)
    unweighed, weighed = (screening(of, OPENING_M) for of in (replace(seen, listed=None), seen))
    efficiency = weighed.efficiency_percent
    error = max(efficiency.standard_error, efficiency.counting)
    truth = 100 * mean_passed(LAW)
    assert error < 1.0
    assert abs(efficiency.value - truth) < 4 * error
    assert unweighed.efficiency_percent.value < truth - 10
    assert weighed.feed_kg_per_s.value == unweighed.feed_kg_per_s.value
    assert weighed.undersize_kg_per_s.value == unweighed.undersize_kg_per_s.value
    local = weighed.sections[0].cumulative_efficiency_percent.value
    assert abs(local - 100 * mean_passed(replace(LAW, attempts=LAW.attempts / 2))) < 4 * error
    fines = feed_fines([Feed.model_validate(table | {"smallest_fed_m": 0.001})], OPENING_M)
    coarser = there & (every.removed.sieve_size_m >= 0.001)
    part = replace(seen, fed=_part(every.fed, coarser), removed=_part(every.removed, coarser))
    placement = completed(part, fines).fine_placement_percent
    assert abs(placement.value - truth) < 4 * placement.standard_error


def _part(table: EventTable, mask: Any) -> EventTable:
    return EventTable(
        **{name: column[mask] if len(column) else column for name, column in vars(table).items()}
    )


def test_coarse_grains_that_pass_lower_the_efficiency() -> None:
    """Particles above a cut size of 2 mm pass openings of 3 mm, and their share counts against the screen."""
    seen, fines = events(LAW, 0.001), feed_fines([feed(0.001)], 0.002)
    table = completed(seen, fines)
    coarse = seen.removed.sieve_size_m >= 0.002
    passed = seen.removed.mass_kg[coarse & (seen.removed.exit < 2)].sum() / seen.removed.mass_kg[coarse].sum()
    lower = table.fine_placement_percent.value - table.efficiency_percent.value
    assert lower == pytest.approx(100 * passed, rel=5e-3)
    assert table.efficiency_percent.half_width > table.fine_placement_percent.half_width


def test_openings_that_differ_have_no_common_curve(monkeypatch: pytest.MonkeyPatch) -> None:
    """Undersize of a double deck must pass the smaller openings, through which the curve of the larger ones
    lets too much: 89 instead of 79 % of a fine class."""
    run: Any = SimpleNamespace(case=SimpleNamespace(bed=SimpleNamespace(feeds={"coal": feed(0.001)})))
    for openings_m, is_there in (((OPENING_M, OPENING_M), True), ((2 * OPENING_M, OPENING_M), False)):
        monkeypatch.setattr(compute, "smaller_sides_m", lambda _, given=openings_m: given)
        monkeypatch.setattr(compute, "open_share", lambda _: OPEN_SHARE)
        missing: dict[str, str] = {}
        curve = compute._whole_feed(run, events(LAW, 0.001), OPENING_M, missing)
        assert (curve is not None) == is_there
        assert ("whole feed" in missing) != is_there


def test_a_run_that_computes_all_sizes_has_none(tmp_path_factory: pytest.TempPathFactory) -> None:
    results = compute_results(folder_of(tmp_path_factory.mktemp("whole") / "run"))
    assert results.screening is not None
    assert results.screening.whole_feed is None
    assert "whole feed" not in results.missing
