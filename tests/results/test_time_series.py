"""Rows of the time series: panel forces are means over the sync intervals since the last row."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from orchestrator.output.records.history import CHUNK_ROWS, History
from orchestrator.output.records.series import PanelForces, TimeSeries
from orchestrator.ports import Load, Motion, PanelState

REST = Motion(np.zeros((4, 3)), np.zeros((4, 3)))


def state(load_N: float) -> Any:
    """Two panels of two surface and two clamp points each; every point of panel 2 carries twice
    what one of panel 1 does."""
    force_N = np.outer([1.0, 1.0, 2.0, 2.0], [0.0, 0.0, load_N])
    return SimpleNamespace(load=Load(force_N), panel=PanelState(REST, Load(-force_N)), clamps=REST)


def test_forces_are_means_since_the_last_row(tmp_path: Path) -> None:
    panels = [
        SimpleNamespace(
            name=f"p-{n + 1}",
            surface=slice(2 * n, 2 * n + 2),
            clamps=slice(2 * n, 2 * n + 2),
            first_clamp=np.array([2 * n]),
            second_clamp=np.array([2 * n + 1]),
            stops=np.empty(0, dtype=np.int64),
        )
        for n in range(2)
    ]
    still = SimpleNamespace(names=(), at=lambda motion, _: np.empty((2, len(motion.position_m), 0, 3)))
    members = SimpleNamespace(frames=None)
    machine: Any = SimpleNamespace(centres={}, probes=(), panels=panels, bushings=still, members=members)
    history = History(tmp_path / "history.h5")
    forces, series = PanelForces(machine, state(0.0)), TimeSeries(machine, state(0.0), history)
    for time_s, loads_N in ((0.0, [5.0]), (1.0, [1.0, 2.0, 6.0]), (2.0, [0.0, 3.0])):
        for load_N in loads_N:
            series.add_forces(forces.at(state(load_N)))
        series.write_row(time_s, state(loads_N[-1]), None)
    history.close()
    with h5py.File(tmp_path / "history.h5") as file:
        # sums over a panel's two points of the means 5, 3 and 1.5 N
        load_N = file["forces/p-1/load_N"][:, 2]
        clamp_N = file["forces/p-2/second_clamp_N"][:, 2]
        time_s = file["forces/p-1/time_s"][:]
    assert time_s == pytest.approx([0.0, 1.0, 2.0])
    assert load_N == pytest.approx([10.0, 6.0, 3.0])
    assert clamp_N == pytest.approx([-10.0, -6.0, -3.0])


def test_rows_go_on_in_a_file_that_is_there(tmp_path: Path) -> None:
    """More of them than a chunk holds; what has not had a row yet opens, too."""
    path = tmp_path / "history.h5"
    for part in range(2):
        history = History(path, goes_on=part > 0)
        with h5py.File(path) as file:
            assert len(file) == part
        for row in range(CHUNK_ROWS):
            time_s = float(part * CHUNK_ROWS + row)
            history.add("one", time_s, {"place_m": np.array([time_s, 0.0, 1.0])})
        history.close()
    with h5py.File(path) as file:
        assert np.array_equal(file["one/place_m"][:, 0], np.arange(2.0 * CHUNK_ROWS))
        assert file["one/place_m"].attrs["unit"] == "m"


def test_rows_of_nothing_are_rows(tmp_path: Path) -> None:
    """A machine without panels has places of none of them."""
    history = History(tmp_path / "history.h5")
    for row in range(3):
        history.add("none", float(row), {"place_m": np.empty((0, 3))})
    history.close()
    with h5py.File(tmp_path / "history.h5") as file:
        assert file["none/place_m"].shape == (3, 0, 3)
