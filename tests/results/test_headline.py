"""The figures at the top: each says from how much it is, and whether it will last."""

from __future__ import annotations

import copy
import re
from pathlib import Path
from typing import Any

import h5py
import pytest

from orchestrator.figures.results import FIGURES
from orchestrator.figures.short_names import SHORT_NAMES
from orchestrator.output.report.formatting import number
from orchestrator.output.report.headline import COMPUTED, NOT_STEADY, Tile, headline, headline_lines
from orchestrator.output.report.page import Film, page
from tests.results.synthetic import (
    BIN_KG,
    CYCLE_S,
    DEPTH_M,
    LEAVES,
    MASS_KG,
    POWER_W,
    folder_of,
    parsed,
    results_table,
)


@pytest.fixture(scope="module")
def steady(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    return results_table(folder_of(tmp_path_factory.mktemp("headline") / "run"))


EFFICIENCY = FIGURES["results.screening.efficiency_percent"].words
HEIGHT = FIGURES["results.bed.mean_depth_m"].words
WHOLE_FEED = {
    "left_out_percent": 12.5,
    "smallest_computed_m": 0.0015,
    "smallest_m": 0.0005,
    "fines_percent": 50.0,
    "fine_placement_percent": {"value": 13.0},
    "continuation": {
        "factor": 3.0,
        "tested_factor": 1.5,
        "tested_error_percent": 1.0,
        "error_percent": -1.23,
    },
    "sections": [],
    "curve": None,
}


def tiles_of(results: dict[str, Any]) -> dict[str, Tile]:
    return {tile.name: tile for tile in headline(parsed(results))}


def test_boxes_of_bulk_come_first(steady: dict[str, Any]) -> None:
    """A box in which no slope is known has no tile of it."""
    of_box = {"mass_kg": 0.2, "density_kg_per_m3": 1500.0, "slope_deg": 35.25}
    results = steady | {"bulk": {"heap": of_box, "cup": of_box | {"slope_deg": None}}}
    names = [tile.name for tile in headline(parsed(results))]
    assert names[:3] == [
        "mass over the volume of the box, box heap",
        "slope of the free surface, box heap",
        "mass over the volume of the box, box cup",
    ]
    assert tiles_of(results)[names[1]].line == f"{names[1]}: 35.2 degree (over the second half of the run)"


def test_a_steady_run_says_from_how_much_its_figures_are(steady: dict[str, Any]) -> None:
    """Ten particles leave in a cycle, eight of them fine."""
    tiles = tiles_of(steady)
    assert tiles["screening efficiency η"].over == "500 particles that left, 50 cycles, 4.00 s"
    recovered = tiles["fines recovered, of what came in"]
    assert recovered.over == "400 fine particles that left, 50 cycles, 4.00 s"
    assert tiles["feed"].over == "50 cycles, 4.00 s"
    load = tiles["load per area of the deck"]
    assert load.over == "100 particles at 500 output times, 50 cycles, 4.00 s"
    assert load.line == f"load per area of the deck: 12.539 ± 0.000 kg/m² (over {load.over})"
    assert not [tile.name for tile in tiles.values() if tile.unsteady]


def test_a_figure_of_too_few_cycles_says_why_it_has_no_interval(steady: dict[str, Any]) -> None:
    table = copy.deepcopy(steady)
    table["bed"]["velocity_m_per_s"] |= {"half_width": None, "reason": "too few cycles for an interval"}
    tile = tiles_of(table)["material velocity"]
    assert (tile.interval, tile.over.endswith("4.00 s; too few cycles for an interval")) == ("", True)


def test_the_bed_is_told_by_its_load_and_by_the_mean_of_its_height(steady: dict[str, Any]) -> None:
    """8 bins on a deck of 638 by 200 mm, whose heights fall by 5 mm from one to the next."""
    tiles = tiles_of(steady)
    load, height = tiles["load per area of the deck"], tiles[HEIGHT]
    assert float(load.value) == pytest.approx(8 * BIN_KG / (0.638 * 0.2), rel=1e-4)
    assert (height.value, height.unit) == (f"{1e3 * (DEPTH_M - 3.5 * 0.005):.3f}", "mm")
    assert not [name for name in tiles if "largest" in name and "panel" not in name]


def test_the_feed_is_in_tonnes_an_hour_with_kilograms_a_second_beside(steady: dict[str, Any]) -> None:
    feed_kg_per_s = (LEAVES * MASS_KG).sum() / CYCLE_S
    (feed,) = [tile for tile in headline(parsed(steady)) if tile.name.startswith("feed")]
    assert (float(feed.value), feed.unit) == (pytest.approx(3.6 * feed_kg_per_s, rel=1e-4), "t/h")
    assert feed.also == f"{number(feed_kg_per_s)} kg/s"
    assert f" t/h = {feed.also} (over " in feed.line


def test_the_whole_feed_says_how_far_its_curve_is_continued(steady: dict[str, Any]) -> None:
    """The line says how far the curve is continued, and the error of that, which the interval has."""
    efficiency = steady["screening"]["efficiency_percent"]
    screening = steady["screening"] | {"whole_feed": WHOLE_FEED | {"efficiency_percent": efficiency}}
    tiles = headline(parsed(steady | {"screening": screening}))
    tile = tiles[0]
    assert [each.name for each in tiles[:2]] == [EFFICIENCY, f"{EFFICIENCY}{COMPUTED}"]
    assert tile.over.startswith("12.5 % of the feed by the partition curve, continued from 1.5 to 0.5 mm; ")
    assert "; the interval has the error of that, some 1.2 points" in tile.over


def test_the_grains_that_tell_the_separation_of_a_transient_are_named(steady: dict[str, Any]) -> None:
    """The grains stand instead of a window of cycles, which has others, and with why there is no interval."""
    cohort = {"fed_until_s": 0.95, "remaining_percent": 0.4, "particles": 104}
    reason = {"half_width": None, "reason": "no interval: the deck was still filling; by chance alone ± 9.0"}
    cohort["efficiency_percent"] = {"value": 64.6, **reason}
    continuation = WHOLE_FEED["continuation"] | {"error_percent": 1.2}  # type: ignore[operator]
    added = WHOLE_FEED | {"continuation": continuation, "efficiency_percent": {"value": 70.0, **reason}}
    screening = steady["screening"] | {"cohort": cohort, "whole_feed": added}
    transient = steady["steady"] | {"is_steady": False, "reason": "too short"}
    lines = [*headline_lines(parsed(steady | {"screening": screening, "steady": transient}))]
    (whole,) = (line for line in lines if f"{EFFICIENCY}: 70.0 %" in line)
    (computed,) = (line for line in lines if f"{EFFICIENCY}{COMPUTED}: 64.6 %" in line)
    assert "; the error of that is some 1.2 points, 104 particles" in whole
    for line in (whole, computed):
        assert line.endswith(f"104 particles that were fed until 0.950 s; {reason['reason']})")
        assert "cycles" not in line


def test_an_efficiency_that_is_not_known_has_its_reason(steady: dict[str, Any]) -> None:
    """The figure of the computed sizes is not the answer where no curve completes what is left out."""
    missing = steady["missing"] | {"whole feed": "12 fine particles left; its curve needs 100"}
    tiles = headline(parsed(steady | {"missing": missing}))
    assert tiles[0].line == f"{EFFICIENCY}: unknown (12 fine particles left; its curve needs 100)"
    assert tiles[1].name == f"{EFFICIENCY}{COMPUTED}"
    short = SHORT_NAMES["efficiency"].of, SHORT_NAMES["computed_efficiency"].of
    computed = steady["screening"]["efficiency_percent"]["value"]
    assert [of({"results": steady | {"missing": missing}}) for of in short[:1]] == [None]
    for of in short:
        number = of({"results": steady})
        assert number is not None
        assert number.value == computed
    whole = WHOLE_FEED | {"efficiency_percent": {"value": 12.0, "half_width": 3.0}}
    completed = steady | {"screening": steady["screening"] | {"whole_feed": whole}}
    values = [of({"results": completed}) for of in short]
    assert [value and value.value for value in values] == [12.0, computed]


@pytest.mark.parametrize(("points", "shown"), [(0.0, False), (0.04, False), (0.06, True), (None, True)])
def test_a_recovery_that_is_the_efficiency_is_not_told_twice(
    steady: dict[str, Any], points: float | None, shown: bool
) -> None:
    """The two are one figure where no coarse particle passes; without coarse ones there is no efficiency."""
    screening = steady["screening"]
    recovery = screening["fine_placement_percent"]["value"]
    less = screening["efficiency_percent"] | {"value": None if points is None else recovery - points}
    tiles = tiles_of(steady | {"screening": screening | {"efficiency_percent": less}})
    assert ("undersize recovery" in tiles) is shown


def test_the_acceleration_is_the_mean_peak_of_a_cycle_and_the_rms_of_one_panel(
    steady: dict[str, Any],
) -> None:
    """The panel is the one with the largest mean peak, whatever single peaks and the other panels have."""
    calm = {"value": 50.0, "half_width": 4.0, "batches": 20}
    points = {
        "one": {"peak_g": 900.0, "cycle_peak_g": calm, "rms_g": calm | {"value": 30.0}},
        "two": {"peak_g": 300.0, "cycle_peak_g": calm | {"value": 60.0}, "rms_g": calm | {"value": 20.0}},
    }
    place = {"panel": "deck-1", "at": [0.5, 0.5], "band_Hz": 500.0, "peak_normal_g": 9.0, "rms_normal_g": 1.0}
    for point in points.values():
        point |= place | {"cycle_peak_100_Hz_g": calm | {"value": 40.0}}
    tiles = tiles_of(steady | {"motion": steady["motion"] | {"panel_points": points}})
    lines = [tile.line for name, tile in tiles.items() if "acceleration" in name]
    assert all("two" in re.findall(r"\w+", line) for line in lines)
    assert [re.findall(r": ([\d.]+ ± [\d.]+) g", line) for line in lines] == [
        [f"{g}.0 ± 4.0"] for g in (60, 40, 20)
    ]


def test_the_speed_of_a_shaft_with_a_motor_is_told(steady: dict[str, Any]) -> None:
    tiles = tiles_of(steady | {"motion": steady["motion"] | {"shafts_rad_per_s": {"main": 77.23}}})
    assert {"77.2", "rad/s"} <= {*tiles["speed of the shaft main"].line.split()}


def test_what_is_scaled_from_a_slice_says_so(steady: dict[str, Any]) -> None:
    """A quarter of the width: four times the feed, mass and power, and the same load and efficiency."""
    whole, part = tiles_of(steady), tiles_of(steady | {"share_of_width": 0.25})
    scaled = {"feed", "mass on the deck", "power of the drives"}
    assert set(part) - set(whole) == {f"{name}, of the whole width" for name in scaled}
    for name, tile in whole.items():
        beside = part[f"{name}, of the whole width" if name in scaled else name]
        times = 4.0 if name in scaled else 1.0
        assert float(beside.value) == pytest.approx(times * float(tile.value), rel=1e-3)


def test_the_power_of_the_drives_is_told(steady: dict[str, Any]) -> None:
    power = tiles_of(steady)["power of the drives"]
    assert (float(power.value), power.unit) == (pytest.approx(1e-3 * POWER_W), "kW")
    unsettled = steady | {"motion": steady["motion"] | {"is_settled": False}}
    filling = steady | {"steady": steady["steady"] | {"is_steady": False}}
    for results in (unsettled, filling):
        assert tiles_of(results)["power of the drives"].unsteady


def test_panels_and_frames_stand_in_natural_order(tmp_path: Path) -> None:
    """The order is that of the results, from which the tables of the page follow."""
    folder = folder_of(tmp_path / "run", particles=False, cycles=4)
    with h5py.File(folder / "history.h5", "a") as history:
        for number in (10, 11):
            history.copy("panel_cycles/deck-1", f"panel_cycles/deck-{number}")
    results = results_table(folder)
    assert list(results["motion"]["panels"]) == ["deck-1", "deck-2", "deck-10", "deck-11"]


@pytest.mark.parametrize("cycles", [11, 15])
def test_a_transient_says_that_it_is_one(tmp_path: Path, cycles: int) -> None:
    """The material that has left so early is mostly what leaves fast: it does not tell the separation."""
    folder = folder_of(tmp_path / "run", cycles=cycles)
    results = results_table(folder)
    tiles = tiles_of(results)
    over = f"{cycles} cycles, {number(cycles * CYCLE_S)} s"
    assert tiles["feed"].over == over
    unknown = tiles.pop(EFFICIENCY)
    assert unknown.line.startswith(f"{EFFICIENCY}: unknown (the run ends before 100 grains or more")
    assert not [name for name in tiles if "yield" in name or "recover" in name]
    for name, tile in tiles.items():
        assert tile.unsteady is not name.startswith(("largest panel", "panel acceleration", "relative"))
    lines = [*headline_lines(parsed(results))]
    assert [line for line in lines if NOT_STEADY in line] == [f"{NOT_STEADY}:"]
    at = lines.index(f"{NOT_STEADY}:")
    assert lines[at - 1].startswith("No steady state: ")
    assert lines[at + 1 :] == [f"  {tile.line}" for tile in headline(parsed(results)) if tile.unsteady]
    text = re.sub(r"\s+", " ", page(folder, parsed(results), lambda *_: Film(b"", reason="none")))
    assert f"over {over}<br><strong>{NOT_STEADY}</strong>" in text
    feed = tiles["feed"]
    assert f'{feed.value} <span class="unit">t/h</span></div> <div class="give"> = {feed.also}<' in text


def test_a_machine_that_still_runs_up_is_not_steady(tmp_path: Path) -> None:
    """Two cycles are averaged over: nobody can see whether they settle."""
    folder = folder_of(tmp_path / "run", particles=False, cycles=4)
    results = results_table(folder)
    assert results["motion"]["reason"] == "averaged over 2 cycles; 4 are needed to see it settle"
    assert all(tile.unsteady for tile in headline(parsed(results)))
