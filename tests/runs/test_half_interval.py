"""A shorter interval is tried before it is advised."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from orchestrator.cli import launch
from orchestrator.run.trials.half_interval import try_half
from tests.runs.outside import ROOT

SETS = ["monitor.created_energy=warn", "coupling.scheme=particles-first", "output.pictures=false"]
SETS += ["output.interval_s=0.02"]


@pytest.mark.parametrize(
    ("interval_s", "message"),
    [
        (3e-4, "with coupling.sync_interval_s = 0.00015, half of the run's, to 0.3 s, the run ends done, "),
        (6e-4, "a shorter interval helps, and half is not enough"),
        (2e-3, "half the interval helps little"),
    ],
)
def test_an_advice_is_tried(tmp_path: Path, interval_s: float, message: str) -> None:
    """The ball on the panel: 1.3, 6.3 and 26 % of the energy; 0.4, 1.3 and 19 % at half the interval."""
    folder = tmp_path / "run"
    sets = [*SETS, f"coupling.sync_interval_s={interval_s!r}"]
    assert launch.run(ROOT / "cases/ball-on-panel", "draft", folder, sets) == 5
    (line,) = try_half(folder, 60.0)
    assert line.startswith("tried: ")
    assert message in line
    (line,) = try_half(folder, 1e-3)
    assert line.startswith(f"not tried: coupling.sync_interval_s = {interval_s / 2:.4g}, ")


def test_what_advises_nothing_is_not_tried(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    sets = [*SETS, "duration_s=0.02"]
    assert launch.run(ROOT / "cases/ball-on-panel", "draft", folder, sets) == 0
    assert not list(try_half(folder, 60.0))
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps(summary | {"doubts": ["Particles overlap."]}))
    assert not list(try_half(folder, 60.0))
