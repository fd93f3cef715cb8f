"""All results of a screen made by hand (``synthetic.py``), against its figures by hand."""

from __future__ import annotations

import re
import shutil
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from orchestrator.output.records.history import write_results
from orchestrator.output.results.machine import why_not_settled
from orchestrator.output.results.quantities import Question, number_of
from orchestrator.output.results.run_reader import RunReader
from tests.results.synthetic import (
    BIN_KG,
    CYCLE_S,
    CYCLES,
    DEPTH_M,
    FILLED,
    LEAVES,
    LOST_W,
    MASS_KG,
    PANEL_M,
    POWER_W,
    VELOCITY_M_S,
    WEAR_M_H,
    WORN_ROW,
    folder_of,
    results_table,
)
from tests.runs.test_manual import documented

FINE = np.array([True, True, False])
OUT_KG = LEAVES * MASS_KG  # a cycle, by exit and size


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return folder_of(tmp_path_factory.mktemp("by-hand") / "run")


@pytest.fixture(scope="module")
def results(folder: Path) -> dict[str, Any]:
    return results_table(folder)


def value(estimate: dict[str, Any]) -> Any:
    assert estimate["half_width"] == pytest.approx(0.0, abs=1e-9)  # every cycle is alike
    return estimate["value"]


def test_decks_above_each_other_have_no_cut_size_of_their_own(
    folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The largest openings would be those of the upper deck, through which nearly all goes."""
    monkeypatch.setattr(RunReader, "deck", None)
    given = results_table(folder)
    assert given["screening"]["cut_size_m"] == 0.003
    run = shutil.copytree(folder, tmp_path / "run")
    text = (run / "case.toml").read_text()
    (run / "case.toml").write_text(text.replace("cut_size_m = 0.003", ""))
    results = results_table(run)
    assert "no single deck" in results["missing"]["efficiency"]
    assert results["screening"]["cut_size_m"] is None
    assert "efficiency_percent" not in results["screening"]
    assert results["failed"] == {}


def test_it_is_steady_once_the_deck_is_full(results: dict[str, Any]) -> None:
    state = results["steady"]
    assert state["is_steady"]
    assert state["imbalance_percent"] == pytest.approx(0.0, abs=1e-9)
    assert FILLED * CYCLE_S <= state["start_s"] < (FILLED + 2.5) * CYCLE_S
    assert state["end_s"] == pytest.approx(60 * CYCLE_S)


def test_the_manual_knows_every_key(results: dict[str, Any]) -> None:
    of_others = {"cohort", "whole_feed"}
    assert set(results["screening"]) == documented("### `results.screening`") - of_others
    assert set(results["bed"]) == documented("### `results.bed`")
    assert set(results) == documented("### `results`") - {"slice_width_m", "bulk"}
    assert set(results["contacts"]) == documented("### `results.contacts`")


def test_flows(results: dict[str, Any]) -> None:
    screening = results["screening"]
    assert value(screening["feed_kg_per_s"]) == pytest.approx(OUT_KG.sum() / CYCLE_S)
    assert value(screening["undersize_kg_per_s"]) == pytest.approx(OUT_KG[:2].sum() / CYCLE_S)
    assert value(screening["oversize_kg_per_s"]) == pytest.approx(OUT_KG[2].sum() / CYCLE_S)
    assert value(screening["hold_up_kg"]) == pytest.approx(FILLED * OUT_KG.sum())
    assert screening["lost_particles"] == 0


def test_contacts(results: dict[str, Any]) -> None:
    """Each fine grain touches the first panel once in half a second; who goes on, the second one twice
    in a quarter."""
    first, second = results["contacts"]["along"]
    assert (first["contacts_per_s"], second["contacts_per_s"]) == pytest.approx((2.0, 8.0))
    assert (first["stay_s"], second["stay_s"]) == pytest.approx((0.5, 0.25))
    assert (first["within_reach_percent"], second["within_reach_percent"]) == pytest.approx((10.0, 10.0))
    fines = OUT_KG[:, FINE].sum(axis=1)
    assert first["chance_percent"] == pytest.approx(100 * fines[0] / fines.sum())
    assert second["chance_percent"] == pytest.approx(100 * fines[1] / fines[1:].sum() / 2)
    assert first["passed_percent"] == pytest.approx(100 * fines[0] / fines.sum())
    assert results["contacts"]["counted_percent"] == pytest.approx(100 * fines[:2].sum() / fines.sum())


def test_separation(results: dict[str, Any]) -> None:
    screening = results["screening"]
    fines = OUT_KG[:, FINE].sum(axis=1)
    recovery = 100 * fines[:2].sum() / fines.sum()
    for name in ("fine_placement", "efficiency", "recovered"):  # no coarse passes, none stays
        assert value(screening[f"{name}_percent"]) == pytest.approx(recovery)
    assert value(screening["coarse_placement_percent"]) == pytest.approx(100.0)
    assert value(screening["misplaced_percent"]) == pytest.approx(100 * fines[2] / OUT_KG.sum())
    first, second = screening["sections"]
    assert (first["exit"], second["exit"]) == ("one", "two")
    assert value(second["yield_percent"]) == pytest.approx(100 * OUT_KG[1].sum() / OUT_KG.sum())
    assert value(second["cumulative_efficiency_percent"]) == pytest.approx(recovery)
    local = 100 * fines[1] / fines[1:].sum()
    assert value(second["local_efficiency_percent"]) == pytest.approx(local)


def test_power(results: dict[str, Any]) -> None:
    """The exciter supplies 2 W at a constant rate, and ten particles a cycle are fed."""
    power = results["power"]
    for entry, expected in ((power["drives_W"], POWER_W), (power["lost_W"]["a.b"], LOST_W)):
        assert value(entry) == pytest.approx(expected)
        assert entry["half_width"] == pytest.approx(0.0, abs=1e-9)
    assert value(power["drives_J_per_kg"]) == pytest.approx(POWER_W * CYCLE_S / OUT_KG.sum())
    assert (power["start_s"], power["end_s"]) == pytest.approx(
        (results["motion"]["start_s"], CYCLES * CYCLE_S)
    )


def test_counting(results: dict[str, Any]) -> None:
    """The fines in 50 cycles are 350 of 2 and 2.8 mm that pass and 50 of 2.8 mm that do not."""
    screening = results["screening"]
    cycles = screening["particles"] / LEAVES.sum()
    fines = np.repeat(MASS_KG[:2], np.round(cycles * LEAVES[:, :2].sum(axis=0)).astype(int))
    share = value(screening["fine_placement_percent"]) / 100
    expected = 100 * np.sqrt(share * (1 - share) * (fines @ fines)) / fines.sum()
    for name in ("fine_placement", "efficiency", "recovered"):  # all coarse stay: no scatter of theirs
        assert screening[f"{name}_percent"]["counting"] == pytest.approx(expected)
    assert screening["coarse_placement_percent"]["counting"] == 0.0
    assert "counting" not in screening["feed_kg_per_s"]


def test_partition(results: dict[str, Any]) -> None:
    """0, 1/3 and 1 of the three sizes go over: 50 % lie a quarter of the way from 2.8 to 5 mm."""
    table = results["screening"]["partition"]
    there = [number for number in table["oversize_percent"] if number is not None]
    assert there == pytest.approx([0.0, 100 / 3, 100.0])
    assert value(table["d50_m"]) == pytest.approx(0.0028 + 0.25 * 0.0022)


def test_transport(results: dict[str, Any]) -> None:
    transport = results["transport"]
    assert value(transport["residence_s"]) == pytest.approx(FILLED * CYCLE_S)
    passing = transport["passing"]
    step = passing["along_m"][1] - passing["along_m"][0]
    assert np.sum(passing["rate_kg_per_s_m"]) * step == pytest.approx(OUT_KG[:2].sum() / CYCLE_S)
    assert np.flatnonzero(passing["rate_kg_per_s_m"]).tolist() == [1, 5]  # 0.1 and 0.4 of 0.638 m


def test_bed(results: dict[str, Any]) -> None:
    bed = results["bed"]
    assert value(bed["on_deck_kg"]) == pytest.approx(8 * BIN_KG)
    assert value(bed["velocity_m_per_s"]) == pytest.approx(VELOCITY_M_S)
    assert value(bed["largest_depth_m"]) == pytest.approx(DEPTH_M)
    assert value(bed["mean_depth_m"]) == pytest.approx(np.mean(bed["profile"]["depth_m"]))
    assert bed["profile"]["depth_m"] == pytest.approx(DEPTH_M - 0.005 * np.arange(8))
    assert value(results["held"]["stickers"]) == 7.0


def test_the_load_of_the_deck_is_that_of_the_criteria(folder: Path, results: dict[str, Any]) -> None:
    state = results["steady"]
    asked = Question(measure="deck_load", between_s=(state["start_s"] + 1e-6, state["end_s"] + 1e-6))
    assert value(results["bed"]["load_kg_per_m2"]) == pytest.approx(number_of(asked, folder), rel=1e-12)


def test_the_results_name_the_width_of_a_slice(folder: Path, results: dict[str, Any], tmp_path: Path) -> None:
    assert "slice_width_m" not in results
    copy = Path(shutil.copytree(folder, tmp_path / "run"))
    case = copy / "case.toml"
    case.write_text(case.read_text() + "\n[slice]\nwidth_m = 0.1\n")
    part = results_table(copy)
    assert part["failed"] == {}
    assert (part["slice_width_m"], part["share_of_width"]) == (0.1, pytest.approx(0.5))
    load = results["bed"]["load_kg_per_m2"]["value"]
    assert part["bed"]["load_kg_per_m2"]["value"] == pytest.approx(2 * load)  # the same mass on half the area


def test_motion(results: dict[str, Any]) -> None:
    motion = results["motion"]
    assert motion["frames"]["driven"]["amplitude_m"] == pytest.approx([0.008, 0, 0.005], abs=1e-9)
    assert motion["frames"]["driving"]["major_m"] == pytest.approx(0.0035)
    assert value(motion["relative"]["driven-driving"]["along_m"]) == pytest.approx(0.006)
    peak = motion["panel_points"]["middle-1"]["peak_normal_g"]
    assert peak == pytest.approx(PANEL_M * 78.5**2 / 9.80665, rel=2e-3)
    panel = motion["panels"]["deck-1"]
    assert panel["tension_mean_N"] == pytest.approx(150.0, rel=1e-3)
    assert panel["tension_largest_N"] == pytest.approx(200.0, rel=1e-3)
    assert panel["stretch_largest_percent"] == pytest.approx(2.0, rel=0.01)


def test_the_history_has_the_same(folder: Path, results: dict[str, Any]) -> None:
    write_results(folder / "history.h5", results)
    write_results(folder / "history.h5", results)  # anew, not twice
    with h5py.File(folder / "history.h5") as history:
        group = history["results"]
        efficiency = group["screening/efficiency_percent"]
        assert efficiency[()] == results["screening"]["efficiency_percent"]["value"]
        assert (efficiency.attrs["unit"], efficiency.attrs["batches"]) == ("%", 25)  # two of 50 cycles each
        assert group["transport/passing/rate_kg_per_s_m"].attrs["unit"] == "kg/(s m)"
        assert group["screening/sections/2/exit"].asstr()[()] == "two"
        depth = group["bed/profile/depth_m"]
        assert depth[:] == pytest.approx(results["bed"]["profile"]["depth_m"])


def test_a_short_run_says_that_it_is_transient(tmp_path: Path) -> None:
    results = results_table(folder_of(tmp_path / "run", cycles=15))
    assert not results["steady"]["is_steady"]
    assert "20 are needed" in results["steady"]["reason"]
    efficiency = results["screening"]["efficiency_percent"]
    assert efficiency["value"] is not None
    assert efficiency["half_width"] is None


def test_an_empty_machine_has_its_motion(tmp_path: Path) -> None:
    results = results_table(folder_of(tmp_path / "run", particles=False))
    assert "no particles" in results["missing"]["screening"]
    assert "screening" not in results
    assert results["motion"]["relative"]["driven-driving"]["along_m"]["value"] == pytest.approx(0.006)


def test_less_than_a_cycle_gives_no_results(tmp_path: Path) -> None:
    results = results_table(folder_of(tmp_path / "run", cycles=0))
    assert list(results["missing"]) == ["everything"]


def thinned(folder: Path, kinds: tuple[str, ...], every: int) -> Path:
    """Keeps one row of so many in every group of these kinds."""
    with h5py.File(folder / "history.h5", "a") as history:
        for kind in kinds:
            groups = [history[kind]] if "time_s" in history[kind] else history[kind].values()
            for group in groups:
                for name in list(group):
                    rows = group[name][::every]
                    del group[name]
                    group[name] = rows
    return folder


def test_a_row_between_output_times_counts_in_no_mean(tmp_path: Path, results: dict[str, Any]) -> None:
    """A run that was stopped between two output times, and resumed, has one."""
    folder = folder_of(tmp_path / "resumed")
    with h5py.File(folder / "history.h5", "a") as history:
        for group in (history["profile"], history["bed"], history["held"], *history["wear"].values()):
            time_s = group["time_s"][:]
            row = int(np.searchsorted(time_s, 40 * CYCLE_S))
            for name in list(group):
                if name == "along_m" or len(group[name]) != len(time_s):
                    continue
                rows = group[name][:]
                more = (time_s[row - 1] + time_s[row]) / 2 if name == "time_s" else 100 * rows[row]
                del group[name]
                group[name] = np.insert(rows, row, more, axis=0)
    resumed = results_table(folder)
    assert resumed["bed"]["on_deck_kg"] == results["bed"]["on_deck_kg"]
    assert resumed["bed"]["particles"] == results["bed"]["particles"]
    assert resumed["held"] == results["held"]
    for name, panel in resumed["wear"]["panels"].items():
        assert panel["mean_m_per_h"] == results["wear"]["panels"][name]["mean_m_per_h"]


def test_a_series_too_seldom_gives_no_orbits_but_the_panels_figures(
    tmp_path: Path, results: dict[str, Any]
) -> None:
    """Eight rows of a cycle: half the range of a sine would be short by up to 7.6 %."""
    kinds = ("frames", "probes", "forces")
    seldom = results_table(thinned(folder_of(tmp_path / "seldom"), kinds, 10))
    for part in ("orbits", "panel acceleration"):
        assert "8 rows in a cycle of 0.08 s; 20 are needed" in seldom["missing"][part]
    assert seldom["motion"]["frames"] == seldom["motion"]["panel_points"] == {}
    assert seldom["motion"]["panels"] == results["motion"]["panels"]
    assert seldom["screening"] == results["screening"]
    assert seldom["failed"] == {}


def test_rows_too_seldom_for_the_band_of_accelerations(tmp_path: Path, results: dict[str, Any]) -> None:
    """A row every millisecond reaches to 500 Hz, one every 2 ms does not, at sync points that are
    nearer to each other.  The orbits need no more."""
    assert results["motion"]["panel_points"]["middle-1"]["band_Hz"] == pytest.approx(39.25 * 40 / np.pi)
    fewer = results_table(thinned(folder_of(tmp_path / "fewer"), ("frames", "probes", "forces"), 2))
    assert "too seldom for accelerations up to 500 Hz" in fewer["missing"]["panel acceleration"]
    assert fewer["motion"]["frames"]["driven"]["amplitude_m"][0] == pytest.approx(0.008)


def test_output_times_once_in_a_cycle_give_no_mean(tmp_path: Path, results: dict[str, Any]) -> None:
    """Ten in a cycle do, two do not: they see two phases of it again and again."""
    kinds = ("profile", "held", "bed", "overlaps")
    for every in (10, 5):
        seldom = results_table(thinned(folder_of(tmp_path / f"every-{every}"), kinds, every))
        assert "bed" not in seldom
        assert "held" not in seldom
        assert "of the machine's cycle of 0.08 s" in seldom["missing"]["bed"]
        assert seldom["screening"] == results["screening"]
    enough = results_table(thinned(folder_of(tmp_path / "every-3"), kinds, 3))
    assert enough["bed"]["velocity_m_per_s"]["value"] == pytest.approx(VELOCITY_M_S)


def test_no_output_time_in_the_window(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "none", cycles=30)
    with h5py.File(folder / "history.h5", "a") as history:
        for group in (history["profile"], history["held"], *history["panels"].values()):
            for name in list(group):
                first = group[name][:1]
                del group[name]
                group[name] = first
    results = results_table(folder)
    assert "no output time lies in" in results["missing"]["bed"]
    assert results["failed"] == {}
    assert results["motion"]["panels"]["deck-1"]["stretch_largest_percent"] > 1.9


def test_times_at_which_a_bin_is_empty_count_as_no_depth(tmp_path: Path) -> None:
    """The same in the headline and along the deck: half of the time there is nothing."""
    folder = folder_of(tmp_path / "half-empty")
    with h5py.File(folder / "history.h5", "a") as history:
        profile = history["profile"]
        for name, empty in (("mass_kg", 0.0), ("depth_m", np.nan), ("velocity_m_per_s", np.nan)):
            values = profile[name][:]
            values[1::2] = empty
            profile[name][...] = values
    bed = results_table(folder)["bed"]
    assert bed["largest_depth_m"]["value"] == pytest.approx(DEPTH_M / 2)
    assert max(bed["profile"]["depth_m"]) == pytest.approx(DEPTH_M / 2)
    assert bed["velocity_m_per_s"]["value"] == pytest.approx(VELOCITY_M_S)
    assert bed["profile"]["velocity_m_per_s"] == pytest.approx([VELOCITY_M_S] * 8)


def test_the_velocity_is_weighted_with_mass_over_time_too(tmp_path: Path) -> None:
    """Nine tenths of the mass go by at 0.3 m/s and the rest at 1.3: 0.4 m/s, not 0.8."""
    folder = folder_of(tmp_path / "thrown")
    with h5py.File(folder / "history.h5", "a") as history:
        profile = history["profile"]
        for name, factor, shift in (("mass_kg", 1 / 9, 0.0), ("velocity_m_per_s", 1.0, 1.0)):
            values = profile[name][:]
            values[1::2] = factor * values[1::2] + shift
            profile[name][...] = values
    bed = results_table(folder)["bed"]
    assert value(bed["velocity_m_per_s"]) == pytest.approx(VELOCITY_M_S + 0.1)
    assert bed["profile"]["velocity_m_per_s"] == pytest.approx([VELOCITY_M_S + 0.1] * 8)


def test_a_part_that_fails_loses_no_other(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def broken(*_: object) -> None:
        raise IndexError("list index out of range")

    folder = folder_of(tmp_path / "run")
    monkeypatch.setattr("orchestrator.output.results.compute.bed_metrics", broken)
    results = results_table(folder)
    assert set(results["failed"]) == {"bed"}
    assert results["failed"]["bed"].startswith("IndexError: list index out of range (test_compute.py")
    assert "bed" not in results
    assert {"screening", "motion", "wear"} <= set(results)


def test_wear(results: dict[str, Any]) -> None:
    """Rates by hand; per cycle they are all the same, so that the interval is narrow."""
    wear = results["wear"]
    assert set(wear) == documented("### `results.wear`")
    for name, rate in WEAR_M_H.items():
        panel = wear["panels"][name]
        mean = panel["mean_m_per_h"]
        assert mean["value"] == pytest.approx(rate * 9 / 8, rel=1e-6)  # one row of eight is double
        assert mean["half_width"] < 1e-6 * rate
        assert panel["largest_m_per_h"] == pytest.approx(2 * rate, rel=1e-6)
        assert panel["largest_at"] == [(WORN_ROW + 0.5) / 8, 0.125]  # the first of the row
        assert panel["worn_through_h"] == pytest.approx(0.004 / (2 * rate), rel=1e-6)
    profile = wear["profile"]
    assert np.diff(profile["along_m"]).min() > 0
    deepest = int(np.argmax(profile["mean_m_per_h"]))
    assert deepest == WORN_ROW
    assert profile["mean_m_per_h"][8 + WORN_ROW] == pytest.approx(4e-6, rel=1e-6)


def test_the_profile_of_wear_has_each_panel_in_its_place(
    folder: Path, results: dict[str, Any], tmp_path: Path
) -> None:
    """The names of the panels do not matter: the second of the case comes first among the names."""
    copy = Path(shutil.copytree(folder, tmp_path / "run"))
    case, names = copy / "case.toml", {"deck-1": "upper", "deck-2": "lower"}
    before, block, after = re.split(
        r"(\[screen\.panels\.deck\]\n.*?(?=\[screen\.surfaces))", case.read_text(), flags=re.S
    )
    block = re.sub(r"count = 2\npitch_m = .*\n", "", block)
    upper, lower = (block.replace("panels.deck", f"panels.{name}") for name in names.values())
    lower = lower.replace("corner_m = [\n    0.0,", "corner_m = [\n    0.338,")
    lower = lower.replace('"driving",\n    "driven",', '"driven",\n    "driving",')
    text = before + upper + lower + after
    for old, new in names.items():
        text = text.replace(f'"{old}"', f'"{new}"')
    case.write_text(text)
    with h5py.File(copy / "history.h5", "a") as history:
        for group in ("panels", "wear", "forces", "panel_cycles"):
            for old, new in names.items():
                history.move(f"{group}/{old}", f"{group}/{new}")
    wear = results_table(copy)["wear"]
    assert list(wear["panels"]) == ["upper", "lower"]
    assert wear["profile"] == results["wear"]["profile"]


def test_the_course_has_the_stroke_and_the_load_of_each_window(results: dict[str, Any]) -> None:
    course = results["course"]
    assert course["end_s"] == pytest.approx([12 * CYCLE_S * number for number in range(1, 6)])
    pair = course["relative"]["driven-driving"]
    assert pair["along_m"] == pytest.approx([0.006] * 5)
    assert pair["half_width_m"] == pytest.approx([0.0] * 5, abs=1e-9)
    assert course["on_deck_kg"] == pytest.approx([8 * BIN_KG] * 5)
    assert course["velocity_m_per_s"] == pytest.approx([VELOCITY_M_S] * 5)


def test_the_course_follows_a_load_that_comes_and_goes(folder: Path, tmp_path: Path) -> None:
    """The material lies on the deck in the last two of five windows, and halves the stroke there."""
    copy = Path(shutil.copytree(folder, tmp_path / "run"))
    with h5py.File(copy / "history.h5", "r+") as file:
        late = file["profile/time_s"][:] > 36 * CYCLE_S
        file["profile/mass_kg"][:] = np.where(late[:, None], file["profile/mass_kg"][:], 0.0)
        driven, driving = (file[f"frames/{name}/displacement_m"] for name in ("driven", "driving"))
        late = file["frames/driven/time_s"][:] > 36 * CYCLE_S
        halved_m = driving[:] + 0.5 * (driven[:] - driving[:])
        driven[:] = np.where(late[:, None], halved_m, driven[:])
    course = results_table(copy)["course"]
    assert course["relative"]["driven-driving"]["along_m"] == pytest.approx([0.006] * 3 + [0.003] * 2)
    assert course["on_deck_kg"] == pytest.approx([0.0] * 3 + [8 * BIN_KG] * 2)
    assert course["velocity_m_per_s"][:3] == [None] * 3


@pytest.mark.parametrize(
    ("motors", "slow", "settles"),
    [
        (("a", "b"), 71.9, False),
        (("a", "b"), 86.79, True),
        (("a", "b"), 43.0, True),
        ((), 86.7, False),
        ((), 86.79, True),
        ((), 43.0, True),
    ],
)
def test_shafts_of_nearly_equal_speeds_beat(motors: tuple[str, ...], slow: float, settles: bool) -> None:
    """Motors' speeds that are equal but for their estimate are one speed; shafts that are told to turn
    0.1 rad/s apart are 0.1 rad out of step after a second, however short the window is.  Half of a speed is
    another use of a second exciter.
    """
    speeds = {"a": 86.8, "b": slow}
    exciters = {name: SimpleNamespace(speed_rad_per_s=each) for name, each in speeds.items()}
    run: Any = SimpleNamespace(
        is_driven=True,
        shaft_speeds_rad_per_s=lambda *_: {name: speeds[name] for name in motors},
        case=SimpleNamespace(
            screen=SimpleNamespace(exciters=exciters, frames={}),
            frames=SimpleNamespace(adapter=SimpleNamespace(moved_by_forces=True)),
        ),
        names=lambda _: [],
    )
    reason = why_not_settled(run, 0.7, 1.0, 0.0, "")
    assert (f"b and a turn at {slow:.4g} and 86.8 rad/s" in reason) != settles
    assert bool(reason) != settles
