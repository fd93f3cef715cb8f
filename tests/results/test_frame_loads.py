"""The loads on a frame: in balance, and the same in every format."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.output.loads import Format
from orchestrator.output.loads.files import README, write_loads
from orchestrator.output.loads.forces import FrameForces, read_forces
from orchestrator.ports import Array
from tests.runs.outside import QUICK, flipflow, run_words

REAL = (pytest.mark.solver, pytest.mark.process, pytest.mark.slow)
ALL = (*QUICK, "output.loads_s=2e-4", "duration_s=0.03")
SHORT = "coupling.sync_interval_s=2e-4"
RUNS = {
    "translating": ("empty-machine", (*ALL, SHORT, "frames.solver=two-mass")),
    "turning": ("empty-machine", (*ALL, SHORT, "frames.solver=exudyn")),
    "loaded": ("quickstart", (*ALL, "frames.solver=exudyn", "bed.blocks.coal.count=200")),
    "motor": ("motor-start", ALL),
}
BALANCED = 1e-6
END = np.inf


@pytest.fixture(scope="module", params=[pytest.param(name, marks=REAL) for name in RUNS])
def run(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    case, sets = RUNS[request.param]
    folder = tmp_path_factory.mktemp("loads") / request.param
    done = flipflow(*run_words(case, folder, sets))
    assert folder.is_dir(), done.stderr
    return folder


def test_loads_are_in_balance_at_every_moment(run: Path) -> None:
    for frame in ("driving", "driven"):
        forces = read_forces(run, frame, 0.0, END)
        assert max(forces.out_of_balance()) < BALANCED
        assert ("held/frame/1" in forces.names) == (run.name == "translating")


def test_inertia_is_that_of_the_recorded_motion(run: Path) -> None:
    """The momentum gained in each sync interval, by the trapezoidal rule, with the jump of the panels' pull
    at its start; the rule's error is of second order in the interval, and Exudyn's is the same."""
    forces = read_forces(run, "driving", 0.0, END)
    kinds = np.array([name.split("/")[0] for name in forces.names])
    with h5py.File(run / "history.h5") as history:
        velocity, time_s, turned_rad = (
            history[f"frames/driving/{name}"][:] for name in ("velocity_m_per_s", "time_s", "rotation_rad")
        )
    assert abs(turned_rad).max() < 0.02  # so that axes that turn differ little from those at rest
    rows = np.searchsorted(time_s, forces.time_s - 1e-9)
    steps_s = np.diff(forces.time_s)
    gained = np.linalg.norm(np.diff(velocity[rows], axis=0), axis=1)
    inertia_N = -forces.force_N[:, kinds == "inertia"].sum(axis=1)
    pull_N = forces.force_N[:, np.isin(kinds, ("clamp", "stop", "wall"))].sum(axis=1)
    weight_N = np.linalg.norm(forces.force_N[0, kinds == "gravity"])
    mean_N = (inertia_N[1:] + inertia_N[:-1] + np.diff(pull_N, axis=0)) / 2
    given = np.linalg.norm(mean_N, axis=1) * steps_s / (weight_N / 9.81)
    assert given == pytest.approx(gained, abs=2e-3 * gained.max())


def table(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8") as text:
        return list(csv.DictReader(text))


def vectors(rows: list[dict[str, str]], what: str, unit: str) -> Array:
    return np.array([[float(row[f"{what}{axis}_{unit}"]) for axis in "xyz"] for row in rows])


def beam_stiffness(x_m: Array) -> Array:
    """The stiffness (6 n, 6 n) of a steel tube along x with nodes at ``x_m`` (n,), by Euler and Bernoulli."""
    axial_N, bending_N_m2, torsion_N_m2 = 2.1e11 * 4e-3, 2.1e11 * 1e-5, 8e10 * 2e-5
    whole = np.zeros((6 * len(x_m), 6 * len(x_m)))
    for k, length_m in enumerate(np.diff(x_m)):
        element = np.zeros((12, 12))
        for degree, value in ((0, axial_N / length_m), (3, torsion_N_m2 / length_m)):
            element[np.ix_([degree, degree + 6], [degree, degree + 6])] = value * np.array([[1, -1], [-1, 1]])
        for deflection, rotation, sign in ((1, 5, 1.0), (2, 4, -1.0)):
            a = sign * length_m
            block = [
                [12, 6 * a, -12, 6 * a],
                [6 * a, 4 * a * a, -6 * a, 2 * a * a],
                [-12, -6 * a, 12, -6 * a],
                [6 * a, 2 * a * a, -6 * a, 4 * a * a],
            ]
            at = [deflection, rotation, deflection + 6, rotation + 6]
            element[np.ix_(at, at)] = bending_N_m2 / length_m**3 * np.array(block)
        whole[6 * k : 6 * k + 12, 6 * k : 6 * k + 12] += element
    return whole


def test_a_beam_computed_from_the_table_needs_no_support(run: Path, tmp_path: Path) -> None:
    """All places hang on a beam along the deck by rigid arms; its first node is held."""
    done = flipflow("loads", str(run), "--frame", "driving", "--out", str(tmp_path / "csv"))
    assert done.returncode == 0, done.stderr
    rows = table(tmp_path / "csv" / "loads.csv")
    place_m = vectors(rows, "", "m")
    force_N, moment_N_m = vectors(rows, "force_", "N"), vectors(rows, "moment_", "N_m")
    time, moments = np.unique([float(row["time_s"]) for row in rows], return_inverse=True)
    x_m, nodes = np.unique(place_m[:, 0].round(9), return_inverse=True)
    arm_m = place_m - np.stack([x_m[nodes], *np.zeros((2, len(rows)))], axis=1)
    load = np.zeros((len(x_m), 6, len(time)))
    np.add.at(
        load, (nodes, slice(None), moments), np.hstack([force_N, moment_N_m + np.cross(arm_m, force_N)])
    )
    stiffness, free = beam_stiffness(x_m), slice(6, None)
    moved = np.linalg.solve(stiffness[free, free], load.reshape(-1, len(time))[free])
    reaction = stiffness[:6, free] @ moved - load[0]
    assert abs(moved).max() > 1e-9  # the beam does bend
    assert abs(reaction[:3]).max() < BALANCED * abs(force_N).max()
    assert abs(reaction[3:]).max() < BALANCED * abs(np.cross(place_m, force_N)).max()


def small_forces() -> FrameForces:
    """Two places over eleven moments; what is 1e-12 of the largest has no card."""
    random = np.random.default_rng(1)
    force_N, moment_N_m = 1e3 * random.normal(size=(11, 2, 3)), random.normal(size=(11, 2, 3))
    force_N[:, 1, 2], moment_N_m[:, 0] = 1e-9, 0.0
    names = ("clamp/deck-1-first/1", "inertia/frame/1")
    return FrameForces(0.4 + 0.01 * np.arange(11), names, np.eye(3)[:2], force_N, moment_N_m, np.zeros(3))


def expected(forces: FrameForces) -> dict[tuple[str, int], Array]:
    both = np.concatenate([forces.force_N, forces.moment_N_m], axis=2)
    cards = {(f"P{k + 1}", degree + 1): both[:, k, degree] for k in range(2) for degree in range(6)}
    for left_out in (("P2", 3), ("P1", 4), ("P1", 5), ("P1", 6)):
        del cards[left_out]
    return cards


def test_calculix_reads_back_what_was_written(tmp_path: Path) -> None:
    forces = small_forces()
    write_loads(forces, Format.CALCULIX, tmp_path, "a", "driving")
    curves: dict[str, Array] = {}
    for block in (tmp_path / "amplitudes.inc").read_text().split("*AMPLITUDE, NAME=")[1:]:
        name, *lines = block.splitlines()
        assert all(len(line.split(",")) <= 8 for line in lines)
        curves[name] = np.array([float(word) for line in lines for word in line.split(",")]).reshape(-1, 2)
    loads = {}
    for block in (tmp_path / "cloads.inc").read_text().split("*CLOAD, AMPLITUDE=")[1:]:
        name, load = block.splitlines()
        node_set, degree, factor = (word.strip() for word in load.split(","))
        assert curves[name][:, 0] == pytest.approx(forces.time_s - 0.4)
        loads[node_set, int(degree)] = float(factor) * curves[name][:, 1]
    wanted = {
        (f"{place}R", degree - 3) if degree > 3 else (place, degree): values
        for (place, degree), values in expected(forces).items()
    }
    assert loads.keys() == wanted.keys()
    assert [*loads.values()] == pytest.approx(np.array([wanted[key] for key in loads]), rel=1e-8)


def test_apdl_reads_back_what_was_written(tmp_path: Path) -> None:
    forces = small_forces()
    write_loads(forces, Format.APDL, tmp_path, "a", "driving")
    tables: dict[str, Array] = {}
    loads = {}
    for line in (tmp_path / "loads.mac").read_text().splitlines():
        if words := re.fullmatch(r"\*DIM,(\w+),TABLE,(\d+),1,1,TIME", line):
            tables[words[1]] = np.full((int(words[2]), 2), np.nan)
        elif words := re.fullmatch(r"(\w+)\((\d+),([01])\)=(.+)", line):
            tables[words[1]][int(words[2]) - 1, int(words[3])] = float(words[4])
        else:
            words = re.fullmatch(r"F,(P\d)_N,([FM][XYZ]),%(\w+)%", line)
            assert words, line
            degree = ("FX", "FY", "FZ", "MX", "MY", "MZ").index(words[2]) + 1
            assert tables[words[3]][:, 0] == pytest.approx(forces.time_s - 0.4)
            loads[words[1], degree] = tables[words[3]][:, 1]
    wanted = expected(forces)
    assert loads.keys() == wanted.keys()
    assert [*loads.values()] == pytest.approx(np.array([wanted[key] for key in loads]), rel=1e-8)
    assert [row["place"] for row in table(tmp_path / "places.csv")] == ["P1", "P2"]
    assert "driving" in (tmp_path / README).read_text()


@pytest.mark.process
@pytest.mark.solver
def test_wrong_requests_are_refused(tmp_path: Path) -> None:
    silent, out = tmp_path / "silent", str(tmp_path / "out")
    flipflow(*run_words("empty-machine", silent, (*QUICK, "duration_s=2e-3", "panel.solver=rigid")))
    good = ["loads", str(silent), "--frame", "driving", "--out", out]
    for wrong in (
        good,  # without output.loads_s
        [*good[:3], "drivng", *good[4:]],
        [*good[:5], str(silent)],
        ["loads", str(tmp_path), *good[2:]],
        [*good, "--format", "nastran"],
    ):
        done = flipflow(*wrong)
        assert done.returncode == 2, done.stderr
        assert "Traceback" not in done.stderr
    assert not (tmp_path / "out").exists()
