"""Effects of what comes, goes and lies around: each deciding number against a value worked out by
hand, and what follows from it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.case.cases import loaded
from tests.effects.verdicts import EXITS, TILTED, by_name, verdict


def test_share_of_the_bed_that_passes_in_the_run(tmp_path: Path) -> None:
    """A deck of 0.302 m at 0.34 m/s takes 0.888 s; the run has 0.1 s."""
    feed = verdict(tmp_path, "feed", TILTED, EXITS)
    assert feed.verdict.value == pytest.approx(0.1 * 0.34 / 0.302, rel=1e-6)
    assert feed.lacking
    assert verdict(tmp_path, "removal", TILTED, EXITS).present
    assert verdict(tmp_path, "removal", TILTED).lacking
    assert verdict(tmp_path, "feed", TILTED, EXITS, "duration_s=0.05").verdict.matters is False
    assert verdict(tmp_path, "feed").verdict.matters is None, "a level deck"


def test_gravity_is_always_needed_here(tmp_path: Path) -> None:
    assert verdict(tmp_path, "gravity").present
    assert verdict(tmp_path, "gravity", "gravity_m_s2=[0, 0, 0]").lacking


def test_a_slice_against_the_largest_particle(tmp_path: Path) -> None:
    found = verdict(tmp_path, "full-width", "slice={width_m=0.15}")
    assert found.verdict.value == pytest.approx(7.5)
    assert found.verdict.matters is None
    assert verdict(tmp_path, "full-width", "slice={width_m=0.08}").lacking
    assert "full-width" not in by_name(loaded(tmp_path))
