"""A drive without run-up seizes panels that are at rest: the blow is the drive's, and no coupling's."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.cli import launch
from orchestrator.coupling.ledger import share_created
from tests.cases import load_case, polyurethane
from tests.coupled.machines import opened
from tests.runs.outside import ROOT, summary

SPEED_M_PER_S = 0.005 * 80.0
SHAKEN = f"""
title = "a panel that its frame seizes"
duration_s = 0.1
domain_m = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]
gravity_m_per_s2 = [0.0, 0.0, 0.0]
{polyurethane()}
[screen.frames.base.drive]
amplitude_m = [0.005, 0.0, 0.0]
speed_rad_per_s = 80.0

[screen.panels.deck]
material = "PU"
frames = ["base", "base"]
corner_m = [0.0, 0.0, 0.0]
length_m = 0.3
width_m = 0.2
thickness_m = 0.004
clamp_m = 0.0

[frames]
solver = "prescribed"
[particles]
solver = "none"
"""


@pytest.mark.parametrize("interval_s", [1e-3, 1e-4])
@pytest.mark.parametrize("scheme", ["particles-first", "serial-staggered"])
def test_a_rigid_panel_takes_half_of_the_work(tmp_path: Path, interval_s: float, scheme: str) -> None:
    """0.276 kg at 0.4 m/s: the drive does m v^2, of which half is lost, as in a plastic impact."""
    sets = ["panel.solver=rigid", f"coupling.sync_interval_s={interval_s}", f"coupling.scheme={scheme}"]
    with opened(load_case(tmp_path, SHAKEN, sets)) as run:
        run.advance(2 if scheme == "serial-staggered" else 1)
        run.ledger.book_blow()
        run.advance(2)
        terms_J = run.energy_J("")
    mass_kg = 1150.0 * 0.3 * 0.2 * 0.004
    # the panel slows down within the interval by (w H)^2 / 2, at most 0.3 %, or 1.3 % an interval later
    assert terms_J["lost.frames.blow"] == pytest.approx(mass_kg * SPEED_M_PER_S**2 / 2, rel=0.02)
    left = 80.0 * interval_s  # w H: late loads are of first order
    assert abs(terms_J["created.panel-frames"]) < left * terms_J["lost.frames.blow"]


@pytest.mark.parametrize("interval_s", ["2e-4", "1e-4", "2.5e-5"])
def test_a_run_is_not_doubtful_for_it(tmp_path: Path, interval_s: str) -> None:
    """The first cycle's eighth: the panel is as good as all that is exchanged."""
    sets = ["screen.frames.moving.drive.run_up_s=0", f"coupling.sync_interval_s={interval_s}"]
    sets += ["duration_s=0.01", "output.interval_s=0.005", "output.pictures=false"]
    code = launch.run(ROOT / "cases/panel-cycle", "draft", tmp_path / "run", sets)
    assert code in (launch.DONE, 6)  # too short for some results
    about = summary(tmp_path / "run")
    assert about["energy_ledger_J"]["lost.frames.blow"] > 1e-3
    assert abs(share_created(about)) < 0.01
    assert about["monitor"]["shortened_intervals"] == 0
