"""Figures of a run do not depend on how often it writes: they come from sync points, or there is a
reason why there are none."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from tests.runs.outside import QUICK, flipflow, has_results, run_words, summary

pytestmark = [pytest.mark.process, pytest.mark.slow]
OFTEN = ("output.interval_s=0.004", "output.series_s=0")
OUTPUT_ONCE_A_CYCLE = ("output.interval_s=0.08", "output.series_s=0")
ALL_ONCE_A_CYCLE = ("output.interval_s=0.08", "output.series_s=0.08")


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """A panel between clamps that move, slack and taut: the same run written often and seldom."""
    made = {}
    kinds = {"often": OFTEN, "unseen": OUTPUT_ONCE_A_CYCLE, "seldom": ALL_ONCE_A_CYCLE}
    for name, sets in kinds.items():
        folder = tmp_path_factory.mktemp(name) / "run"
        done = flipflow(*run_words("panel-cycle", folder, [*QUICK, "duration_s=0.32", *sets]))
        assert done.returncode == 0, done.stderr
        has_results(folder)
        made[name] = summary(folder)
    return made


def test_amplitudes_and_peaks_of_probes_are_the_same(runs: dict[str, dict[str, Any]]) -> None:
    often, seldom = (runs[name]["probes"] for name in ("often", "seldom"))
    assert seldom == often
    assert often["moving"]["half_range_m"][0] == pytest.approx(0.0059, rel=1e-4)
    assert often["middle"]["half_range_m"][2] > 0.02


def test_pull_and_stretch_are_the_same(runs: dict[str, dict[str, Any]]) -> None:
    often, seldom = (runs[name]["results"]["motion"] for name in ("often", "seldom"))
    assert seldom["panels"] == often["panels"]
    assert often["panels"]["deck"]["stretch_largest_percent"] > 1.9


def test_what_rows_must_tell_is_refused(runs: dict[str, dict[str, Any]]) -> None:
    often, seldom = (runs[name]["results"] for name in ("often", "seldom"))
    assert often["motion"]["frames"]
    assert often["motion"]["panel_points"]
    assert seldom["motion"]["frames"] == seldom["motion"]["panel_points"] == {}
    for part in ("orbits", "panel acceleration"):
        assert "output.series_s" in seldom["missing"][part]


def test_effects_are_judged_by_the_same_shapes_or_not_at_all(runs: dict[str, dict[str, Any]]) -> None:
    """A panel that snaps through has no travel if it is seen at one phase only."""
    often, unseen, seldom = (runs[name]["effects"] for name in ("often", "unseen", "seldom"))
    judged = [name for name, effect in often.items() if effect["after"] is not None]
    assert judged
    assert {name: unseen[name]["after"] for name in judged} == {name: often[name]["after"] for name in judged}
    assert {name: seldom[name]["after"] for name in judged} == dict.fromkeys(judged)


def test_the_followed_ball_is_not_told_by_rows_that_miss_it(tmp_path: Path) -> None:
    sets = [*QUICK, "duration_s=0.05", "output.series_s=0.01", "output.interval_s=0.01"]
    done = flipflow(*run_words("ball-on-panel", tmp_path / "run", sets))
    assert done.returncode == 0, done.stderr
    ball = summary(tmp_path / "run")["probes"]["ball"]
    assert "output.series_s of at most 5e-05 s" in ball["reason"]
    assert ball["peak_m"] is None
