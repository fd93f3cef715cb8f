"""The quantities by which models are compared, and the models that a case has, without any run."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.quantities import Metrics, relative
from orchestrator.ports import Array
from orchestrator.ports.clock import exact
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.cost import predicted_s
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.refinement import offer
from orchestrator.studies.accuracy.combinations import ALONE, EXACT, Combination, Error, Scatter, errors
from orchestrator.studies.points import sampling_sets
from tests.runs.outside import ROOT


def measured(deflection_m: float, shapes_m: Array) -> Combination:
    values = {"deflection_m": deflection_m, "frame_half_range_m": 0.0}
    return Combination(ALONE, "one", metrics=(Metrics(values, shapes_m, {}),))


def test_errors_are_relative_to_the_reference() -> None:
    """A sine of 10 % more amplitude is 10 % off about its mean; what is zero has no error."""
    wave = np.sin(np.linspace(0, 2 * np.pi, 200, endpoint=False))[:, None] + 5.0
    wrong = errors(measured(1.1, 1.1 * (wave - 5.0) + 5.0), measured(1.0, wave), EXACT)
    assert wrong == {name: Error(pytest.approx(0.1)) for name in ("deflection_m", "shape")}
    assert relative(wave, wave) == 0.0


def test_chance_may_be_all_of_a_difference_in_shape() -> None:
    wrong = errors(measured(1.0, np.eye(3)), measured(1.0, np.eye(3)), Scatter(True, {}, {}))
    assert wrong["shape"] == Error(0.0, None)


def test_shapes_of_other_grids_are_not_compared() -> None:
    wrong = errors(measured(1.0, np.ones((3, 2))), measured(1.0, np.ones((3, 4))), EXACT)
    assert "shape" not in wrong


MODELS = ("panel-mesh", "panel-model", "frames-model", "particles-model")


@pytest.mark.parametrize("name", ["empty-machine", "quickstart", "panel-cycle"])
def test_each_model_is_one_part_away_and_better_ones_are_dearer(name: str) -> None:
    """Every model that can be run at once is a right case, or says what is wrong; among panels that deform
    the prediction grows from a model to a better one.  (A rigid panel is not compiled, so it costs about as
    much as a strip.)"""
    base = load_judged(ROOT / "cases" / name, "default").case
    there = offer(base, MODELS, 3)
    costs = {}
    for series in there.series:
        for setting in series.settings:
            assert all(key.startswith(f"{series.axis}.") for key in setting.sets)
            if not setting.needs_drives:
                loaded = load_judged(ROOT / "cases" / name, "default", setting.sets)
                problems = find_problems(loaded)
                assert not problems or series.variant == "two-mass", problems  # drives
                if series.axis == "panel" and series.variant != "rigid":
                    costs[series.rank, series.settings.index(setting)] = predicted_s(loaded.case, 0)
    best = {rank: cost_s for (rank, place), cost_s in sorted(costs.items())}
    assert list(best.values()) == sorted(best.values())


def test_drives_are_made_from_the_run_as_it_is() -> None:
    base = load_judged(ROOT / "cases/empty-machine", "default").case
    there = offer(base, MODELS, 3)
    assert [s.label for each in there.series for s in each.settings if s.needs_drives] == ["prescribed"]
    assert not any(each.is_choice for each in there.series if each.variant in ("prescribed", "none"))


@pytest.mark.solver
def test_the_solid_is_a_model_where_openings_have_square_corners() -> None:
    """Dearer than without openings, as its cells are more; refused for round ends."""
    folder = ROOT / "cases/panel-cycle"
    there = offer(load_judged(folder, "default").case, ("panel-model",), 3)
    (solid,) = (each.settings[-1] for each in there.series if each.variant == "solid")
    pattern = "length_m=0.02, width_m=0.005, pitch_along_m=0.03, pitch_across_m=0.01"
    openings = f"screen.panels.deck.apertures={{{pattern}}}"
    slots = f"screen.panels.deck.apertures={{{pattern}, shape='slot'}}"
    resolved = load_judged(folder, "default", [*solid.sets, openings])
    assert find_problems(resolved) == []
    whole_s = predicted_s(load_judged(folder, "default", solid.sets).case, 0)
    assert predicted_s(resolved.case, 0) > whole_s
    (refused,) = find_problems(load_judged(folder, "default", [*solid.sets, slots]))
    assert "follow no round ends" in str(refused)


def test_rows_come_at_whole_sync_intervals() -> None:
    interval_s = load_judged(ROOT / "cases/quickstart", "default").case.coupling.sync_interval_s
    every_s = float(sampling_sets(interval_s)[0].partition("=")[2])
    assert exact(every_s) % exact(interval_s) == 0
    assert every_s < 1 / 2 / 500  # accelerations to 500 Hz
