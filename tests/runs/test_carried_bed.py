"""A run that begins with the bed of another run: what is carried over, and where that is recorded."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

from orchestrator.case.bed import saved_bed
from orchestrator.case.bed.carry import read_run
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.output.records.snapshots import in_single_precision, particle_mesh
from orchestrator.ports import Array
from orchestrator.ports.particle_records import ParticleSnapshot
from tests.cases import CASE, case_folder
from tests.grains import sphere_kg, spheres
from tests.runs.outside import flipflow, has_results, run_words, said_plainly

pytestmark = pytest.mark.solver
# a floor that stands still, on which nine grains settle
BED = """
[bed.blocks.coal]
material = "coal"
box_m = [[0.05, 0.05, 0.012], [0.14, 0.14, 0.05]]
count = 9
velocity_m_per_s = [0.1, 0.0, -0.5]
sizes = [{ smallest_m = 0.018, largest_m = 0.022, mass_fraction = 1.0 }]

[coupling]
sync_interval_s = 2e-4
[frames]
solver = "two-mass"
[panel]
solver = "rigid"
surface_cells = [6, 4]
[output]
interval_s = 0.01
pictures = false
"""


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The folders of a run, and of one of a finer surface that begins with the bed of the first."""
    place = tmp_path_factory.mktemp("beds")
    text = CASE.replace("[bed.particles.ball]", "[bed.particles.other]").partition("[bed.particles.other]")
    text = text[0].replace("duration_s = 0.1", "duration_s = 0.05") + BED
    case = case_folder(place / "case", text.replace("speed_rad_per_s = 78.5", "speed_rad_per_s = 40.0"))
    first, second = place / "first", place / "second"
    done = flipflow(*run_words(str(case), first, []))
    assert done.returncode == 0, done.stderr
    sets = ["bed.from_run=../first", "panel.surface_cells=[12, 8]", "duration_s=0.02", "bed.push_out=true"]
    done = flipflow(*run_words(str(case), second, sets))
    assert done.returncode == 0, done.stderr
    said_plainly(done)
    return first, second


def at(run: Path, series: str, row: int) -> Array:
    with h5py.File(run / "history.h5") as history:
        return np.asarray(history[series][row])


@pytest.mark.parametrize("series", ["bed/mass_kg", "bed/mean_velocity_m_per_s", "bed/highest_m"])
def test_mass_and_momentum_are_carried_over(runs: tuple[Path, Path], series: str) -> None:
    """The sums agree to rounding; no grain lay so deep that it was pushed out."""
    first, second = runs
    before = at(first, series, -1)
    assert np.any(before)
    np.testing.assert_allclose(at(second, series, 0), before, rtol=1e-12)


def kinetic_J(bed: CarriedBed) -> float:
    """The kinetic energy of spheres, of their velocities and their spins."""
    mass_kg = sphere_kg(bed.grains.sieve_size_m, bed.grains.density_kg_per_m3)
    speeds2 = (bed.velocity_m_per_s**2).sum(axis=1)
    rims2 = (bed.spin_rad_per_s**2).sum(axis=1) * bed.grains.sieve_size_m**2 / 4
    return float((mass_kg * (speeds2 / 2 + rims2 / 5)).sum())


def test_kinetic_energy_is_carried_over(runs: tuple[Path, Path]) -> None:
    """The second run's own file for ParaView has single precision."""
    first, second = runs
    before_J = kinetic_J(read_run(first, None))
    assert before_J > 0
    assert kinetic_J(saved_bed.read(second / saved_bed.BED)) == pytest.approx(before_J, rel=1e-12)
    assert kinetic_J(read_run(second, 0.0)) == pytest.approx(before_J, rel=1e-6)


def test_the_pictures_have_forces_and_contacts(runs: tuple[Path, Path]) -> None:
    """The block of the first run falls freely at t = 0. At its end, grains touch each other or the deck."""
    first, second = runs
    falling = meshio.read(first / "particles/particles_00000.vtu").point_data
    weight_N = 9.81 * sphere_kg(falling["sieve_size_m"], falling["density_kg_per_m3"])
    np.testing.assert_allclose(falling["force_N"], np.outer(-weight_N, [0, 0, 1]), rtol=1e-5, atol=1e-9)
    assert not falling["contacts"].any()
    resting = meshio.read(second / "particles/particles_00002.vtu").point_data
    assert np.abs(resting["force_N"]).max() > 0


def test_nothing_is_thrown(runs: tuple[Path, Path]) -> None:
    """Energy stored in contacts at the start would otherwise give particles a speed."""
    _, second = runs
    speeds = [at(second, "bed/mean_speed_m_per_s", row) for row in (0, 1, -1)]
    assert max(speeds) < speeds[0] + 0.1


def test_the_books_of_the_second_run_close(runs: tuple[Path, Path]) -> None:
    _, second = runs
    has_results(second)
    summary = json.loads((second / "summary.json").read_text())
    assert summary["momentum_residual_relative"] < 1e-9
    assert summary["material"]["fed"]["number"] == 9


def test_the_folder_tells_where_the_bed_comes_from_and_runs_alone(
    runs: tuple[Path, Path], tmp_path: Path
) -> None:
    first, second = runs
    about = json.loads((second / "provenance.json").read_text())["bed"]
    assert about["run"] == str(first)
    assert about["time_s"] == pytest.approx(0.05)
    assert about["particles"] == 9
    alone = tmp_path / "alone"
    alone.mkdir()
    for name in ("case.toml", "bed.h5"):
        (alone / name).write_bytes((second / name).read_bytes())
    checked = flipflow("check", str(alone))
    assert checked.returncode == 0, checked.stderr
    assert "9 at the start" in checked.stdout


def test_states_between_checkpoints_come_from_the_pictures_of_the_run(runs: tuple[Path, Path]) -> None:
    first, _ = runs
    checked = flipflow(
        "check", str(first), "--set", f"bed.from_run={first}", "--set", "bed.from_time_s=0.021"
    )
    assert checked.returncode == 0, checked.stderr
    assert "particles_00002.vtu, at t = 0.02 s" in checked.stdout


def nobody_at(file: Path) -> None:
    places = np.empty((0, 3))
    nobody = ParticleSnapshot(np.empty(0, dtype=np.int64), places, places, places, spheres([]))
    meshio.write(file, in_single_precision(particle_mesh(nobody)), compression=None)


def cut_off(file: Path) -> None:
    file.write_bytes(file.read_bytes()[:-100])


@pytest.mark.parametrize(
    ("change", "message"), [(nobody_at, "there are no particles at that time"), (cut_off, "is it whole?")]
)
def test_a_time_without_particles_is_refused(
    runs: tuple[Path, Path], tmp_path: Path, change: Callable[[Path], None], message: str
) -> None:
    first = shutil.copytree(runs[0], tmp_path / "first")
    change(first / "particles/particles_00002.vtu")
    words = ("--set", f"bed.from_run={first}", "--set", "bed.from_time_s=0.021")
    checked = flipflow("check", str(first), *words)
    assert checked.returncode == 2, checked.stderr
    assert "particles_00002.vtu: " in checked.stderr
    assert message in checked.stderr
    said_plainly(checked)
