"""Surfaces in files of each format: the size that the file's unit means, and refusals of damaged files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gmsh
import meshio
import numpy as np
import pytest

from orchestrator.case.deck import surface_file
from orchestrator.case.deck.heal import Healed
from orchestrator.case.deck.stl import UnreadableSurface
from orchestrator.case.deck.surface_file import read_surface
from orchestrator.case.tables.screen import Surface
from tests.case.test_surfaces import CUBE_M, OUTWARD
from tests.cases import complaints, loaded

RADIUS_MM, LENGTH_MM = 50.0, 200.0


def surface(folder: Path, name: str, **keys: Any) -> Healed:
    return read_surface(Surface(file=name, frame="ground", material="PU", **keys), folder)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a cube in each format of meshes, and a rod in each format of CAD, all in mm."""
    folder = tmp_path_factory.mktemp("made")
    for name in ("cube.obj", "cube.ply", "cube.vtk", "cube.stl"):
        meshio.write(folder / name, meshio.Mesh(1000 * CUBE_M, [("triangle", OUTWARD)]))
    gmsh.initialize(readConfigFiles=False, interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.occ.addCylinder(0, 0, 0, 0, 0, LENGTH_MM, RADIUS_MM)
    gmsh.model.occ.synchronize()
    for ending in ("step", "iges"):
        gmsh.write(str(folder / f"rod.{ending}"))
    gmsh.clear()
    gmsh.model.occ.addBox(0, 0, 0, 100, 100, 100)
    gmsh.model.occ.synchronize()
    gmsh.option.setNumber("Mesh.MeshSizeMin", 200)
    gmsh.model.mesh.generate(2)
    gmsh.write(str(folder / "cube.msh"))
    gmsh.finalize()
    return folder


@pytest.mark.parametrize("ending", ["obj", "ply", "vtk", "stl", "msh"])
def test_a_cube_in_mm_is_the_cube(made: Path, ending: str) -> None:
    healed = surface(made, f"cube.{ending}", unit="mm")
    assert np.ptp(healed.position_m, axis=0) == pytest.approx([0.1, 0.1, 0.1], rel=1e-6)
    assert healed.volume_m3 == pytest.approx(1e-3, rel=1e-6)
    with pytest.raises(UnreadableSurface, match="unit"):
        surface(made, f"cube.{ending}")


@pytest.mark.parametrize("ending", ["step", "iges"])
@pytest.mark.parametrize("tolerance_m", [1e-3, 1e-4])
def test_cad_is_in_m_and_as_near_as_its_tolerance(made: Path, ending: str, tolerance_m: float) -> None:
    """The middle of a chord is the point of it that is farthest from its arc."""
    healed = surface(made, f"rod.{ending}", tolerance_m=tolerance_m)
    assert np.ptp(healed.position_m[:, 2]) == pytest.approx(LENGTH_MM / 1000, rel=1e-6)
    rim_m = healed.position_m[np.abs(healed.position_m[:, 2]) < 1e-6, :2]
    assert np.hypot(*rim_m.T) == pytest.approx(0.05, rel=1e-6)
    gap = np.diff(np.sort(np.arctan2(*rim_m.T))).max()
    assert 0.05 * (1 - np.cos(gap / 2)) <= 1.01 * tolerance_m
    if ending == "iges":  # Its faces do not know their neighbours, and have points of their own along edges.
        return
    assert healed.open_edges == 0
    assert healed.volume_m3 == pytest.approx(np.pi * 0.05**2 * 0.2, rel=2 * tolerance_m / 0.05)
    with pytest.raises(UnreadableSurface, match="unit"):
        surface(made, f"rod.{ending}", unit="mm")


def test_a_file_is_scaled_then_turned_then_moved(made: Path) -> None:
    healed = surface(
        made, "cube.obj", unit="mm", scale=2.0, rotation_deg=(0.0, 0.0, 90.0), move_m=(1.0, 0.0, 0.5)
    )
    assert healed.position_m.min(axis=0) == pytest.approx([0.8, 0.0, 0.5])
    assert healed.position_m.max(axis=0) == pytest.approx([1.0, 0.2, 0.7])
    assert healed.line == ""


def test_units_that_are_not_said_are_asked_for(made: Path, tmp_path: Path) -> None:
    step = (made / "rod.step").read_text()
    (tmp_path / "rod.step").write_text(step.replace("LENGTH_UNIT()", "ITS_UNIT()"))
    iges = (made / "rod.iges").read_text()
    (tmp_path / "rod.iges").write_text(iges.replace(",1.,2,2HMM,", ",1.,3,2HXX,"))
    for name in ("rod.step", "rod.iges"):
        with pytest.raises(UnreadableSurface, match="unit of length"):
            surface(tmp_path, name)


@pytest.mark.parametrize("name", ["cube.obj", "cube.ply", "cube.vtk", "cube.msh", "rod.step", "rod.iges"])
def test_a_damaged_file_is_read_or_refused(made: Path, tmp_path: Path, name: str) -> None:
    """Cut off, or with other bytes: whatever the library does, the answer is a surface or one sentence."""
    whole, random = (made / name).read_bytes(), np.random.default_rng(3)
    keys = {} if name.startswith("rod") else {"unit": "mm"}
    for trial in range(3):
        spoilt = bytearray(whole[: len(whole) // 2] if trial == 0 else whole)
        for place in random.integers(0, len(spoilt), 20 * trial):
            spoilt[place] = random.integers(0, 256)
        (tmp_path / name).write_bytes(spoilt)
        text = answer(tmp_path, name, keys)
        assert text.isprintable()
        assert text


def answer(folder: Path, name: str, keys: dict[str, Any]) -> str:
    try:
        return f"{len(surface(folder, name, **keys).triangles)} triangles"
    except UnreadableSurface as error:
        return str(error)


def test_too_many_triangles_are_refused_with_their_number(
    made: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(surface_file, "MOST_TRIANGLES", 10)
    with pytest.raises(UnreadableSurface, match="12 triangles"):
        surface(made, "cube.obj", unit="mm", scale=1.5)


def test_files_of_other_kinds_and_faces_that_cannot_be_read(tmp_path: Path) -> None:
    (tmp_path / "wall.dwg").write_text("x")
    (tmp_path / "wall.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf -3 -2 -1\n")
    (tmp_path / "dent.obj").write_text("v 2 0 0\nv 1 .2 0\nv 1 2 0\nv 0 1 0\nv 0 0 0\nf 1 2 3 4 5\n")
    for name, why in (("wall.dwg", "format"), ("wall.obj", "absolute"), ("dent.obj", "dent")):
        with pytest.raises(UnreadableSurface, match=why):
            surface(tmp_path, name, unit="m")


def test_a_case_takes_a_file_of_cad_and_its_run_keeps_it(made: Path, tmp_path: Path) -> None:
    (tmp_path / "rod.step").write_bytes((made / "rod.step").read_bytes())
    rod = 'screen.surfaces.rod={file="rod.step", frame="driving", material="PU", move_m=[0.5, 0.0, -0.1]}'
    assert complaints(tmp_path, rod) == []
    assert loaded(tmp_path, [rod]).case.screen.surfaces["rod"].move_m == (0.5, 0.0, -0.1)
