"""Least, largest and mean values of each cycle, from motion known by hand at every sync point."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from orchestrator.output.records import cycle_record
from orchestrator.output.records.cycle_record import CycleRecord
from orchestrator.output.records.history import History
from orchestrator.ports import Array, Motion, Pose
from orchestrator.ports.geometry import Rectangle

CYCLE_S, SYNC_POINTS = 0.08, 16
AT = Rectangle(
    corner_m=np.zeros(3),
    along=np.array([1.0, 0.0, 0.0]),
    across=np.array([0.0, 1.0, 0.0]),
    length_m=0.3,
    span_m=0.3,
    width_m=0.2,
    clamp_m=0.0,
)
LINE_M = np.array([[0.0, 0.1, 0.0], [0.15, 0.1, 0.0], [0.3, 0.1, 0.0]])


class Frames:
    """A frame that swings along x with an amplitude that falls from cycle to cycle."""

    time_s = 0.0

    def pose(self) -> Pose:
        phase = 2 * np.pi * self.time_s / CYCLE_S
        cycle = max(0, np.ceil(self.time_s / CYCLE_S - 1e-9) - 1)
        position_m = np.array([[0.001 * (3 - cycle) * np.sin(phase), 0.0, 0.0]])
        velocity_m_per_s = np.array([[0.0, 0.5 * np.cos(phase), 0.0]])
        return Pose(position_m, np.eye(3)[None], velocity_m_per_s, np.zeros((1, 3)))


FRAMES = Frames()
MACHINE: Any = SimpleNamespace(
    panels=[SimpleNamespace(name="deck", centre_line=np.arange(3))],
    frames=("frame",),
    members=SimpleNamespace(frames=FRAMES),
    probes=[
        SimpleNamespace(name="middle", index=1, on="surface"),
        SimpleNamespace(name="ball", index=1, on="particle"),
    ],
)


def at(time_s: float) -> tuple[Any, Array]:
    """State and forces: a middle that goes up and down, a pull of 100 N and more, a load downwards."""
    FRAMES.time_s = time_s
    phase = 2 * np.pi * time_s / CYCLE_S
    surface_m = LINE_M + np.outer([0.0, 0.01 * np.sin(phase), 0.0], [0.0, 0.0, 1.0])
    pull_N = 100.0 + 20.0 * np.sin(phase)
    forces_N = np.zeros((5, 1, 3))
    forces_N[0, 0] = [0.0, 0.0, -3.0]
    forces_N[2, 0, 0], forces_N[3, 0, 0] = pull_N, -pull_N
    panel = SimpleNamespace(surface=Motion(surface_m, 0.0 * surface_m))
    return SimpleNamespace(panel=panel), forces_N


def recorded(path: Path, stop_after: int | None = None) -> Path:
    """Two and a half cycles; with ``stop_after``, another record goes on from a save there."""
    history = History(path)
    start = at(0.0)[0]
    record = CycleRecord(MACHINE, start, [AT], CYCLE_S, history)
    for number in range(int(2.5 * SYNC_POINTS) + 1):
        time_s = number * CYCLE_S / SYNC_POINTS
        record.add_sync_point(time_s, *at(time_s))
        if number == stop_after:
            saved = record.save()
            at(0.0)  # a machine is opened as it was at the start
            record = CycleRecord(MACHINE, start, [AT], CYCLE_S, history)
            record.restore(saved)
    record.close()
    history.close()
    return path


def test_every_cycle_has_its_own_extremes(tmp_path: Path) -> None:
    with h5py.File(recorded(tmp_path / "history.h5")) as history:
        frame, middle = (history[f"point_cycles/{name}"] for name in ("frame", "middle"))
        assert set(history["point_cycles"]) == {"frame", "middle"}
        assert frame["time_s"][:] == pytest.approx([0.08, 0.16, 0.20])
        assert frame["sync_points"][:].tolist() == [17, 16, 8]
        assert frame["most_m"][:, 0] == pytest.approx([0.003, 0.002, 0.001])
        assert frame["least_m"][:, 0] == pytest.approx([-0.003, -0.002, 0.0], abs=1e-12)
        assert frame["mean_m"][:2, 0] == pytest.approx([0.0, 0.0], abs=1e-12)
        assert frame["farthest_m"][:] == pytest.approx([0.003, 0.002, 0.001])
        assert frame["fastest_m_per_s"][:] == pytest.approx([0.5, 0.5, 0.5])
        assert middle["most_m"][:, 2] == pytest.approx([0.01, 0.01, 0.01])
        panel = {name: rows[:] for name, rows in history["panel_cycles/deck"].items()}
    assert panel["pull_most_N"] == pytest.approx([120.0, 120.0, 120.0])
    assert panel["pull_least_N"][:2] == pytest.approx([80.0, 80.0])
    assert panel["pull_mean_N"][1] == pytest.approx(100.0)
    assert panel["clamp_most_N"] == pytest.approx([120.0, 120.0, 120.0])
    assert panel["load_mean_N"][:, 2] == pytest.approx([-3.0, -3.0, -3.0])
    longest = 2 * np.hypot(0.15, 0.01) / 0.3 - 1
    assert panel["stretch_most"] == pytest.approx([longest] * 3, rel=1e-9)
    assert panel["stretch_least"][:2] == pytest.approx([0.0, 0.0], abs=1e-12)
    assert panel["sag_most_m"] == pytest.approx([0.01, 0.01, 0.01])
    assert panel["middle_least_m"][:2] == pytest.approx([-0.01, -0.01])


@pytest.mark.parametrize("together", [1, 5])
def test_it_does_not_matter_how_many_are_evaluated_together(
    tmp_path: Path, together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = recorded(tmp_path / "whole.h5")
    monkeypatch.setattr(cycle_record, "TOGETHER", together)
    with h5py.File(whole) as first, h5py.File(recorded(tmp_path / "some.h5")) as other:
        for kind in ("point_cycles/frame", "panel_cycles/deck"):
            for name, rows in first[kind].items():
                assert np.array_equal(rows[:], other[f"{kind}/{name}"][:]), name


@pytest.mark.parametrize("stop_after", [5, 16, 17, 30])
def test_it_goes_on_from_a_save_as_if_nothing_had_been(tmp_path: Path, stop_after: int) -> None:
    whole, stopped = recorded(tmp_path / "whole.h5"), recorded(tmp_path / "two.h5", stop_after)
    with h5py.File(whole) as first, h5py.File(stopped) as second:
        for kind in ("point_cycles/frame", "panel_cycles/deck"):
            for name, rows in first[kind].items():
                assert np.array_equal(rows[:], second[f"{kind}/{name}"][:]), name
