"""``flipflow surface``: the size, the faults and the picture of a surface in a file."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import meshio
import numpy as np
import pytest
from typer.testing import CliRunner, Result

from orchestrator.cli.main import app
from tests.case.test_surfaces import CUBE_M, OUTWARD


def call(*words: object) -> Result:
    return CliRunner().invoke(app, ["surface", *map(str, words)], env={"COLUMNS": "200"})


def test_a_cube_without_lid_has_a_size_an_area_and_open_edges(tmp_path: Path) -> None:
    """A cube of 100 mm: five sides of 0.01 m2, and one triangle twice."""
    lid = np.isclose(CUBE_M[OUTWARD][:, :, 2], CUBE_M[:, 2].max()).all(axis=1)
    sides = OUTWARD[~lid]
    triangles = np.vstack([sides, sides[:1]])
    meshio.write(tmp_path / "box.obj", meshio.Mesh(1000 * CUBE_M, [("triangle", triangles)]))
    done = call(tmp_path / "box.obj", "--unit", "mm", "--out", tmp_path / "box.png")
    assert done.exit_code == 0, done.output
    assert "10 triangles, 8 corners" in done.output
    assert "size: 0.1 x 0.1 x 0.1 m" in done.output
    assert "area: 0.05 m2; open: 4 edges belong to one triangle alone" in done.output
    assert "healed: 1 double" in done.output
    picture = matplotlib.image.imread(tmp_path / "box.png")[:, :, :3]
    is_red = (picture[:, :, 0] > 0.7) & (picture[:, :, 1] < 0.4)
    assert is_red.sum() > 500, "open edges are red"


def test_a_closed_cube_has_a_volume_and_no_red_edge(tmp_path: Path) -> None:
    meshio.write(tmp_path / "cube.stl", meshio.Mesh(CUBE_M, [("triangle", OUTWARD)]))
    done = call(tmp_path / "cube.stl", "--unit", "m", "--scale", "2", "--out", tmp_path / "cube.png")
    assert done.exit_code == 0, done.output
    assert "area: 0.24 m2; closed: 0.008 m3 within" in done.output
    assert "healed: nothing" in done.output
    picture = matplotlib.image.imread(tmp_path / "cube.png")[:, :, :3]
    assert not ((picture[:, :, 0] > 0.7) & (picture[:, :, 1] < 0.4)).any()


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        (["cube.stl"], "give unit"),
        (["cube.stl", "--unit", "foot"], 'did you mean "ft"'),
        (["cube.stl", "--unit", "m", "--scale", "-1"], "greater than 0"),
        (["cube.stl", "--unit", "m", "--tolerance", "1 kg"], "--tolerance 1 kg"),
        (["cube.stl", "--unit", "m", "--out", "no/where.png"], "no/where.png"),
        (["cone.stl", "--unit", "m"], "no such file"),
    ],
)
def test_what_is_wrong_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], wanted: str
) -> None:
    meshio.write(tmp_path / "cube.stl", meshio.Mesh(CUBE_M, [("triangle", OUTWARD)]))
    monkeypatch.chdir(tmp_path)
    done = call(*words)
    assert done.exit_code == 2
    assert wanted in done.output
    assert not (tmp_path / "surface.png").exists()
