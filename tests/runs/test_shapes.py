"""Runs of grains of another shape, which comes through an entry point: the toy of two spheres."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import h5py
import meshio
import numpy as np
import pytest

from adapters.particles import liggghts
from orchestrator.case import solvers
from orchestrator.case.bed.carry import read_run
from orchestrator.case.tables import numerics
from orchestrator.cli import launch
from orchestrator.cli.launch import resume
from orchestrator.preflight.check import find_problems
from tests.cases import load_case
from tests.grains import sphere_kg
from tests.runs.outside import summary
from tests.runs.same_run import run_differences
from tests.runs.test_material import case

SHAPED = ['bed.feeds.chute.shape="dumbbell"', 'bed.blocks.coal.shape="dumbbell"']
SETS = ["particles.solver=spheres", *SHAPED, "duration_s=0.12", "particles.step_s=2e-5"]
SPHERES = np.array([2, 1])  # in a grain of each shape, by its number
DOUBTFUL = 5  # exit code: particles are lost on purpose


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return case(tmp_path_factory.mktemp("shapes") / "case")


def run(case_folder: Path, out: Path, sets: list[str]) -> Path:
    assert launch.run(case_folder, None, out, [*SETS, *sets]) in (launch.DONE, DOUBTFUL)
    return out


@pytest.fixture(scope="module")
def whole(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return run(
        folder, tmp_path_factory.mktemp("whole") / "run", ["checkpoint.every_s=0", "checkpoint.wall_min=0"]
    )


def test_books_tables_and_pictures_know_the_dumbbells(whole: Path) -> None:
    """Each weighs as much as two spheres of its size; the case has a ball, too, and three in a block."""
    material = summary(whole)["material"]
    with h5py.File(whole / "history.h5") as history:
        fed, removed = history["fed"], history["removed"]
        for table in (fed, removed):
            assert list(table.attrs["shapes"]) == ["dumbbell", "sphere"]
        assert fed["shape"][:].tolist() == [1, *np.zeros(len(fed["id"]) - 1)]
        kg, gone_kg = (
            SPHERES[table["shape"][:]] * sphere_kg(table["sieve_size_m"][:]) for table in (fed, removed)
        )
        exit_of = removed["exit"][:]
        assert history["bed/mass_kg"][0] == pytest.approx(kg[:4].sum(), rel=1e-12)
    assert material["fed"]["mass_kg"] == pytest.approx(kg.sum(), rel=1e-12)
    for number, book in enumerate(material["exits"].values()):
        assert book["number"] > 0
        assert book["mass_kg"] == pytest.approx(gone_kg[exit_of == number].sum(), rel=1e-12)
    last = meshio.read(sorted((whole / "particles").glob("*.vtu"))[-1]).point_data
    ratio = last["equivalent_diameter_m"] / last["sieve_size_m"]
    np.testing.assert_allclose(ratio, np.cbrt(SPHERES[last["shape"]]), rtol=1e-6)


def test_a_resumed_run_is_the_run_that_never_stopped(folder: Path, whole: Path, tmp_path: Path) -> None:
    stopped = run(folder, tmp_path / "run", ["checkpoint.every_s=0.071"])
    saved = sorted(each for each in (stopped / "checkpoints").iterdir() if each.name.isdigit())
    shutil.rmtree(saved[-1])
    assert resume(stopped, []) in (launch.DONE, DOUBTFUL)
    assert run_differences(whole, stopped) == []


def test_another_run_takes_them_over(whole: Path) -> None:
    for time_s in (None, 0.06):  # of a checkpoint, and of the pictures
        bed = read_run(whole, time_s)
        assert len(bed)
        assert set(bed.grains.shape_names) == {"dumbbell", "sphere"}


def test_a_solver_of_spheres_refuses_them(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    only_spheres = replace(liggghts.ADAPTER, clumps=False)
    monkeypatch.setattr(liggghts, "ADAPTER", only_spheres)
    monkeypatch.setattr(solvers, "adapter", solvers.adapter.__wrapped__)
    monkeypatch.setattr(numerics, "adapter", solvers.adapter)
    text = (case(tmp_path / "case") / "case.toml").read_text()
    problems = find_problems(load_case(tmp_path / "other", text, [*SHAPED, "particles.solver=liggghts"]))
    assert [problem.key for problem in problems] == [
        ("bed", "blocks", "coal", "shape"),
        ("bed", "feeds", "chute", "shape"),
    ]
    assert 'liggghts takes no grains of several spheres, such as "dumbbell"' in problems[0].what
    assert "spheres" in problems[0].hint
