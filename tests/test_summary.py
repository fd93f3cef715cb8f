"""The closing words: a run whose coupling created energy does not end like a good one."""

from __future__ import annotations

import pytest

from orchestrator.summary import closing_lines


@pytest.mark.parametrize(("created_J", "warned"), [(-0.05, False), (0.2, True), (-0.2, True)])
def test_energy_created_is_warned_of(created_J: float, warned: bool) -> None:
    ledger = {"supplied.frames.exciter": 9.0, "lost.panel.panel_damping": 1.0}
    summary = {
        "energy_ledger_J": ledger | {"created.particles-panel": created_J},
        "momentum_residual_relative": 1e-13,
        "simulated_s": 0.5,
        "sync_intervals": 100,
        "particles": 0,
    }
    assert any("WARNING" in line for line in closing_lines(summary)) is warned
