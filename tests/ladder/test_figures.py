"""What a ladder measures, on figures and rungs that are known without any run."""

from __future__ import annotations

import numpy as np
import pytest
from orchestrator.studies.sampling import sampled_at

from orchestrator.ports import Array
from orchestrator.ports.clock import exact
from orchestrator.preflight.check import mistakes
from orchestrator.preflight.cost import predicted_s
from orchestrator.preflight.levels import load
from orchestrator.studies.figures import Figures, errors, relative
from orchestrator.studies.ladder.rungs import rungs
from tests.runs.outside import ROOT


def measured(deflection_m: float, shapes_m: Array) -> Figures:
    values = {"deflection_m": deflection_m, "frame_m": 0.0}
    return Figures(values, {}, {}, shapes_m, None, 1.0, 1.0, {}, 100.0, 1.0)


def test_errors_are_relative_to_the_reference() -> None:
    """A sine of 10 % more amplitude is 10 % off about its mean; what is zero has no error."""
    wave = np.sin(np.linspace(0, 2 * np.pi, 200, endpoint=False))[:, None] + 5.0
    found = errors(measured(1.1, 1.1 * (wave - 5.0) + 5.0), measured(1.0, wave))
    assert found == {"deflection_m": pytest.approx(0.1), "shape": pytest.approx(0.1)}
    assert relative(wave, wave) == 0.0


def test_shapes_of_other_grids_are_not_compared() -> None:
    found = errors(measured(1.0, np.ones((3, 2))), measured(1.0, np.ones((3, 4))))
    assert "shape" not in found


@pytest.mark.parametrize("name", ["empty-machine", "quickstart", "panel-cycle"])
def test_each_rung_is_one_key_away_and_the_last_is_the_dearest(name: str) -> None:
    """Every rung that can be run at once is a right case, or says what is wrong; among panels the
    prediction grows from sheet to sheet to solid."""
    base = load(ROOT / "cases" / name, "default").case
    for ladder in ("panel", "frames", "particles"):
        costs = []
        for rung in rungs(base, ladder):
            assert all(key.startswith(f"{ladder}.") for key in rung.sets)
            if not rung.needs:
                loaded = load(ROOT / "cases" / name, "default", rung.sets)
                found = mistakes(loaded)
                refused = {"two-mass", "planar", "coarser"}  # drives, turned parts, openings
                assert not found or rung.name in refused, found
                costs.append(predicted_s(loaded.case, 0))
        if ladder == "panel":
            assert costs[-4:] == sorted(costs[-4:])


@pytest.mark.solver
def test_the_solid_is_a_rung_where_openings_have_square_corners() -> None:
    """Dearer than without openings, as its cells are more; refused for round ends."""
    folder = ROOT / "cases/panel-cycle"
    solid = rungs(load(folder, "default").case, "panel")[-1]
    pattern = "length_m=0.02, width_m=0.005, pitch_along_m=0.03, pitch_across_m=0.01"
    openings = f"screen.panels.deck.apertures={{{pattern}}}"
    slots = f"screen.panels.deck.apertures={{{pattern}, shape='slot'}}"
    resolved = load(folder, "default", [*solid.sets, openings])
    assert mistakes(resolved) == []
    whole_s = predicted_s(load(folder, "default", solid.sets).case, 0)
    assert predicted_s(resolved.case, 0) > 2 * whole_s
    (refused,) = mistakes(load(folder, "default", [*solid.sets, slots]))
    assert "follow no round ends" in str(refused)


def test_rows_come_at_whole_sync_intervals() -> None:
    interval_s = load(ROOT / "cases/quickstart", "default").case.coupling.sync_interval_s
    every_s = float(sampled_at(interval_s)[0].partition("=")[2])
    assert exact(every_s) % exact(interval_s) == 0
    assert every_s < 1 / 2 / 500  # accelerations to 500 Hz
