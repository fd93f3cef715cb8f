"""Events between two output times are seen, however far they lie apart."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.cli import launch
from tests.runs.outside import ROOT, summary

# in every turn the first panel of the empty machine swings 4 to 8 mm through this plate
PLATE = (
    "screen.surfaces.plate={corner_m=[0.05, 0.02, -0.024], edges_m=[[0.2, 0, 0], [0, 0.16, 0]], "
    'frame="ground", material="PU"}'
)


@pytest.mark.parametrize("interval_s", ["0.08", "0.002"])
def test_a_panel_that_goes_through_a_plate_stops_the_run(interval_s: str, tmp_path: Path) -> None:
    numerics = ["coupling.sync_interval_s=2e-4", "panel.cells=[22,1]"]
    sets = [PLATE, *numerics, f"output.interval_s={interval_s}", "output.pictures=false", "duration_s=0.4"]
    code = launch.run(ROOT / "cases/empty-machine", "draft", tmp_path / "run", sets)
    assert code == launch.FAILED
    about = summary(tmp_path / "run")
    assert "panel deck-1 has gone through plate" in about["reason"]
    assert about["monitor"]["figures"]["penetrated_surfaces"]["first_s"] == 0.224  # the same for both
