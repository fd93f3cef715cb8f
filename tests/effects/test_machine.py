"""Effects of what comes, goes and lies around: each deciding number against a value worked out by
hand, and what follows from it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cases import loaded
from tests.effects.verdicts import EXITS, TILTED, by_name, verdict


def test_share_of_the_bed_that_passes_in_the_run(tmp_path: Path) -> None:
    """A deck of 0.302 m; the bed is carried with 0.113 m/s at least, and with 1.6 m/s at most, as
    fast as the panels' middles: in 0.1 s nobody can say, in 1 s some leaves, in 5 ms nothing."""
    feed = verdict(tmp_path, "feed", TILTED, EXITS)
    assert feed.verdict.value == pytest.approx(0.1 * 1.63 / 0.302, rel=0.01)
    assert "4% to 54% of the bed" in feed.verdict.why
    assert feed.verdict.matters is None
    assert verdict(tmp_path, "removal", TILTED, EXITS).present
    assert verdict(tmp_path, "feed", TILTED, "duration_s=1.0").is_lacking
    assert verdict(tmp_path, "removal", TILTED, "duration_s=1.0").is_lacking
    assert verdict(tmp_path, "feed", TILTED, EXITS, "duration_s=0.005").verdict.matters is False
    assert verdict(tmp_path, "feed").verdict.matters is None, "a level deck"


def test_gravity_is_always_needed_here(tmp_path: Path) -> None:
    assert verdict(tmp_path, "gravity").present
    assert verdict(tmp_path, "gravity", "gravity_m_per_s2=[0, 0, 0]").is_lacking


def test_a_slice_against_the_largest_particle(tmp_path: Path) -> None:
    judged = verdict(tmp_path, "full-width", "slice={width_m=0.15}")
    assert judged.verdict.value == pytest.approx(7.5)
    assert judged.verdict.matters is None
    assert verdict(tmp_path, "full-width", "slice={width_m=0.08}").is_lacking
    assert "full-width" not in by_name(loaded(tmp_path))
