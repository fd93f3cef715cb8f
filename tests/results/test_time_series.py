"""Rows of the time series: panel forces are means over the sync intervals since the last row."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.coupling.bushing_forces import BushingForces
from orchestrator.coupling.machine import PlacedProbe
from orchestrator.output.records.history import CHUNK_ROWS, History, Reserved
from orchestrator.output.records.series import PanelForces, TimeSeries, rotations_rad
from orchestrator.ports import Array, Load, Motion, PanelState, Pose
from orchestrator.ports.plans import BodyPlan, BushingPlan

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
    still = SimpleNamespace(names=(), at=lambda pose, _: np.empty((2, len(pose.position_m), 0, 3)))
    members = SimpleNamespace(frames=SimpleNamespace(pose=Pose.nothing))
    machine: Any = SimpleNamespace(frames=(), probes=(), panels=panels, bushings=still, members=members)
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


def test_every_row_has_what_its_moment_had(tmp_path: Path) -> None:
    """Rows are computed together; frames, probes, bushings and rows are of different numbers."""
    random, names = np.random.default_rng(5), ("one", "two")
    start = Pose(random.normal(size=(2, 3)), np.tile(np.eye(3), (2, 1, 1)), *np.zeros((2, 2, 3)))
    bushings = BushingForces.of(
        [
            BushingPlan(f"b-{n}", ends, random.normal(size=3), np.eye(3), np.full(3, 1e5), np.full(3, 40.0))
            for n, ends in enumerate((("one", "two"), ("ground", "one"), ("two", "ground")))
        ],
        [BodyPlan(n, 1.0, np.eye(3), at_m) for n, at_m in zip(names, start.position_m, strict=True)],
    )
    arm_m = random.normal(size=3)
    probes = [PlacedProbe("p", "frame", 1, arm_m), PlacedProbe("q", "surface", 2)]
    elements_N: list[Array] = []
    poses = [start]
    frames = SimpleNamespace(element_forces_N=lambda: elements_N[-1], pose=lambda: poses[-1])
    machine: Any = SimpleNamespace(
        frames=names, probes=probes, panels=[], bushings=bushings, members=SimpleNamespace(frames=frames)
    )
    history, states = History(tmp_path / "history.h5"), []
    series = TimeSeries(machine, None, history)  # type: ignore[arg-type]
    for row in range(4):
        turns = Rotation.from_rotvec(0.1 * random.normal(size=(2, 3))).as_matrix()
        elements_N.append(random.normal(size=(3, 3)))
        poses.append(Pose(random.normal(size=(2, 3)), turns, *random.normal(size=(2, 2, 3))))
        state: Any = SimpleNamespace(panel=SimpleNamespace(surface=Motion(*random.normal(size=(2, 3, 3)))))
        series.add_forces(np.empty((5, 0, 3)))
        series.write_row(float(row), state, None)
        states.append(state)
    history.close()
    with h5py.File(tmp_path / "history.h5") as file:
        assert set(file["probes"]) == {"p", "q"}
        for row, (state, pose, element_N) in enumerate(zip(states, poses[1:], elements_N, strict=True)):
            of_frames = {
                "displacement_m": pose.position_m - start.position_m,
                "velocity_m_per_s": pose.velocity_m_per_s,
                "rotation_rad": rotations_rad(pose),
                "spin_rad_per_s": pose.spin_rad_per_s,
            }
            for column, values in of_frames.items():
                for number, name in enumerate(names):
                    assert np.array_equal(file[f"frames/{name}/{column}"][row], values[number])
            turned_m = pose.rotation[1] @ arm_m
            carried = (
                pose.position_m[1] + turned_m,
                pose.velocity_m_per_s[1] + np.cross(pose.spin_rad_per_s[1], turned_m),
            )
            surface = state.panel.surface
            touched = (surface.position_m[2], surface.velocity_m_per_s[2])
            for name, motion in (("p", carried), ("q", touched)):
                for column, values in zip(("position_m", "velocity_m_per_s"), motion, strict=True):
                    assert file[f"probes/{name}/{column}"][row] == pytest.approx(values, abs=1e-15)
            for column, values in zip(
                ("deformation_m", "force_N"), bushings.at(pose, element_N), strict=True
            ):
                for number in range(3):
                    assert np.array_equal(file[f"bushings/b-{number}/{column}"][row], values[number])


def test_rows_that_cannot_be_computed_are_kept(tmp_path: Path) -> None:
    """The rows are kept until they can be computed: nothing is half written."""
    history = History(tmp_path / "history.h5")
    for time_s in (0.0, 1.0):
        history.add("rows", time_s, {"place_m": np.zeros(3)})
    history.derived["rows"] = lambda rows: iter([("one", {"place_m": rows["place_m"] / 0})])
    with np.errstate(all="raise"), pytest.raises(FloatingPointError):
        history.flush()
    history.derived["rows"] = lambda rows: iter([("one", dict(rows))])
    history.close()
    with h5py.File(tmp_path / "history.h5") as file:
        assert file["one/time_s"][:].tolist() == [0.0, 1.0]


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


class TakesAPart:
    """A file on a disk that fills: it takes no more than 1000 bytes at a time, as POSIX allows."""

    def __init__(self, file: Any) -> None:
        self._file = file

    def write(self, data: memoryview) -> int:
        return int(self._file.write(data[:1000]))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)


def test_a_write_of_which_the_disk_takes_a_part_is_gone_on_with(tmp_path: Path) -> None:
    file, data = Reserved(tmp_path / "history.h5"), np.random.default_rng(1).bytes(54321)
    file._file = TakesAPart(file._file)
    assert file.write(data) == len(data)
    file.close()
    assert (tmp_path / "history.h5").read_bytes() == data
