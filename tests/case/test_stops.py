"""Beams below panels in the case: what is planned of them, and what is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.case.solver_plans import panel_plans
from tests.cases import complaints, loaded, only_complaint

FLANGE = "screen.panels.deck.stops.flange={from_m=0.0, to_m=0.04, gap_m=0.003}"
FAR = "screen.panels.deck.stops.flange={from_m=0.26, to_m=0.3, gap_m=0.003}"
ROW = ("screen.panels.deck.count=2", "screen.panels.deck.pitch_m=0.4")
AREAL_KG_M2 = 1150.0 * 0.004


def test_none_without(tmp_path: Path) -> None:
    assert panel_plans(loaded(tmp_path).case)[0].stops == ()


def test_the_usual_layer_by_hand(tmp_path: Path) -> None:
    """q = 0.1 at the sync interval; a fifth of the critical damping."""
    case = loaded(tmp_path, [FLANGE, "coupling.sync_interval_s=1e-4"]).case
    (stop,) = panel_plans(case)[0].stops
    assert stop.stiffness_Pa_per_m == pytest.approx(0.1 * AREAL_KG_M2 / 1e-8)
    critical = 2 * (stop.stiffness_Pa_per_m * AREAL_KG_M2) ** 0.5
    assert stop.damping_Pa_s_per_m == pytest.approx(0.2 * critical)


@pytest.mark.parametrize(("given", "frames"), [(FLANGE, ["driving", "ground"]), (FAR, ["ground", "driving"])])
def test_a_stop_belongs_to_the_nearer_clamps_beam(tmp_path: Path, given: str, frames: list[str]) -> None:
    case = loaded(tmp_path, [given, *ROW]).case
    assert [plan.stops[0].frame for plan in panel_plans(case)] == frames


def test_a_named_frame_carries_all(tmp_path: Path) -> None:
    named = "screen.panels.deck.stops.flange.frame=ground"
    case = loaded(tmp_path, [FLANGE, named, *ROW]).case
    assert [plan.stops[0].frame for plan in panel_plans(case)] == ["ground", "ground"]


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("to_m", "0.4", "beyond the free length of 0.3 m"),
        ("from_m", "0.05", "is not before to_m"),
        ("stiffness_Pa_per_m", "1e12", "at most"),
        ("frame", "drivng", "driving"),
    ],
)
def test_what_is_refused(tmp_path: Path, key: str, value: str, message: str) -> None:
    place = f"screen.panels.deck.stops.flange.{key}"
    complaint = only_complaint(tmp_path, FLANGE, f"{place}={value}")
    assert place in complaint
    assert message in complaint


def test_a_right_one_is_not(tmp_path: Path) -> None:
    assert complaints(tmp_path, FLANGE) == []
