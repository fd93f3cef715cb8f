"""The benchmark of effects: its ratios, what is loaded, and that what is left out leaves no trace
in what the solvers get."""

from __future__ import annotations

import itertools
import pickle
import time
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.solver_plans import particles_plan
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.catalogue import EFFECTS, has_effect
from tests.runs.outside import ROOT
from tools.bench.coupling import median_ratio
from tools.bench.effects import Timed, TimedCase, bench, ratio, sets, that_can_go, undescribing
from tools.bench.loaded import loaded_by

BALL = ROOT / "cases/ball-on-panel"
COAL = ROOT / "cases/ffs0827-slice"


def test_ratios_are_of_blocks_side_by_side() -> None:
    """The ratios do not depend on the computer's speed from block to block."""
    first = Timed((2.0, 8.0, 3.0), 0.0, {})
    other = Timed((1.0, 4.0, 2.0), 0.0, {})
    assert ratio(first, other) == "2.00 (1.75 to 2.00)"


def test_blocks_shorter_than_a_tick_of_the_clock_have_no_ratio() -> None:
    assert median_ratio([2.0, 3.0, 1.0], [1.0, 0.0, 1.0]) == "1.50 (1.25 to 1.75)"
    assert median_ratio([2.0], [0.0]) == ""


def test_overlays_are_said_as_on_the_command_line() -> None:
    assert list(sets({"contacts": {"0": {"a": 0.0}, "1": {"a": 1}}})) == [
        "contacts.0.a=0.0",
        "contacts.1.a=1",
    ]


@pytest.mark.parametrize("name", ["adhesion", "rolling-friction"])
def test_left_out_is_the_same_to_the_solver_as_not_described(name: str) -> None:
    """Every field of the particles' plan, to the bit."""
    case = load_judged(COAL, "draft").case
    others = [effect for effect in EFFECTS if has_effect(case, effect) and effect != name]
    without = load_judged(COAL, "draft", [f"effects={others}"]).case
    undescribed = load_judged(COAL, "draft", sets(undescribing(case, name))).case
    corner_m = single_panels(case)[0].rectangle.corner_m
    one_triangle = np.array([[0, 1, 2]]), np.array([0])
    surface = TriangleSurface(corner_m + np.eye(3), *one_triangle)
    plans = [particles_plan(each, surface) for each in (without, undescribed)]
    assert pickle.dumps(plans[0]) == pickle.dumps(plans[1])
    assert pickle.dumps(plans[0]) != pickle.dumps(particles_plan(case, surface))


@pytest.mark.process
def test_what_is_loaded_is_what_the_case_calls_for() -> None:
    whole = loaded_by(BALL, "draft", [])
    rigid = loaded_by(BALL, "draft", ["panel.solver=rigid"])
    empty = loaded_by(BALL, "draft", ["particles.solver=none"])
    assert {"panel.strip.panel", "particles.liggghts.particles", "frames.prescribed"} <= whole
    assert "panel.strip.panel" in whole - rigid
    assert not whole & {"dolfinx", "exudyn", "gmsh", "matplotlib"}
    assert "mpi4py" in whole - empty


@pytest.mark.process
def test_the_table_has_a_row_for_each_effect_that_can_be_left_out(monkeypatch: pytest.MonkeyPatch) -> None:
    """The clock ticks whenever it is read: a virtual computer's may tick every 50 ms."""
    monkeypatch.setattr(time, "perf_counter", itertools.count().__next__)
    timed = TimedCase(Path(ROOT / "cases/bushing-hysteresis"), "draft", ())
    table = bench(timed, 40, that_can_go(timed))
    rows = list(table.columns[0].cells)
    assert rows[0] == "the case"
    assert rows[1:] == ["without run-up"]
    assert all(float(str(cell)) > 0 for cell in table.columns[1].cells)
