"""Stretch, overlap and motion per step: each found in a scene made for it, and in no other."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from orchestrator.case.tables.case import Case
from orchestrator.case.tables.numerics import MonitorSettings
from orchestrator.coupling.machine import Machine, PanelPoints
from orchestrator.coupling.schemes.scheme import State
from orchestrator.ports import Load, Motion, PanelState, ParticleSnapshot
from orchestrator.ports.geometry import Edges
from orchestrator.ports.particle_records import BedSnapshot, Overlaps
from orchestrator.ports.penetration import Penetrations
from orchestrator.run.monitor import items
from orchestrator.run.monitor.item import Books, Subject
from orchestrator.run.monitor.items import all_items, item_limit, largest_stretch
from orchestrator.run.monitor.monitor import LimitedItem
from tests.cases import load_case
from tests.grains import spheres

STEP_s = 1e-5
NONE = np.empty(0, dtype=np.int64)
FLAT_m = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0.1, 0.1, 0]], dtype=float)
EDGES = Edges.of(FLAT_m[:, :2], np.array([[0, 1, 2], [1, 3, 2]]))
PANEL = PanelPoints("deck", slice(4), slice(0), NONE, NONE, NONE, NONE, NONE, EDGES.points, EDGES.length_m)
UNTOUCHED = Penetrations(FLAT_m, (), ())
BALLS = ParticleSnapshot(
    id=np.array([3, 8]),
    position_m=np.zeros((2, 3)),
    velocity_m_per_s=np.array([[0, 0, -1.0], [2.0, 0, 0]]),
    spin_rad_per_s=np.zeros((2, 3)),
    grains=spheres([0.01, 0.004]),
)


def state(position_m: np.ndarray = FLAT_m, speed_m_per_s: float = 1.0) -> State:
    surface = Motion(position_m, np.full_like(position_m, speed_m_per_s / np.sqrt(3)))
    clamps = Motion(np.empty((0, 3)), np.empty((0, 3)))
    return State(clamps, np.empty((0, 3)), PanelState(surface, Load.zero(0)), Load.zero(4))


ITEMS = ("stretched_panels", "penetrated_surfaces", "deep_overlaps", "long_steps")


def alarms(now: State, balls: ParticleSnapshot, overlap: float, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setattr(items, "particle_step_s", lambda case: STEP_s)
    machine = SimpleNamespace(panels=[PANEL], penetrations=UNTOUCHED)
    subject = Subject(cast(Case, None), cast(Machine, machine), now, {})
    books = Books(now, {}, BedSnapshot(balls, Overlaps(0.0, 0.0, 0.001, overlap / 2)))
    raised = []
    for name in ITEMS:
        kind = all_items()[name]
        item, limit = kind(subject), item_limit(MonitorSettings(), kind)
        assert limit is not None
        observed = [*item.observe_surface(now), *item.observe_books(books)]
        raised += LimitedItem(item, limit).judge(observed, 0.5)
    return [alarm.what for alarm in raised]


def test_five_edges_of_two_triangles() -> None:
    assert len(EDGES.points) == 5
    assert sorted(EDGES.length_m) == pytest.approx([0.1] * 4 + [0.1 * np.sqrt(2)])


def test_stretch_is_the_largest_over_the_stress_free_lengths() -> None:
    def stretch(position_m: np.ndarray) -> float:
        return largest_stretch(EDGES.points, EDGES.length_m, position_m)[1]

    pulled = FLAT_m * [1.2, 1.0, 1.0]
    assert stretch(pulled) == pytest.approx(0.2)
    assert stretch(pulled @ np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]])) == pytest.approx(0.2)
    assert stretch(0.9 * FLAT_m) == pytest.approx(-0.1)


@pytest.mark.parametrize(
    ("position_m", "speed_m_per_s", "fastest_m_per_s", "overlap", "message"),
    [
        (FLAT_m, 1.0, 2.0, 0.01, None),
        (1.29 * FLAT_m, 1.0, 2.0, 0.19, None),
        (1.31 * FLAT_m, 1.0, 2.0, 0.01, "panel deck is stretched by 0.31"),
        (FLAT_m, 1.0, 2.0, 0.21, "particles overlap by 0.21 of a radius"),
        (FLAT_m, 1.0, 21.0, 0.01, "particle 8 moves in a particle step by 0.1"),
        (FLAT_m, 21.0, 2.0, 0.01, "the surface moves in a particle step by 0.1"),
    ],
)
def test_each_is_found_alone(
    position_m: np.ndarray,
    speed_m_per_s: float,
    fastest_m_per_s: float,
    overlap: float,
    message: str | None,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A step of 0.01 ms; the smaller ball has a radius of 2 mm, a tenth of which is 20 m/s."""
    velocity_m_per_s = np.array([[0, 0, -1.0], [fastest_m_per_s, 0, 0]])
    messages = alarms(
        state(position_m, speed_m_per_s),
        replace(BALLS, velocity_m_per_s=velocity_m_per_s),
        overlap,
        monkeypatch,
    )
    assert len(messages) == (message is not None)
    assert all(f"t = 0.5 s: {message}" in what for what in messages)


def test_no_particles_is_no_trouble(monkeypatch: pytest.MonkeyPatch) -> None:
    assert alarms(state(), BALLS.part(slice(0)), 0.0, monkeypatch) == []


def test_a_folded_panel_is_found_and_stops_the_run(tmp_path: Path) -> None:
    case = load_case(tmp_path).case
    line = np.arange(20)
    deck = replace(PANEL, surface=slice(20), centre_line=line)
    machine = SimpleNamespace(panels=[deck], penetrations=UNTOUCHED)
    flat_m = np.column_stack([np.linspace(0.0, 0.3, 20), np.zeros(20), np.zeros(20)])
    subject = Subject(case, cast(Machine, machine), state(flat_m), {})
    item, limit = items.FoldedPanels(subject), item_limit(case.monitor, items.FoldedPanels)
    assert limit is not None
    limited = LimitedItem(item, limit)
    assert limited.judge(item.observe_surface(state(flat_m)), 0.1) == []
    back_m = flat_m.copy()  # 150 mm out and back, 2 mm above; the panel is 4 mm thick
    back_m[10:, 0], back_m[10:, 2] = flat_m[9::-1, 0], 0.002
    (alarm,) = limited.judge(item.observe_surface(state(back_m)), 0.5)
    assert alarm.then == "stop"
    assert alarm.what.startswith("t = 0.5 s: panel deck has folded into itself: its line ")
    assert alarm.what.endswith("touches itself (monitor.folded_panels)")
