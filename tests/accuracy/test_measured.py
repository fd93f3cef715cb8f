"""Means, their confidence and errors, on figures that are known without any run."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.studies.accuracy.combinations import (
    ALONE,
    Combination,
    Error,
    errors,
    parts_s,
    scatter,
    worst_error,
)
from orchestrator.studies.quantities import Metrics

GENERATOR = np.random.default_rng(4)


def point(*values: float) -> Combination:
    every = tuple(
        Metrics(
            {"deflection_m": value, "frame_m": 2.0, "energy_defect": 1e-3},
            np.empty((0, 0)),
            {"wall_s": 10.0, "processor_s": 8.0, "wall_by_part_s": {"particles": 5.0, "rest": 5.0}},
        )
        for value in values
    )
    return Combination(ALONE, "one", metrics=every)


def test_nothing_random_has_no_interval() -> None:
    wrong = errors(point(1.1), point(1.0), scatter([point(1.1), point(1.0)], False))
    assert wrong == {"deflection_m": Error(pytest.approx(0.1), 0.0), "frame_m": Error(0.0, 0.0)}
    assert worst_error(wrong, ["frame_m", "deflection_m"]) == ("deflection_m", wrong["deflection_m"])
    assert worst_error(wrong, ["rms_g"]) is None


def test_one_seed_tells_nothing_about_chance() -> None:
    wrong = errors(point(1.1), point(1.0), scatter([point(1.1), point(1.0)], True))
    assert wrong["deflection_m"].half_width is None
    assert wrong["deflection_m"].is_certain


def test_intervals_cover_the_truth_as_often_as_they_say() -> None:
    """Nothing differs but by chance, of 5 %: 95 % of the intervals hold zero (of 600, within three
    standard deviations of that)."""
    held = 0
    for _ in range(100):
        points = [point(*(1 + 0.05 * GENERATOR.standard_normal(3))) for _ in range(7)]
        spread = scatter(points, True)
        held += sum(not errors(p, points[0], spread)["deflection_m"].is_certain for p in points[1:])
    assert 0.95 - 0.07 < held / 600 < 0.95 + 0.04


def test_processor_time_is_divided_as_wall_time_was() -> None:
    found = point(1.0).processor_by_part_s
    assert found == {"start": 0.0, "particles": 4.0, "rest": 4.0}
    run = {"processor_before_s": 2.0, "processor_s": 8.0, "wall_s": 12.0}
    assert parts_s(run | {"wall_by_part_s": {"panel": 12.0}}) == {"start": 2.0, "panel": 6.0}
    again = {"wall_by_part_s": {"panel": 4.0, "coupling": 8.0}, "repeated_by_part_s": {"panel": 6.0}}
    assert parts_s(run | again) == {"start": 2.0, "panel": 5.0, "coupling": 1.0}


def test_what_a_seed_does_to_all_points_alike_is_no_scatter() -> None:
    seeds = np.array([0.8, 1.0, 1.2])
    spread = scatter([point(*(height * seeds)) for height in (1.0, 1.1, 3.0)], True)
    assert spread.freedom == 4
    still = scatter([point(0.0, 0.0), point(1.0, 1.1), point(1.0, 1.1)], True)
    assert "deflection_m" in still.deviation  # whatever stands still does not count
    assert spread.deviation["deflection_m"] == pytest.approx(0.0, abs=1e-12)
