"""The cost that ``flipflow check`` predicts, against counts done by hand, and against runs."""

from __future__ import annotations

import math
from pathlib import Path
from statistics import median
from typing import get_args

import pytest

from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.numerics import FramesSolver, PanelSolver
from orchestrator.case.tables.quantities import Table
from orchestrator.preflight.cost import (
    THICK,
    THIN,
    bed_cost,
    in_words,
    particles_at_start,
    predicted_parts_s,
    rigid_triangles,
)
from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, load_case
from tests.runs.outside import ROOT
from tools.cost_series import IN_THE_SUITE, compare

FEED = """
[screen.exits.under]
product = "undersize"
box_m = [[-0.5, -0.5, -0.9], [0.5, 0.5, -0.3]]

[bed.feeds.coal]
material = "coal"
rate_kg_per_s = 0.2
box_m = [[0.0, 0.0, 0.2], [0.3, 0.2, 0.4]]
velocity_m_per_s = [0.0, 0.0, -0.5]
start_s = 0.5
sizes = [
  { smallest_m = 0.004, largest_m = 0.004, mass_fraction = 0.25 },
  { smallest_m = 0.008, largest_m = 0.008, mass_fraction = 0.75 },
]
"""
STAY_S = 0.302 / THICK  # the panel is pulled 2 mm longer than it is
DURATION_S = 4.0


def sphere_kg(diameter_m: float) -> float:
    return 1430.0 * math.pi / 6 * diameter_m**3


def test_a_feed_fills_the_deck_until_as_much_leaves(tmp_path: Path) -> None:
    """0.05 and 0.15 kg/s of two sizes; each stays 0.302 m / (0.34 m/s)."""
    case = load_case(tmp_path, CASE + FEED, [f"duration_s={DURATION_S}"]).case
    cost = bed_cost(case, 0, THICK)
    rate = 0.05 / sphere_kg(0.004) + 0.15 / sphere_kg(0.008)
    assert cost.most == pytest.approx(rate * STAY_S, rel=1e-9)
    filling, full = STAY_S, DURATION_S - 0.5 - STAY_S
    wanted = rate * STAY_S * (filling / 2 + full) / DURATION_S
    assert cost.mean == pytest.approx(wanted, rel=1e-3)
    interval_s = case.coupling.sync_interval_s
    in_interval = math.ceil(interval_s / particle_step_s(case) - 1e-9)
    assert cost.steps == round(DURATION_S / interval_s) * in_interval > DURATION_S / particle_step_s(case)
    assert cost.particle_steps == pytest.approx(cost.mean * cost.steps)


def test_who_is_there_at_the_start_leaves_where_there_are_exits(tmp_path: Path) -> None:
    sets = [f"duration_s={DURATION_S}", "bed.feeds.coal.start_s=3.9999"]
    leaving = bed_cost(load_case(tmp_path / "one", CASE + FEED, sets).case, 1000, THICK)
    assert leaving.most == 1000
    assert leaving.mean == pytest.approx(1000 * STAY_S / DURATION_S, rel=2e-3)
    assert bed_cost(load_case(tmp_path / "two", overrides=[]).case, 1000, THICK).mean == 1000


def predicted(*sets: str, name: str = "quickstart", level: str = "draft") -> dict[str, float]:
    case = load_judged(ROOT / "cases" / name, level, list(sets)).case
    return predicted_parts_s(case, particles_at_start(case))


@pytest.mark.parametrize(("port", "table"), [("panel", PanelSolver), ("frames", FramesSolver)])
def test_every_solver_says_what_it_costs(port: str, table: type[Table]) -> None:
    """Every solver has a cost, also one that this case could not run."""
    for solver in get_args(table.model_fields["solver"].annotation):
        sets = [f"{port}.solver={solver}"]
        assert predicted(*sets)[port] > 0.0


def test_intervals_that_are_repeated_are_paid_for_as_often() -> None:
    """aitken and quasi-newton move the particles several times; robin moves the panels twice."""
    plain, robin, aitken, newton = (
        predicted(f"coupling.scheme={name}")
        for name in ("particles-first", "robin", "aitken", "quasi-newton")
    )
    assert robin["particles"] == plain["particles"]
    assert robin["panel"] == pytest.approx(2 * plain["panel"])
    for repeated in (aitken, newton):
        assert repeated["particles"] >= 2 * plain["particles"]
        assert repeated["panel"] >= 2 * plain["panel"]
        assert repeated["output"] == plain["output"]


def test_the_whole_run_is_counted_not_the_particles_alone() -> None:
    """Strips and frames of two masses; its particles are the smaller part."""
    parts = predicted("particles.solver=none", "frames.solver=two-mass")
    assert parts["particles"] == 0.0
    assert min(parts[name] for name in ("start", "panel", "frames", "output", "rest")) > 0.05
    fed = load_judged(ROOT / "cases/ffs0827-slice", "draft").case
    thin, thick = (predicted_parts_s(fed, 0, bed) for bed in (THIN, THICK))
    assert 0.0 < thin["particles"] < thick["particles"]
    assert thin["frames"] == thick["frames"]


def test_air_costs_what_was_measured_for_each_particle_and_step() -> None:
    """23 ns; all else of the run costs the same, and air whose drag is left out costs nothing."""
    case = load_judged(ROOT / "cases/quickstart", "draft").case
    work = bed_cost(case, particles_at_start(case), THICK).particle_steps
    plain, airy = predicted(), predicted("air={}")
    assert airy.pop("particles") - plain.pop("particles") == pytest.approx(23e-9 * work, rel=1e-6)
    assert airy == plain
    assert predicted("air={}", "particles.air_drag=none") == predicted()


def test_triangles_of_rigid_surfaces_are_read_once() -> None:
    """The triangles cost the start of a run some time and its intervals none."""
    folder = ROOT / "cases/quickstart"
    case = load_judged(folder, "draft").case
    assert rigid_triangles(case, folder) == [6]
    plain, fine = (predicted_parts_s(case, 100, rigid=rigid) for rigid in (6, 24_576))
    assert fine.pop("start") - plain.pop("start") == pytest.approx(1.15, abs=0.01)
    assert fine == plain


@pytest.mark.parametrize(
    ("time_s", "text"), [(51.2, "51 s"), (119.0, "119 s"), (180.0, "3 min"), (7200.0, "2 h"), (5e5, "6 days")]
)
def test_times_are_said_in_familiar_units(time_s: float, text: str) -> None:
    assert in_words(time_s) == text


@pytest.mark.slow
@pytest.mark.solver
@pytest.mark.process
def test_runs_take_what_was_predicted() -> None:
    """Processor time of three cases, within a factor of 1.5, on a machine that may be faster or
    slower than the one that was measured on: by their median, a factor of three at most."""
    ratios = {name: compare(name).ratio for name in IN_THE_SUITE}
    machine = median(ratios.values())
    assert 1 / 3 < machine < 3
    for name, ratio in ratios.items():
        assert 1 / 1.5 < ratio / machine < 1.5, (name, ratios)
