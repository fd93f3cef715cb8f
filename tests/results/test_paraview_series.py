"""The lists of ParaView's series: whole after each snapshot, also where the disk is full."""

from __future__ import annotations

import resource
import signal
from pathlib import Path
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest

from orchestrator.output.records.snapshots import Series, walls_mesh, write_mesh
from orchestrator.output.report.rendering import snapshots
from orchestrator.ports.geometry import RigidVertices, TriangleSurface, shares_in, tetrahedron_m

POINT = meshio.Mesh(np.zeros((1, 3)), [("vertex", np.zeros((1, 1), dtype=int))])


def listed(folder: Path) -> list[tuple[float, str]]:
    """Return the times and files of the list, which must exist."""
    rows = ElementTree.parse(folder / "series.pvd").getroot().findall("*/DataSet")
    frames = [(float(row.get("timestep", "nan")), row.get("file", "")) for row in rows]
    assert all((folder / file).is_file() for _, file in frames)
    return frames


def test_the_list_is_whole_after_each_snapshot(tmp_path: Path) -> None:
    """The list is the same whether rows were added or all written anew; a list that was removed comes
    back."""
    series = Series(tmp_path, "series")
    for number in range(4):
        series.add(0.1 * number, POINT)
        assert [time_s for time_s, _ in listed(tmp_path)] == [0.1 * past for past in range(number + 1)]
    added = (tmp_path / "series.pvd").read_text()
    series.restore(series.save())
    assert (tmp_path / "series.pvd").read_text() == added
    (tmp_path / "series.pvd").unlink()
    series.add(0.4, POINT)
    assert len(listed(tmp_path)) == 5


def test_a_new_series_does_not_go_on_with_an_old_list(tmp_path: Path) -> None:
    for time_s in (1.0, 2.0):
        Series(tmp_path, "series").add(time_s, POINT)
        assert [found_s for found_s, _ in listed(tmp_path)] == [time_s]


def test_a_full_disk_leaves_the_list_as_it_was(tmp_path: Path) -> None:
    """The disk takes a part of the row, and refuses the rest."""
    series = Series(tmp_path, "series")
    for number in range(60):
        series.add(float(number), POINT)
    before = listed(tmp_path)
    room = (tmp_path / "series.pvd").stat().st_size + 10
    limits = resource.getrlimit(resource.RLIMIT_FSIZE)
    handler = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (room, limits[1]))
    try:
        with pytest.raises(OSError, match="No space left"):
            series.add(60.0, POINT)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        signal.signal(signal.SIGXFSZ, handler)
    assert listed(tmp_path) == before
    assert len(list((tmp_path / "series").iterdir())) == 60


@pytest.mark.parametrize("moves", [True, False])
def test_what_stands_still_is_listed_beside_each_time(tmp_path: Path, moves: bool) -> None:
    """The still part is a second part of the time, or the only one where nothing moves; the pictures take
    the first."""
    write_mesh(tmp_path / "walls.vtu", POINT)
    series = Series(tmp_path, "series", "walls.vtu", moves)
    for number in range(3):
        series.add(float(number), POINT)
    own = [f"series/series_{number:05d}.vtu" for number in range(3)]
    first = own if moves else ["walls.vtu"] * 3
    assert listed(tmp_path) == [
        (float(number), file)
        for number in range(3)
        for file in ([own[number], "walls.vtu"] if moves else ["walls.vtu"])
    ]
    assert [str(file.relative_to(tmp_path)) for _, file in snapshots(tmp_path, "series")] == first
    series.restore(series.save())
    assert (tmp_path / "walls.vtu").is_file()


def test_walls_are_written_as_they_are_drawn(tmp_path: Path) -> None:
    """One triangle of a panel and two of a wall that four points carry, at corners of its own."""
    corners_m = np.array([[0.0, 1.0, 0.0], [2.0, 1.0, 0.0], [2.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
    carriers_m = tetrahedron_m(corners_m)
    surface = TriangleSurface(
        np.vstack([np.eye(3), carriers_m]),
        np.array([[0, 1, 2], [7, 8, 9], [7, 9, 10]]),
        np.zeros(3, dtype=np.int64),
        np.array([0, -1, -1]),
        RigidVertices(np.full(4, 3), shares_in(carriers_m, corners_m)),
    )
    write_mesh(tmp_path / "walls.vtu", walls_mesh(surface, {"worn_depth_m": np.arange(11.0)}))
    mesh = meshio.read(tmp_path / "walls.vtu")
    assert mesh.points == pytest.approx(corners_m, abs=1e-6)
    assert mesh.cells_dict["triangle"].tolist() == [[0, 1, 2], [0, 2, 3]]
    assert mesh.point_data["worn_depth_m"].tolist() == [7.0, 8.0, 9.0, 10.0]
