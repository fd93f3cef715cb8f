"""Settings taken together, on errors and costs that are known."""

from __future__ import annotations

from itertools import product
from typing import Literal

import pytest

from orchestrator.preflight.refinement import Setting
from orchestrator.studies.accuracy.convergence import Model, Option

PARTS_S = {"particles": 8.0, "panel": 2.0}


def option(axis: str, name: str, error: float, **ratio: float) -> Option:
    setting = Setting(name, (f"{axis}={name}",) if name != "own" else ())
    return Option(axis, setting, {"deflection_m": error, "middle_rms_g": error / 2}, ratio)


AXES = {
    "step": [
        option("step", "own", 0.04),
        option("step", "half", 0.01, particles=2.0),
        option("step", "quarter", 0.0, particles=4.0),
    ],
    "mesh": [
        option("mesh", "coarse", 0.05, panel=0.5),
        option("mesh", "own", 0.02, panel=1.0),
        option("mesh", "fine", 0.0, panel=4.0),
    ],
}


def by_hand(tolerance: float) -> tuple[str, str]:
    """Cheapest of the nine by trying them all."""
    options = []
    for step, mesh in product(*AXES.values()):
        cost = 8 * step.ratio.get("particles", 1.0) + 2 * mesh.ratio.get("panel", 1.0)
        if step.error["deflection_m"] + mesh.error["deflection_m"] <= tolerance:
            options.append((cost, step.setting.label, mesh.setting.label))
    return min(options)[1:]


@pytest.mark.parametrize("tolerance", [0.2, 0.07, 0.05, 0.035, 0.015, 0.005])
def test_the_cheapest_within_a_tolerance_is_found(tolerance: float) -> None:
    model = Model(AXES, PARTS_S, ["deflection_m", "middle_rms_g"])
    cheapest = model.cheapest(tolerance)
    assert cheapest is not None
    assert tuple(each.setting.label for each in cheapest.options) == by_hand(tolerance)
    assert cheapest.error <= tolerance


def test_the_best_within_a_time_and_its_cost() -> None:
    model = Model(AXES, PARTS_S, ["deflection_m"])
    best = model.best(24.5, "cheapest")
    assert best is not None
    assert [each.setting.label for each in best.options] == ["half", "fine"]
    assert (best.error, best.processor_s) == (pytest.approx(0.01), pytest.approx(24.0))
    assert best.settings.keys() == {"step", "mesh"}
    assert model.best(1.0, "cheapest") is None
    assert model.cheapest(0.0) is not None  # all that is measured is perfect here


def test_of_settings_that_are_equally_good_the_cheapest_and_the_finest_are_found() -> None:
    """The finer setting was cheaper, by chance."""
    axis = [
        Option("a", Setting(name, (f"a={name}",), h), {"deflection_m": 0.0}, {"panel": ratio})
        for name, h, ratio in (("long", 2.0, 1.1), ("short", 0.5, 1.0), ("middle", 1.0, 0.9))
    ]
    model = Model({"a": axis}, PARTS_S, ["deflection_m"])
    wanted: list[tuple[Literal["cheapest", "finest"], str]] = [("finest", "short"), ("cheapest", "middle")]
    for ties, label in wanted:
        best = model.best(100.0, ties)
        assert best is not None
        assert best.options[0].setting.label == label


def test_the_case_as_it_is_where_nothing_was_turned() -> None:
    best = Model({}, PARTS_S, ["deflection_m"]).best(100.0, "finest")
    assert best is not None
    assert (best.settings, best.processor_s) == ({}, pytest.approx(10.0))
