"""The script by which ParaView shows a run: it opens what is there, and ParaView runs it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from unittest.mock import MagicMock

import meshio
import numpy as np
import pytest

from orchestrator.output.records.run_folder import WALLS
from orchestrator.output.records.snapshots import (
    STATE,
    Series,
    particle_mesh,
    surface_mesh,
    write_mesh,
    write_state,
)
from orchestrator.ports import Motion, ParticleSnapshot
from tests.grains import spheres

COUNT = 5
LAST_S = 0.2
WALL = meshio.Mesh(2.0 * np.eye(3), [("triangle", np.array([[0, 1, 2]]))])
SEEN = f"""
from paraview import simple
exec(compile(open("{STATE}").read(), "{STATE}", "exec"))
shown = dict()
for (name, _), source in simple.GetSources().items():
    # to ask for the properties of what is not shown would show it
    is_shown = view.SMProxy.FindRepresentation(source.SMProxy, 0) is not None
    array = simple.GetDisplayProperties(source, view).ColorArrayName[1] if is_shown else None
    bar = simple.GetColorTransferFunction(array).RGBPoints if array else ()
    cells = source.GetDataInformation().GetNumberOfCells()
    shown[name] = [is_shown, cells, array, [*bar[:1], *bar[-4:-3]]]
print("SEEN", json.dumps([scene.AnimationTime, shown]))
simple.SaveScreenshot("seen.png", view)
"""


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """The folder of a run with one triangle of a panel, one of a wall, and five spheres, at three times."""
    surface, particles = Series(tmp_path, "surface", WALLS), Series(tmp_path, "particles")
    write_mesh(tmp_path / WALLS, WALL)
    triangle, at_rest = np.array([[0, 1, 2]]), np.zeros((COUNT, 3))
    for time_s in (0.0, LAST_S / 2, LAST_S):
        corners = Motion(np.eye(3), np.zeros((3, 3)))
        stretch = {"stretch_percent": np.array([time_s])}
        surface.add(time_s, surface_mesh(corners, triangle, np.zeros(1, dtype=np.int64), {}, stretch))
        velocity = np.outer(np.arange(COUNT) / (COUNT - 1), [time_s, 0.0, 0.0])
        position_m = at_rest + np.arange(COUNT)[:, None]
        sizes = spheres(np.full(COUNT, 0.5))
        orientation = np.tile([1.0, 0.0, 0.0, 0.0], (COUNT, 1))
        snapshot = ParticleSnapshot(
            np.arange(COUNT), position_m, velocity, at_rest, sizes, orientation=orientation
        )
        particles.add(time_s, particle_mesh(snapshot))
    write_state(tmp_path)
    return tmp_path


def test_it_opens_what_a_run_has(run: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each array that it names is in the files."""
    for without, wanted in (
        ((), {"surface", "particles"}),
        (("particles",), {"surface"}),
        (("surface",), set()),
    ):
        for series in without:
            shutil.rmtree(run / series)
        paraview = MagicMock()
        monkeypatch.setitem(sys.modules, "paraview", paraview)
        exec(compile((run / STATE).read_text(), str(run / STATE), "exec"), {"__file__": str(run / STATE)})
        opened = [Path(call.kwargs["FileName"]) for call in paraview.simple.PVDReader.call_args_list]
        assert {file.stem for file in opened} == wanted
        assert all(file.is_file() for file in opened)
        (wall,) = (
            call.kwargs["FileName"] for call in paraview.simple.XMLUnstructuredGridReader.call_args_list
        )
        assert wall == [str(run / WALLS)]
        for (_, (kind, array)), _ in paraview.simple.ColorBy.call_args_list:
            folder = run / ("surface" if kind == "CELLS" else "particles")
            mesh = meshio.read(next(folder.glob("*.vtu")))
            assert array in (mesh.cell_data if kind == "CELLS" else mesh.point_data)


@pytest.mark.process
@pytest.mark.skipif(
    shutil.which("pvpython") is None or "DISPLAY" not in os.environ,
    reason="no ParaView with a screen: apt-get install python3-paraview xvfb, and xvfb-run -a pytest",
)
def test_paraview_shows_panels_walls_and_particles(run: Path) -> None:
    """In colours from the smallest to the largest value of the last output time."""
    (run / "seen.py").write_text("import json\n" + SEEN)
    done = subprocess.run(
        ["pvpython", "--force-offscreen-rendering", "seen.py"], cwd=run, capture_output=True, text=True
    )
    line = next((line for line in done.stdout.splitlines() if line.startswith("SEEN")), "")
    assert line, done.stdout + done.stderr
    time_s, shown = json.loads(line.removeprefix("SEEN "))
    assert time_s == pytest.approx(LAST_S)
    assert shown["surface.pvd"][:2] == [False, 2]
    assert shown["panels"][:3] == [True, 1, "stretch_percent"]
    assert shown[WALLS][:2] == [True, 1]
    assert shown["particles.pvd"][:3] == [True, COUNT, "speed_m_per_s"]
    assert shown["particles.pvd"][3] == pytest.approx([0.0, LAST_S], rel=1e-6)
    assert (run / "seen.png").stat().st_size > 0
