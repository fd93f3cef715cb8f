"""Means, their confidence and errors, on figures that are known without any run."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.records.summary import processor_by_part_s
from orchestrator.output.results.quantities import Metrics
from orchestrator.preflight.refinement import RefinementSeries, Setting
from orchestrator.studies.accuracy.combinations import (
    ALONE,
    EXACT,
    Combination,
    Error,
    errors,
    scatter,
    worst_error,
)
from orchestrator.studies.accuracy.convergence import MeasuredSeries

GENERATOR = np.random.default_rng(4)


def point(*values: float) -> Combination:
    every = tuple(
        Metrics(
            {"deflection_m": value, "frame_half_range_m": 2.0, "energy_defect": 1e-3},
            np.empty((0, 0)),
            {
                "wall_s": 10.0,
                "processor_before_s": 0.0,
                "processor_s": 8.0,
                "wall_by_part_s": {"particles": 5.0, "rest": 5.0},
            },
        )
        for value in values
    )
    return Combination(ALONE, "one", metrics=every)


def test_nothing_random_has_no_interval() -> None:
    wrong = errors(point(1.1), point(1.0), scatter([point(1.1), point(1.0)], False))
    assert wrong == {"deflection_m": Error(pytest.approx(0.1), 0.0), "frame_half_range_m": Error(0.0, 0.0)}
    assert worst_error(wrong, ["frame_half_range_m", "deflection_m"]) == (
        "deflection_m",
        wrong["deflection_m"],
    )
    assert worst_error(wrong, ["frame_half_range_m", "middle_rms_g"]) is None
    assert worst_error(wrong, []) is None


def test_one_seed_tells_nothing_about_chance() -> None:
    wrong = errors(point(1.1), point(1.0), scatter([point(1.1), point(1.0)], True))
    assert wrong["deflection_m"].half_width is None
    assert wrong["deflection_m"].is_certain


def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    """The runs differ by chance alone, of 5 %: 95 % of the intervals hold zero (of 600, within three
    standard deviations of that)."""
    held = 0
    for _ in range(100):
        points = [point(*(1 + 0.05 * GENERATOR.standard_normal(3))) for _ in range(7)]
        spread = scatter(points, True)
        held += sum(not errors(p, points[0], spread)["deflection_m"].is_certain for p in points[1:])
    assert 0.95 - 0.07 < held / 600 < 0.95 + 0.04


def test_processor_time_is_divided_as_wall_time_was() -> None:
    processor_s = point(1.0).processor_by_part_s
    assert processor_s == {"start": 0.0, "particles": 4.0, "rest": 4.0}
    run = {"processor_before_s": 2.0, "processor_s": 8.0, "wall_s": 12.0}
    assert processor_by_part_s(run | {"wall_by_part_s": {"panel": 12.0}}) == {"start": 2.0, "panel": 6.0}
    again = {"wall_by_part_s": {"panel": 4.0, "coupling": 8.0}, "repeated_by_part_s": {"panel": 6.0}}
    assert processor_by_part_s(run | again) == {"start": 2.0, "panel": 5.0, "coupling": 1.0}


def test_what_a_seed_does_to_all_points_alike_is_no_scatter() -> None:
    seeds = np.array([0.8, 1.0, 1.2])
    spread = scatter([point(*(height * seeds)) for height in (1.0, 1.1, 3.0)], True)
    assert set(spread.freedom.values()) == {4}
    still = scatter([point(0.0, 0.0), point(1.0, 1.1), point(1.0, 1.1)], True)
    assert "deflection_m" in still.deviation  # whatever stands still does not count
    assert spread.deviation["deflection_m"] == pytest.approx(0.0, abs=1e-12)


def test_the_error_that_decides_reaches_highest() -> None:
    """0.7 +- 5 % may be 5.7 %, 0.8 +- 0.1 % no more than 0.9 %."""
    wrong = {"frame_half_range_m": Error(0.008, 0.001), "middle_rms_g": Error(0.007, 0.05)}
    worst = worst_error(wrong, ["frame_half_range_m", "middle_rms_g"])
    assert worst is not None
    assert (worst[0], worst[1].at_most) == ("middle_rms_g", pytest.approx(0.057))


@pytest.mark.parametrize(("values", "order"), [((1.16, 1.04, 1.0), 1.58), ((1.2, 0.97, 1.0), None)])
def test_values_on_both_sides_of_the_finest_one_show_no_order(
    values: tuple[float, ...], order: float | None
) -> None:
    settings = tuple(Setting(str(h), h=h) for h in (4.0, 2.0, 1.0))
    points = tuple(point(value) for value in values)
    differences = tuple(errors(each, points[-1], EXACT) for each in points)
    series = RefinementSeries("panel", "strip", settings, expected=2.0, parameter="panel-mesh")
    measured = MeasuredSeries(series, settings, points, differences, ({}, {}, {}))
    shown = measured.orders.get("deflection_m")
    assert (shown is None) == (order is None)
    # with an order 1.25 times Richardson's estimate; without, what the last refinement changed
    remaining = 0.03 if order is None else 1.25 * 0.04 / (2**1.585 - 1)
    assert measured.remaining_error("deflection_m") == pytest.approx(remaining, rel=0.01)


def test_an_order_far_above_the_expected_one_is_chance() -> None:
    """Errors of a series of first order: 1 % and, by luck, nearly none."""
    settings = tuple(Setting(str(h), h=h) for h in (4.0, 2.0, 1.0))
    points = (point(1.04), point(1.003), point(1.0))
    differences = tuple(errors(each, points[-1], EXACT) for each in points)
    measured = MeasuredSeries(
        RefinementSeries("panel", "strip", settings, expected=1.0, parameter="panel-mesh"),
        settings,
        points,
        differences,
        ({},) * 3,
    )
    assert measured.orders["deflection_m"].order > 3.0
    assert not measured.is_clean("deflection_m")  # two points always lie on a line
    assert measured.remaining_error("deflection_m") == pytest.approx(0.003)
