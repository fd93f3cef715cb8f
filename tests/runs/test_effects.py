"""A run with ``effects``: what is said of them at its start, at its end and in its folder, and that
the folder's case gives the same run without the key."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.runs.outside import QUICK, flipflow, run_words

NAMED = '["frame-dynamics", "frame-motion", "panel-reaction", "bushing-damping", "run-up"]'


@pytest.mark.process
def test_what_effects_leave_out_is_said_and_looked_at_after_the_run(tmp_path: Path) -> None:
    """The empty machine for two cycles with rigid panels: their stroke says what they would sag."""
    sets = [*QUICK, f"effects={NAMED}", "duration_s=0.165"]
    run, again = tmp_path / "run", tmp_path / "again"
    done = flipflow(*run_words("empty-machine", run, sets))
    assert done.returncode == 0, done.stderr
    started = (
        "left out: panel-deformation: panel.solver rigid: panels stay flat; "
        "effects does not name it; matters: throw of panel / of frame"
    )
    ended = "left out: large-deflection; by the run sag / thickness"
    log = (run / "run.log").read_text()
    for text in (done.stderr, log):
        assert started in text
        assert ended in text

    effects = json.loads((run / "summary.json").read_text())["effects"]
    sag = effects["large-deflection"]
    assert sag["left_out"] == "it needs panel-deformation, which is left out"
    assert (sag["before"]["matters"], sag["after"]["matters"], sag["crossed"]) == (True, True, False)
    assert effects["frame-dynamics"]["present"]
    assert not effects["panel-deformation"]["present"]

    resolved = tomllib.loads((run / "case.toml").read_text())
    assert "effects" not in resolved
    assert resolved["panel"]["solver"] == "rigid"
    assert flipflow(*run_words(str(run), again, [])).returncode == 0
    with h5py.File(run / "history.h5") as first, h5py.File(again / "history.h5") as second:
        path = "frames/driven/displacement_m"
        np.testing.assert_array_equal(first[path][:], second[path][:])


@pytest.mark.process
def test_a_run_that_contradicts_what_was_left_out_before_it_is_doubtful(tmp_path: Path) -> None:
    """Adhesion that shaking overcomes, and a machine that has hardly begun to shake when the run
    ends: "auto" leaves it out, and the run, its summary and its exit code say that it should not
    have."""
    sticky = [
        "contacts.0.work_of_adhesion_J_per_m2=4.0",
        'effects="auto"',
        "screen.exciters.shaft.run_up_s=20",
        "bed.blocks.coal.count=100",
        "duration_s=0.2",
    ]
    done = flipflow(*run_words("quickstart", tmp_path / "run", [*QUICK, *sticky]))
    assert done.returncode == 5, done.stderr
    assert "WARNING: adhesion, which is left out, matters by the run" in done.stderr
    summary = json.loads((tmp_path / "run/summary.json").read_text())
    assert summary["status"] == "doubtful"
    assert any("adhesion is left out" in doubt for doubt in summary["doubts"])
    assert summary["effects"]["adhesion"]["crossed"]
