"""The closing words: a run whose coupling created energy does not end like a good one."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from orchestrator.cli.launch import run
from orchestrator.output.cycles import cycle_s
from orchestrator.output.records import trust
from orchestrator.output.records.summary import closing_lines, iteration_lines, monitor_lines
from tests.cases import case_folder, loaded
from tests.runs.outside import summary


@pytest.mark.parametrize(("created_J", "doubtful"), [(-0.05, False), (0.2, True), (-0.2, True)])
def test_a_run_whose_coupling_created_energy_is_doubtful(created_J: float, doubtful: bool) -> None:
    ledger = {"lost.particles.contact_dissipation": 1.0, "created.particles-panel": created_J}
    summary: dict[str, Any] = {"energy_ledger_J": ledger, "results": {}}
    summary["energy_exchanged_J"] = {"particles-panel": 9.0}
    summary["doubts"] = trust.doubts(summary)
    assert bool(summary["doubts"]) is doubtful
    assert trust.state_at_end(summary) == ("doubtful" if doubtful else "done")


@pytest.mark.parametrize(("times", "doubtful"), [(0, False), (3, True)])
def test_a_run_in_which_a_panel_went_through_a_surface_is_doubtful(times: int, doubtful: bool) -> None:
    figure = {"worst": 4.7, "limit": 0.5, "times": times, "first_s": 0.02 if times else None}
    summary = {"energy_ledger_J": {}, "monitor": {"figures": {"penetrated_surfaces": figure}}}
    doubts = trust.doubts(summary)
    assert bool(doubts) is doubtful
    assert all("t = 0.02 s on a panel went through a surface, by up to 4.7" in doubt for doubt in doubts)


@pytest.mark.parametrize(
    ("left_out", "crossed", "matters", "doubtful"),
    [
        ("auto", True, True, True),
        ("auto", False, True, False),
        ("", True, True, False),
        ("auto", True, False, False),
    ],
)
def test_a_run_that_contradicts_what_was_left_out_of_it_is_doubtful(
    left_out: str, crossed: bool, matters: bool, doubtful: bool
) -> None:
    """The run is not doubtful where the effect is there, nor where it says that it may be left out after
    all."""
    after = {"number": "throw", "value": 0.31234, "threshold": "0.1", "matters": matters}
    entry = {"left_out": left_out, "crossed": crossed, "before": {}, "after": after}
    summary = {"energy_ledger_J": {}, "effects": {"adhesion": entry}, "results": {}}
    summary["doubts"] = trust.doubts(summary)
    assert trust.state_at_end(summary) == ("doubtful" if doubtful else "done")
    if doubtful:
        (doubt,) = summary["doubts"]
        assert "adhesion is left out, and the run shows that it matters: throw is 0.312" in doubt


def test_a_run_without_results_is_incomplete() -> None:
    assert trust.state_at_end({"doubts": []}) == "incomplete"


@pytest.mark.parametrize(("unsolved", "lines"), [(0, 1), (3, 2)])
def test_repeated_intervals_are_told_and_unsolved_ones_warned_of(unsolved: int, lines: int) -> None:
    iterations = {"mean": 2.5, "most": 20, "unsolved": unsolved, "worst": 0.0123}
    texts = iteration_lines(iterations)
    assert texts[0] == "intervals run 2.50 times on average, 20 at most"
    assert len(texts) == lines
    assert texts[1:] == [text for text in texts if text.startswith("WARNING: 3 ") and "0.012" in text]


@pytest.mark.parametrize("intervals", [0, 12])
def test_intervals_run_in_parts_are_warned_of(intervals: int) -> None:
    watch = {
        "shortened_intervals": intervals,
        "shortened_share": intervals / 100,
        "shortest_interval_s": 2.5e-5,
    }
    texts = ["the monitor ran 12 sync intervals (12 %) in parts, down to 2.5e-05 s"]
    assert [line[9:].split(";")[0] for line in monitor_lines(watch)] == texts[: bool(intervals)]


@pytest.mark.parametrize(
    ("share", "results", "where"),
    [
        (1.0, {"slice_width_m": None}, ""),
        (0.0525, {"slice_width_m": 0.126}, " in the slice of 126 mm"),
        (0.0525, {}, " in the slice of 5.25 % of the width"),
        (0.0525, None, " in the slice of 5.25 % of the width"),
    ],
)
def test_the_balance_of_particles_names_the_slice(
    share: float, results: dict[str, Any] | None, where: str
) -> None:
    """Its masses are not scaled, as those of the headline are.  Results may be missing, or have no width."""
    some: dict[str, Any] = {"number": 3, "mass_kg": 0.25}
    none: dict[str, Any] = {"number": 0, "mass_kg": 0.0}
    material = {"fed": some, "on_deck": some, "lost": none, "escaped": none, "exits": {}, "crossings": none}
    material["deepest_overlaps"] = {"surface_per_diameter": 0.01, "between_per_diameter": 0.02}
    summary = {
        "simulated_s": 1.0,
        "sync_intervals": 10,
        "particles": 0,
        "momentum_residual_relative": 1e-13,
        "energy_ledger_J": {"created.particles-panel": 0.0},
        "energy_exchanged_J": {"particles-panel": 1.0},
        "share_of_width": share,
        "material": material,
        "results": results,
    }
    (balance,) = [line for line in closing_lines(summary) if line.startswith("particles")]
    assert balance == f"particles{where}: came 0.25 kg (3) = on deck 0.25 kg (3) + lost 0 kg (0)"


@pytest.mark.slow
def test_a_run_of_half_the_width_says_so(tmp_path: Path) -> None:
    """Results of the whole width are divided by it."""
    case = case_folder(tmp_path / "case")
    sets = ["slice.width_m=0.1", "particles.solver=none", "panel.solver=rigid", "frames.solver=two-mass"]
    assert run(case, None, tmp_path / "run", [*sets, "duration_s=0.002", "output.pictures=false"]) == 0
    assert summary(tmp_path / "run")["share_of_width"] == pytest.approx(0.5)


def test_the_cycle_is_that_of_the_slowest_that_moves(tmp_path: Path) -> None:
    drive = "screen.frames.driving.drive={speed_rad_per_s=90, amplitude_m=[0.01, 0, 0]}"
    for given, speed_rad_per_s in (
        ([], 78.5),
        ([drive], 78.5),
        ([drive, "screen.exciters.shaft.speed_rad_per_s=100"], 90.0),
        ([drive, "frames.solver=prescribed"], 90.0),
    ):
        assert cycle_s(loaded(tmp_path, given).case) == pytest.approx(2 * math.pi / speed_rad_per_s)
