"""A real run of spheres, from the feed to the results: they agree with the run's own books."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.cases import case_folder
from tests.results.small_screen import CASE
from tests.runs.outside import flipflow, run_words, summary

DURATION_S = 1.5  # 30 cycles, some 30 particles
NONE_JUMPS_OUT = "bed.feeds.chute.seed=2"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("screen")
    case_folder(place / "case", CASE)
    words = run_words(str(place / "case"), place / "run", [f"duration_s={DURATION_S}", NONE_JUMPS_OUT])
    done = flipflow(*words)
    assert done.returncode == 0, done.stderr
    return place / "run"


@pytest.fixture(scope="module")
def run_results(folder: Path) -> dict[str, Any]:
    results: dict[str, Any] = summary(folder)["results"]
    return results


@pytest.mark.process
@pytest.mark.slow
def test_the_small_pass_and_the_large_do_not(folder: Path, run_results: dict[str, Any]) -> None:
    """The shares are counted by hand from the event table."""
    with h5py.File(folder / "history.h5") as history:
        removed = {name: series[:] for name, series in history["removed"].items()}
    mass = np.pi / 6 * removed["sieve_size_m"] ** 3 * removed["density_kg_per_m3"]
    fine, passed = removed["sieve_size_m"] < 0.02, removed["exit"] == 0
    assert passed.sum() > 5
    recovery = 100 * mass[fine & passed].sum() / mass[fine].sum()
    assert recovery > 50
    assert not (passed & ~fine).any()
    screening = run_results["screening"]
    assert screening["fine_placement_percent"]["value"] == pytest.approx(recovery)
    assert screening["efficiency_percent"]["value"] == pytest.approx(recovery)
    with h5py.File(folder / "history.h5") as history:
        fed = {name: series[:] for name, series in history["fed"].items()}
    fed_kg = np.pi / 6 * fed["sieve_size_m"] ** 3 * fed["density_kg_per_m3"]
    of_all = 100 * mass[fine & passed].sum() / fed_kg[fed["sieve_size_m"] < 0.02].sum()
    assert of_all < recovery - 0.1
    assert screening["recovered_percent"]["value"] == pytest.approx(of_all)
    assert screening["lost_particles"] == 0


@pytest.mark.process
@pytest.mark.slow
def test_the_books_agree(folder: Path, run_results: dict[str, Any]) -> None:
    book = summary(folder)["material"]
    flows = run_results["screening"]["in_time"]
    assert flows["hold_up_kg"][-1] == pytest.approx(book["on_deck"]["mass_kg"], rel=1e-9)
    fed_kg = np.sum(flows["feed_kg_per_s"]) * DURATION_S / len(flows["feed_kg_per_s"])
    assert fed_kg == pytest.approx(book["fed"]["mass_kg"], rel=1e-9)
    gap = book["exits"]["gap"]["mass_kg"]
    assert run_results["screening"]["undersize_kg_per_s"]["value"] == pytest.approx(gap / DURATION_S)


@pytest.mark.process
@pytest.mark.slow
def test_it_is_too_short_to_be_steady(run_results: dict[str, Any]) -> None:
    assert not run_results["steady"]["is_steady"]
    assert run_results["steady"]["reason"]
    assert run_results["screening"]["efficiency_percent"]["half_width"] is None


@pytest.mark.process
@pytest.mark.slow
def test_the_bed_along_the_deck(folder: Path, run_results: dict[str, Any]) -> None:
    """The profile holds what lies on the deck; particles pass where the gap is, at 0.20 to 0.23 m,
    and speed up downhill."""
    with h5py.File(folder / "history.h5") as history:
        on_deck = history["profile/mass_kg"][:].sum(axis=1)
        present = history["bed/mass_kg"][:]
        assert (on_deck <= present * (1 + 1e-12)).all()
        assert on_deck.mean() > 0.4 * present.mean()
    passing = run_results["transport"]["passing"]
    rate, along = np.array(passing["rate_kg_per_s_m"]), np.array(passing["along_m"])
    assert 0.18 < rate @ along / rate.sum() < 0.28
    assert run_results["transport"]["residence_velocity_m_per_s"]["value"] > 0.1
    velocity = [v for v in run_results["bed"]["profile"]["velocity_m_per_s"] if v is not None]
    assert velocity[-1] > velocity[0] > 0.0


@pytest.mark.process
@pytest.mark.slow
def test_the_drive_is_found_again(run_results: dict[str, Any]) -> None:
    """1 mm along and 0.5 mm normal to the deck, at 20 Hz: 1.8 g."""
    frame = run_results["motion"]["frames"]["corner"]
    assert frame["amplitude_m"] == pytest.approx([0.001, 0.0, 0.0005], abs=1e-7)
    point = run_results["motion"]["panel_points"]["middle"]
    peak = 0.001118 * (40 * np.pi) ** 2 / 9.80665
    assert point["peak_g"] == pytest.approx(peak, rel=0.01)
    assert point["peak_normal_g"] == pytest.approx(0.0005 * (40 * np.pi) ** 2 / 9.80665, rel=0.01)
