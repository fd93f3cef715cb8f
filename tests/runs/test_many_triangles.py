"""The triangles of a rigid surface fill no disk: a wall of 2 and one of 5 000 leave the same bytes at each
output time."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest

from orchestrator.output.records.run_folder import HISTORY, WALLS
from tests.cases import CASE, case_folder
from tests.runs.outside import QUICK, flipflow, run_words

pytestmark = [pytest.mark.process, pytest.mark.solver]
CUTS = (1, 50)
WALL = """
[screen.surfaces.side]
stl = "wall.stl"
frame = "driving"
material = "PU"
"""
SETS = (*QUICK, "duration_s=0.01", "output.interval_s=0.002", "frames.solver=two-mass", "panel.solver=rigid")


def write_wall(file: Path, cuts: int) -> None:
    """Write an upright wall beside the panel, of ``cuts`` by ``cuts`` squares of two triangles each."""
    x_m, z_m = np.linspace(0.0, 0.3, cuts + 1), np.linspace(-0.02, 0.1, cuts + 1)
    points_m = np.array([[x, 0.22, z] for x in x_m for z in z_m])
    first = (np.arange(cuts)[:, None] * (cuts + 1) + np.arange(cuts)).ravel()
    triangles = np.concatenate([first[:, None] + [0, cuts + 1, cuts + 2], first[:, None] + [0, cuts + 2, 1]])
    meshio.write(file, meshio.Mesh(points_m, [("triangle", triangles)]), binary=True)


def run_with_wall(folder: Path, cuts: int) -> Path:
    case = case_folder(folder / "case", CASE + WALL)
    write_wall(case / "wall.stl", cuts)
    done = flipflow(*run_words(str(case), folder / "run", SETS))
    assert done.returncode == 0, done.stderr
    return folder / "run"


def sizes(run: Path) -> dict[str, int]:
    """Return the bytes of all files that grow with output times, or that a checkpoint has."""
    parts = [run / HISTORY, *(file for name in ("surface", "particles") for file in (run / name).iterdir())]
    parts += [run / "surface.pvd", run / "particles.pvd", *(run / "checkpoints").rglob("*.h5")]
    return {str(file.relative_to(run)): file.stat().st_size for file in parts}


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    return [run_with_wall(tmp_path_factory.mktemp(f"cuts{cuts}"), cuts) for cuts in CUTS]


def test_an_output_has_the_same_bytes_however_many_triangles(runs: list[Path]) -> None:
    few, many = map(sizes, runs)
    assert len([name for name in few if name.endswith(".vtu")]) == 2 * 6
    assert many == few


def test_the_triangles_are_written_once(runs: list[Path]) -> None:
    for run, cuts in zip(runs, CUTS, strict=True):
        assert len(meshio.read(run / WALLS).cells_dict["triangle"]) == 2 * cuts**2
