"""Every figure of a run's results, computed a second time by other code (``recomputed.py``).

The run has unequal cycles, since neither a sync interval nor an output interval divides a cycle: a motor
turns the shaft.  Its frames turn about three axes, its bushings are turned about three, and lumps pass, blind
and miss the openings of its panels, to which clay sticks.
"""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.figures.short_names import SHORT_NAMES, value_at
from orchestrator.output.results.quantities import MEASURES, measure
from orchestrator.output.results.tidy import single_numbers
from tests.cases import case_folder
from tests.results.recomputed import Recomputed, by_chance, differences
from tests.runs.outside import flipflow, run_words, summary

CASE = (Path(__file__).parent / "unequal_cycles.toml").read_text()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("unequal")
    case_folder(place / "case", CASE)
    done = flipflow(*run_words(str(place / "case"), place / "run", []))
    assert done.returncode == 0, done.stderr
    return place / "run"


@pytest.fixture(scope="module")
def again(folder: Path) -> Recomputed:
    return Recomputed(folder)


@pytest.mark.process
@pytest.mark.slow
@pytest.mark.parametrize("table", ["results", "probes"])
def test_every_figure_is_found_again(folder: Path, again: Recomputed, table: str) -> None:
    """Tolerance: rounding; partition curves and the rate are fitted by other methods, which stop at 1e-5."""
    theirs = summary(folder)[table]
    ours = again.results() if table == "results" else again.probes()
    fits = [each.get("screening", {}).pop("whole_feed", {}) for each in (ours, theirs)]
    assert differences(*fits, tolerance=1e-4) == []
    rates = [each.get("contacts", {}).pop("fit", {}) for each in (ours, theirs)]
    assert differences(*rates, tolerance=1e-5) == []
    assert differences(ours, theirs, tolerance=1e-9) == []


@pytest.mark.process
@pytest.mark.slow
def test_what_passes_is_rebuilt_from_stay_contacts_and_chance(folder: Path) -> None:
    """The share is within two points of what was counted, the fine placement: nothing passes without
    contact."""
    results = summary(folder)["results"]
    why, placement = results["contacts"], results["screening"]["fine_placement_percent"]["value"]
    assert why["counted_percent"] == pytest.approx(placement, abs=1e-9)
    assert why["rebuilt_percent"] == pytest.approx(placement, abs=2.0)


@pytest.mark.process
@pytest.mark.slow
def test_the_figures_have_intervals(again: Recomputed) -> None:
    """The half widths must be there to be compared. The window has some 97 cycles, and five stays are 75.

    The shaft lags, so that ten turns take more than ten cycles.
    """
    assert again.is_steady
    assert again.width is by_chance
    for pair in again.course()["relative"].values():
        assert sum(width is not None for width in pair["half_width_m"]) > len(pair["half_width_m"]) / 2


@pytest.mark.process
@pytest.mark.slow
def test_records_of_cycles_are_those_of_all_their_sync_points(again: Recomputed) -> None:
    """Cycles have 165 or 166 sync points, and the last one is cut.  The line of a panel is rounded at 1e-16 m
    in some metres, over heights of a millimetre."""
    rows = {f"panel_cycles/{name}": again.panel_cycles(name) for name in again.panels}
    rows |= {f"point_cycles/{n}": again.point_cycles(n) for n in (*again.frames, *again.case["probes"])}
    for group, columns in rows.items():
        for name, ours in columns.items():
            theirs = again.data[f"{group}/{name}"]
            assert ours.shape == theirs.shape, (group, name)
            assert np.abs(ours - theirs).max() <= 1e-9 * np.abs(theirs).max(), (group, name)
    assert {165, 166} < {*columns["sync_points"].tolist()}


@pytest.mark.process
@pytest.mark.slow
def test_what_lies_on_the_deck_is_in_the_snapshots(again: Recomputed) -> None:
    """Snapshots have single precision: 1e-4 is far more, and one row may have a grain beside a limit."""
    odd = 0
    for number in again.snapshots:
        for name, value in again.bed_in_time(number).items():
            assert value == pytest.approx(again.data[f"bed/{name}"][number], rel=1e-5, abs=1e-6), name
        for name, ours in again.profile(number).items():
            theirs = again.data[f"profile/{name}"][number]
            odd += not np.allclose(ours, theirs, rtol=1e-4, atol=1e-6, equal_nan=True)
    there = list(again.snapshots)
    for name, held in again.held_in_time().items():
        theirs = again.data[f"held/{name}"][there]
        assert theirs.any(), name
        odd += int(np.sum(~np.isclose(held, theirs, rtol=1e-5)))
    assert odd <= 3


@pytest.mark.process
@pytest.mark.slow
def test_bushings_are_turned_about_x_then_y_then_z(again: Recomputed) -> None:
    """Deformation and force of springs and dampers, from the motion of the frames; to rounding."""
    for name, row, place_m, turn in again.bushings():
        deformation_m, rate_m_per_s = again.deformation(row, place_m, turn)
        theirs_m, theirs_N = (again.data[f"bushings/{name}/{what}"] for what in ("deformation_m", "force_N"))
        assert np.abs(deformation_m - theirs_m).max() < 1e-9 * np.abs(theirs_m).max(), name
        force_N = deformation_m * row["stiffness_N_per_m"] + rate_m_per_s * row["damping_N_s_per_m"]
        assert np.abs(force_N - theirs_N).max() < 1e-9 * np.abs(theirs_N).max(), name


@pytest.mark.process
@pytest.mark.slow
def test_accelerations_follow_from_velocities(again: Recomputed) -> None:
    for name in (*again.frames, *again.case["probes"]):
        theirs = again.data[f"accelerations/{name}/acceleration_m_per_s2"]
        assert np.abs(again.acceleration(name) - theirs).max() < 1e-9 * np.abs(theirs).max()


@pytest.mark.process
@pytest.mark.slow
def test_a_name_has_one_meaning(folder: Path) -> None:
    """Short names, keys of results and quantities of studies: what has one name is one number.

    Where several points have a figure, a mean or the largest of them lies among them.
    """
    table = summary(folder)
    every: dict[str, list[float]] = {}
    for path, value in single_numbers(table["results"]):
        every.setdefault(path.rpartition(".")[2], []).append(value)
    quantities = measure(folder).values
    assert len(quantities) > 9
    for name, value in quantities.items():
        if name in every:
            assert min(every[name]) * 0.999999 <= value <= max(every[name]) * 1.000001, name
    short = {name: value for name in SHORT_NAMES if (value := value_at(table, name)) is not None}
    assert len(short) > 15
    assert not short.keys() & (quantities.keys() | MEASURES.keys())
    for name, number in short.items():
        if name in every:
            assert min(every[name]) * 0.999999 <= number.value <= max(every[name]) * 1.000001, name


DRIVEN = """
title = "a driven base under a mass that an unbalance shakes, too"
duration_s = 1.5
domain_m = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]
[materials]
[screen.frames.base.drive]
speed_rad_per_s = 60.0
amplitude_m = [0.001, 0.0, 0.002]
run_up_s = 0.2
[screen.frames.mass]
mass_kg = 5.0
inertia_kg_m2 = [0.1, 0.1, 0.1]
center_of_mass_m = [0.0, 0.0, 0.1]
[screen.bushings.spring]
between = ["base", "mass"]
positions_m = [[-0.2, 0.0, 0.1], [0.2, 0.0, 0.1]]
stiffness_N_per_m = [4e3, 4e3, 5e3]
damping_N_s_per_m = [60.0, 60.0, 60.0]
[screen.exciters.shaft]
frame = "mass"
position_m = [0.0, 0.0, 0.1]
mass_moment_kg_m = 0.004
speed_rad_per_s = 60.0
run_up_s = 0.2
[frames]
solver = "exudyn"
[particles]
solver = "none"
[coupling]
sync_interval_s = 5e-4
[output]
interval_s = 0.01
pictures = false
"""


@pytest.mark.process
def test_the_power_of_drives_is_that_of_all_that_drives(tmp_path: Path) -> None:
    """A drive gives what the bushings take from its base, an exciter the rest of what the dampers lose.

    Tolerance: forces at the ends of intervals stand for their means, over 200 intervals in a cycle.
    """
    case_folder(tmp_path / "case", DRIVEN)
    done = flipflow(*run_words(str(tmp_path / "case"), tmp_path / "run", []))
    assert done.returncode == 0, done.stderr
    power, motion = (summary(tmp_path / "run")["results"][part] for part in ("power", "motion"))
    with h5py.File(tmp_path / "run" / "history.h5") as history:
        time_s = history["frames/base/time_s"][:]
        rows = (time_s > motion["start_s"]) & (time_s <= motion["end_s"])
        velocity = history["frames/base/velocity_m_per_s"][:][rows]
        force = sum(history[f"bushings/spring-{k}/force_N"][:][rows] for k in (1, 2))
        ledger = {name: history[f"energy_cycles/{name}"][:] for name in history["energy_cycles"]}
    of_drive = -float(np.mean(np.sum(velocity * force, axis=1)))
    first, last = (int(np.argmin(np.abs(ledger["time_s"] - power[key]))) for key in ("start_s", "end_s"))
    spent_J = {
        kind: np.diff(ledger[f"supplied.frames.{kind}_J"][[first, last]])[0] for kind in ("drive", "exciter")
    }
    over_s = power["end_s"] - power["start_s"]
    assert spent_J["drive"] / over_s == pytest.approx(of_drive, rel=1e-2)
    assert min(abs(J) for J in spent_J.values()) > 0.1 * max(abs(J) for J in spent_J.values())
    assert power["drives_W"]["value"] == pytest.approx(sum(spent_J.values()) / over_s, rel=1e-9)
    lost_W = sum(each["value"] for each in power["lost_W"].values())
    assert power["drives_W"]["value"] == pytest.approx(lost_W, rel=1e-3)
