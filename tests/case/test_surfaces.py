"""STL files with every fault that is looked for."""

from __future__ import annotations

import os
import re
from pathlib import Path

import meshio
import numpy as np
import pytest

from meshes.side_walls import side_walls
from orchestrator.case.deck.heal import heal
from orchestrator.case.deck.panels import walls
from orchestrator.case.deck.stl import Facets, UnreadableSurface, read
from tests.cases import complaints, keys_and_kinds, loaded, only_complaint, problems

CASES = Path(__file__).parents[2] / "cases"
CUBE_M = np.array([(x, y, z) for x in (0.0, 0.1) for y in (0.0, 0.1) for z in (0.0, 0.1)])
OUTWARD = np.array(
    [
        *((0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1)),
        *((2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3)),
    ]
)
WALL = 'screen.surfaces.wall={stl="wall.stl", frame="driving", material="PU"}'


def facets(triangles: np.ndarray) -> Facets:
    return Facets(CUBE_M, triangles, np.zeros((len(triangles), 3)))


def write(folder: Path, points: np.ndarray = CUBE_M, triangles: np.ndarray = OUTWARD) -> None:
    meshio.stl.write(folder / "wall.stl", meshio.Mesh(points, [("triangle", triangles)]))


def test_a_cube_with_normals_outwards_is_right() -> None:
    healed = heal(facets(OUTWARD))
    assert (healed.line, healed.open_edges) == ("", 0)
    assert healed.volume_m3 == pytest.approx(1e-3)
    assert (healed.triangles == OUTWARD).all()


@pytest.mark.parametrize(
    ("triangles", "healing"),
    [
        (OUTWARD[:, ::-1], "12 triangles turned over"),
        (np.vstack([OUTWARD[:1, ::-1], OUTWARD[1:]]), "1 triangles turned over"),
        (np.vstack([OUTWARD, [(0, 1, 1)]]), "1 triangles without area removed"),
        (np.vstack([OUTWARD, OUTWARD[3:5, [2, 1, 0]]]), "2 double triangles removed"),
    ],
)
def test_a_fault_is_healed_to_the_clean_cube(triangles: np.ndarray, healing: str) -> None:
    healed = heal(facets(triangles))
    assert healed.line == healing
    normal = np.cross(*np.diff(healed.position_m[healed.triangles], axis=1).transpose(1, 0, 2))
    assert np.sort(healed.triangles) == pytest.approx(np.sort(OUTWARD))
    assert normal == pytest.approx(np.cross(*np.diff(CUBE_M[OUTWARD], axis=1).transpose(1, 0, 2)))


def test_three_sheets_at_an_edge_are_left_and_counted() -> None:
    healed = heal(facets(np.vstack([OUTWARD, [(0, 1, 7)]])))
    assert healed.line == "2 edges have three or more triangles"
    assert len(healed.triangles) == 13


def test_a_needle_is_removed_and_corners_are_joined_to_rounding() -> None:
    """A needle of 10 nm on a cube of 0.1 m, and each triangle with corners of its own."""
    needle = np.vstack([CUBE_M, (CUBE_M[0] + CUBE_M[1]) / 2 + [1e-8, 0.0, 0.0]])
    triangles = np.vstack([OUTWARD, [(0, 1, 8)]])
    assert heal(Facets(needle, triangles, np.zeros((13, 3)))).line == "1 triangles without area removed"
    apart = CUBE_M[OUTWARD].reshape(-1, 3) + np.random.default_rng(1).uniform(-2e-9, 2e-9, (36, 3))
    healed = heal(Facets(apart, np.arange(36).reshape(-1, 3), np.zeros((12, 3))))
    assert (len(healed.position_m), healed.open_edges) == (8, 0)


def test_a_band_with_one_side_stays_as_it_is() -> None:
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    way = np.stack([np.cos(angle / 2) * np.cos(angle), np.cos(angle / 2) * np.sin(angle), np.sin(angle / 2)])
    middle = np.stack([np.cos(angle), np.sin(angle), 0 * angle])
    points = np.concatenate([(middle - 0.3 * way).T, (middle + 0.3 * way).T])
    edge = [(k, k + 12) for k in range(12)] + [(12, 0)]
    rows = [t for k in range(12) for t in ((*edge[k], edge[k + 1][0]), (edge[k][1], *edge[k + 1][::-1]))]
    healed = heal(Facets(points, np.array(rows), np.zeros((24, 3))))
    assert (healed.triangles == rows).all()


@pytest.mark.parametrize(
    "head", [b"solid from somewhere".ljust(80, b"\0"), b"COLOR=\xff\0\0".ljust(80, b" ")]
)
def test_binary_files_with_odd_heads_and_tails(tmp_path: Path, head: bytes) -> None:
    meshio.stl.write(tmp_path / "wall.stl", meshio.Mesh(CUBE_M, [("triangle", OUTWARD)]), binary=True)
    body = (tmp_path / "wall.stl").read_bytes()[80:]
    for tail in (b"", b"\0\0", b"\r\n", b"made by a program" * 9):
        (tmp_path / "wall.stl").write_bytes(head + body + tail)
        assert len(read(tmp_path, "wall.stl").triangles) == 12


def test_texts_with_a_mark_before_and_padding_behind(tmp_path: Path) -> None:
    write(tmp_path)
    text = (tmp_path / "wall.stl").read_bytes()
    for odd in (b"\xef\xbb\xbf" + text, text + b"\0" * 12, text + b"\x1a", text.replace(b"\n", b"\r\n")):
        (tmp_path / "wall.stl").write_bytes(odd)
        assert len(read(tmp_path, "wall.stl").triangles) == 12
    (tmp_path / "wall.stl").write_bytes(text.replace(b".", b","))
    with pytest.raises(UnreadableSurface, match="decimal comma"):
        read(tmp_path, "wall.stl")


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    file = tmp_path / "wall.stl"
    for content, reason in (
        (None, "such"),
        (b"", "cut"),
        (b"solid empty\nendsolid\n", "triangles"),
        (b"this is\nno stl file\n", "cut"),
        (b"solid words\nendsolid words\n words\n", r"\b3: 'words'"),
        (b"solid\nvertex 1 2 3\nendsolid\n", r"\b2: 'vertex"),
        (b"solid\n facet normal 0 0 one\nendsolid\n", r"\b2: 'facet"),
        (b"solid\n facet normal 0 0 1\n endfacet\nendsolid\n", r"\b3: "),
        (b"\0" * 84, "triangles"),
        (bytes(range(256)) * 4, "cut"),
        (b"\0" * 80 + b"\x02\0\0\0" + b"\0" * 50, "cut"),  # one of two is missing
        (b"\0" * 80 + b"\xff\xff\xff\xff" + b"\0" * 50, "cut"),  # 200 GB are
    ):
        if content is not None:
            file.write_bytes(content)
        with pytest.raises(UnreadableSurface, match=reason):
            read(tmp_path, file.name)


@pytest.mark.parametrize("binary", [False, True])
def test_a_file_that_is_cut_off_anywhere(tmp_path: Path, binary: bool) -> None:
    """A cut where a triangle ends is found, too, which would leave a wall with a hole."""
    mesh = meshio.Mesh(CUBE_M, [("triangle", OUTWARD)])
    meshio.stl.write(tmp_path / "wall.stl", mesh, binary=binary)
    whole = (tmp_path / "wall.stl").read_bytes()
    assert len(read(tmp_path, "wall.stl").triangles) == 12
    for kept in range(0, whole.rindex(b"endsolid") if not binary else len(whole), 7):
        (tmp_path / "wall.stl").write_bytes(whole[:kept])
        with pytest.raises(UnreadableSurface, match="is cut off"):
            read(tmp_path, "wall.stl")


@pytest.mark.parametrize("binary", [False, True])
def test_a_file_is_read_as_it_was_written(tmp_path: Path, binary: bool) -> None:
    """Positions to the digits of the file, each corner once, and the normals that it states."""
    meshio.stl.write(tmp_path / "wall.stl", meshio.Mesh(CUBE_M, [("triangle", OUTWARD)]), binary=binary)
    surface, by_meshio = read(tmp_path, "wall.stl"), meshio.stl.read(tmp_path / "wall.stl")
    assert surface.position_m == pytest.approx(by_meshio.points, abs=0)
    assert (surface.triangles == by_meshio.cells_dict["triangle"]).all()
    corners = CUBE_M[OUTWARD]
    outward = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert surface.normal == pytest.approx(100 * outward, abs=1e-6)
    assert heal(surface).line == ""


def test_a_text_of_two_solids_in_capitals(tmp_path: Path) -> None:
    write(tmp_path)
    text = (tmp_path / "wall.stl").read_text()
    (tmp_path / "wall.stl").write_text(text.upper() + "\n" + text.replace("0.1", "0.2"))
    assert len(read(tmp_path, "wall.stl").triangles) == 24


def test_a_file_of_somebody_else(tmp_path: Path) -> None:
    """A case reads what lies in its folder, nothing else."""
    folder = tmp_path / "case"
    folder.mkdir()
    write(tmp_path)
    (folder / "link.stl").symlink_to(tmp_path / "wall.stl")
    for name in ("../wall.stl", str(tmp_path / "wall.stl"), "link.stl", "levels/../../wall.stl"):
        (folder / "levels").mkdir(exist_ok=True)
        with pytest.raises(UnreadableSurface, match="outside"):
            read(folder, name)
    for name in ("/dev/zero", "levels", "x" * 5000, "nul\0.stl", "/etc"):
        with pytest.raises(UnreadableSurface):
            read(folder, name)
    (folder / "large.stl").touch()
    os.truncate(folder / "large.stl", 10**12)  # takes no room on the disk
    with pytest.raises(UnreadableSurface, match="larger"):
        read(folder, "large.stl")


def test_a_surface_of_a_case_is_checked_and_read(tmp_path: Path) -> None:
    assert 'screen.surfaces.wall.stl: "wall.stl": no such file' in complaints(tmp_path, WALL)[0]
    write(tmp_path, CUBE_M + np.array([0.4, 0.0, 0.0]))
    assert complaints(tmp_path, WALL) == []
    (wall,) = walls(loaded(tmp_path, [WALL]).case, tmp_path)
    assert wall.frame == "driving"
    assert np.ptp(wall.position_m, axis=0) == pytest.approx([0.1, 0.1, 0.1])


def test_a_surface_in_mm_or_out_of_the_domain(tmp_path: Path) -> None:
    write(tmp_path, 1000 * CUBE_M)
    in_mm = problems(tmp_path, WALL)[0]
    write(tmp_path, CUBE_M + np.array([2.0, 0.0, 0.0]))
    outside = problems(tmp_path, WALL)[0]
    assert keys_and_kinds([in_mm, outside]) == ["screen.surfaces.wall.stl: misplaced"] * 2
    assert "mm" in re.findall(r"\w+", in_mm.hint)
    assert "1.1" in outside.what.split()


def test_a_particle_in_a_wall(tmp_path: Path) -> None:
    write(tmp_path, CUBE_M + np.array([0.155, 0.05, 0.0]))
    problem = problems(tmp_path, WALL)[0]
    assert keys_and_kinds([problem]) == ["bed.particles.ball.position_m: misplaced"]
    assert {"0.005", "wall"} <= {*problem.what.split()}


def test_the_quickstarts_walls_are_those_of_the_generator(tmp_path: Path) -> None:
    mesh = side_walls((-0.019, 0.657), (0.0, 0.2), (-0.06, 0.16))
    meshio.stl.write(tmp_path / "walls.stl", mesh)
    stored = CASES / "quickstart" / "walls.stl"
    assert (tmp_path / "walls.stl").read_text() == stored.read_text()


def test_a_particle_inside_a_closed_body_is_refused(tmp_path: Path) -> None:
    """A particle that touches none of the body's faces is refused, too; beside the body, and in one that is
    open, there is no problem."""
    write(tmp_path)
    trapped = "bed.particles.ball.position_m=[0.05, 0.05, 0.05]"
    complaint = only_complaint(tmp_path, WALL, trapped)
    assert '"ball" at [0.05, 0.05, 0.05] is inside surface wall, a closed body' in complaint
    assert not complaints(tmp_path, WALL, "bed.particles.ball.position_m=[0.15, 0.05, 0.05]")
    write(tmp_path, triangles=OUTWARD[2:])
    assert not complaints(tmp_path, WALL, trapped)


def test_a_closed_body_beside_an_open_sheet_in_one_file(tmp_path: Path) -> None:
    """A cavity with walls on all sides is no inside of a body."""
    trapped = "bed.particles.ball.position_m=[0.05, 0.05, 0.05]"
    beside_m, around_m = CUBE_M + np.array([0.3, 0.0, 0.0]), 3 * CUBE_M - 0.1
    write(tmp_path, np.vstack([CUBE_M, beside_m]), np.vstack([OUTWARD, OUTWARD[:2] + 8]))
    assert "is inside surface wall, a closed body" in only_complaint(tmp_path, WALL, trapped)
    write(tmp_path, np.vstack([CUBE_M, around_m]), np.vstack([OUTWARD[:, ::-1], OUTWARD + 8]))
    assert not [line for line in complaints(tmp_path, WALL, trapped) if "closed body" in line]
