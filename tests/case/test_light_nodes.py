"""The contact damper on a light node: the warning, and the instability that it warns of."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from orchestrator.casefile.levels import load
from orchestrator.checks.light_nodes import light_nodes
from orchestrator.commands.launch import run

CASE = Path("cases/ball-on-panel")
# finite elements and triangles share their corners, and the ball lands on one of them
COARSE_AND_LIGHT = ["panel.cells=[22,12]", "panel.surface_cells=[22,12]"]


@pytest.mark.parametrize(("overrides", "warned"), [([], False), (COARSE_AND_LIGHT, True)])
def test_warned_where_corners_coincide(overrides: list[str], warned: bool) -> None:
    found = list(light_nodes(load(CASE, "default", overrides).case))
    assert bool(found) is warned
    assert all("surface_cells" in line for line in found)


@pytest.mark.parametrize("case", ["quickstart", "panel-cycle", "empty-machine"])
def test_the_other_cases_are_within_the_limit(case: str) -> None:
    assert not list(light_nodes(load(Path("cases") / case).case))


@pytest.mark.solver
@pytest.mark.slow
@pytest.mark.parametrize(("overrides", "stable"), [([], True), (COARSE_AND_LIGHT, False)])
def test_the_warning_is_true(tmp_path: Path, overrides: list[str], stable: bool) -> None:
    """Energy created by the coupling against the 4.7 mJ with which the ball lands: below 1 %
    where there is no warning, above 10 % where there is one."""
    short = ["duration_s=0.15", "output.pictures=false", "output.interval_s=0.05"]
    assert run(CASE, "default", tmp_path / "run", [*overrides, *short]) == 0
    ledger = json.loads((tmp_path / "run" / "summary.json").read_text())["energy_ledger_J"]
    created = abs(ledger["created.particles-panel"]) / 4.7e-3
    assert created < 0.01 if stable else created > 0.1
