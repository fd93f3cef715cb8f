"""Files of particles of other programs: each holds the same particles as its clean twin, or asks."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import meshio
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from orchestrator.case.bed.bed_table import read_table
from orchestrator.case.bed.saved_bed import UnreadableBed
from orchestrator.case.file import particle_files
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.case.tables.case import Case
from tests.cases import load_case, loaded

PLACES = [(0.1, 0.1, 0.02), (0.15, 0.1, 0.0305)]
RADII = [0.0025, 0.005]
DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
1
ITEM: BOX BOUNDS ff ff ff
0 1
0 1
0 1
ITEM: ATOMS id type x y z radius
1 1 9 9 9 9
ITEM: TIMESTEP
100
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS ff ff ff
0 0.5
0 0.4
-0.1 0.1
ITEM: ATOMS id type x y z ix vx vy vz fx fy fz omegax omegay omegaz radius
7 1 0.1 0.1 0.02 0 0 0 -1 5 5 5 1 2 3 0.0025
3 1 0.15 0.1 0.0305 0 0 0 -2 5 5 5 0 0 0 0.005
"""
DATA = """LIGGGHTS data file

2 atoms
1 atom types

0 1 xlo xhi
0 1 ylo yhi
0 1 zlo zhi

Atoms # granular

7 1 0.005 1430 0.1 0.1 0.02
3 1 0.010 1430 0.15 0.1 0.0305 0 0 0

Velocities

3 0 0 -2 0 0 0
7 0 0 -1 1 2 3
"""
TWINS = {
    "yade.txt": "#x y z r\n0.1\t0.1\t0.02\t0.0025\n0.15\t0.1\t0.0305\t0.005\n",
    "yade-materials.txt": "#format x_y_z_r\n# x y z r\n0.1 0.1 0.02 0.0025\n0.15 0.1 0.0305 0.005\n",
    "yade-alone.txt": "#format x_y_z_r\n0.1\t0.1\t0.02\t0.0025\n0.15\t0.1\t0.0305\t0.005\n",
    "yade-one.txt": "#format x_y_z_r_matId\n0.1\t0.1\t0.02\t0.0025\t0\n0.15\t0.1\t0.0305\t0.005\t0\n",
    "yade-attrs.txt": "#format x_y_z_r_attrs\n# vx vy vz\n0.1 0.1 0.02 0.0025 0 0 -1\n"
    "0.15 0.1 0.0305 0.005 0 0 -2\n",
    "dump.liggghts": DUMP,
    "dump.scaled": DUMP.replace("x y z ix", "xs ys zs ix")
    .replace("0.1 0.1 0.02", "0.2 0.25 0.6")
    .replace("0.15 0.1 0.0305", "0.3 0.25 0.6525"),
    "dump.cgs": DUMP.replace("ITEM: TIMESTEP\n100", "ITEM: UNITS\ncgs\nITEM: TIMESTEP\n100"),
    "data.gran": DATA,
    "paraview.csv": '"radius","id","v:0","v:1","v:2","Points:0","Points:1","Points:2"\n'
    "0.0025,0,0,0,-1,0.1,0.1,0.02\n0.005,1,0,0,-2,0.15,0.1,0.0305\n",
    "paraview-later.csv": '"Point ID","radius","Points_0","Points_1","Points_2","Points_Magnitude"\n'
    "0,0.0025,0.1,0.1,0.02,0.2\n1,0.005,0.15,0.1,0.0305,0.2\n",
    "german.csv": "x [mm];y [mm];z [mm];Durchmesser [mm];Werkstoff\n100;100;20;5;coal\n"
    "150;100;30,5;10;coal\n",
    "rocky.csv": "Particle X-Coordinate [mm],Particle Y-Coordinate [mm],Particle Z-Coordinate [mm],"
    "Particle Size [mm]\n100,100,20,5\n150,100,30.5,10\n",
    "edem.csv": "EDEM export\nTime,0.5\n\nParticle ID,Position X (m),Position Y (m),Position Z (m),"
    "Particle Radius (m)\n1,0.1,0.1,0.02,0.0025\n2,0.15,0.1,0.0305,0.005\n",
    "excel.csv": "sep=;\nx [m];y [m];z [m];d [mm];Material\n0,1;0,1;0,02;5;coal\n0,15;0,1;0,0305;10;coal\n",
}
UNITLESS = "x,y,z,radius\n0.1,0.1,0.02,0.0025\n0.15,0.1,0.0305,0.005\n"


def case_of(folder: Path) -> Case:
    return loaded(folder / "case").case


def bed_of(folder: Path, text: str, name: str = "bed.csv", case: Case | None = None) -> CarriedBed:
    (folder / name).write_text(text)
    return read_table(folder / name, case or case_of(folder))


def same(bed: CarriedBed) -> None:
    assert bed.position_m.tolist() == [[*place] for place in PLACES]
    assert bed.grains.sieve_size_m.tolist() == [2 * radius for radius in RADII]
    assert bed.materials == ("coal",)


@pytest.mark.parametrize("name", [name for name in TWINS if name not in ("dump.cgs", "dump.scaled")])
def test_each_file_holds_the_same_particles(tmp_path: Path, name: str) -> None:
    """To the last bit; coal is the only material with a contact with itself."""
    same(bed_of(tmp_path, TWINS[name], name))


def test_scaled_places_and_other_units(tmp_path: Path) -> None:
    scaled = bed_of(tmp_path, TWINS["dump.scaled"], "dump.scaled")
    np.testing.assert_allclose(scaled.position_m, PLACES, rtol=1e-14)
    unwrapped = bed_of(tmp_path, TWINS["dump.scaled"].replace("xs ys zs", "xsu ysu zsu"), "dump.scaled")
    np.testing.assert_array_equal(unwrapped.position_m, scaled.position_m)
    in_cm = bed_of(
        tmp_path, TWINS["dump.cgs"].replace("0.0025\n", "0.25\n").replace("0.005\n", "0.5\n"), "dump.cgs"
    )
    np.testing.assert_allclose(in_cm.position_m, np.array(PLACES) / 100)
    np.testing.assert_allclose(in_cm.velocity_m_per_s[:, 2], [-0.01, -0.02])
    np.testing.assert_allclose(in_cm.grains.sieve_size_m, [0.005, 0.01])


@pytest.mark.parametrize(("text", "name"), [(DUMP, "dump"), (DATA, "data")])
def test_motion_comes_along(tmp_path: Path, text: str, name: str) -> None:
    """Of the last time step; velocities of a data file go by the ids."""
    bed = bed_of(tmp_path, text, name)
    assert bed.velocity_m_per_s[:, 2].tolist() == [-1.0, -2.0]
    assert bed.spin_rad_per_s.tolist() == [[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]]
    assert ("time steps" in bed.note) == (name == "dump")


@pytest.mark.parametrize("suffix", ["vtu", "vtk"])
def test_a_file_for_paraview(tmp_path: Path, suffix: str) -> None:
    """YADE's names, radii and linVelVec."""
    data = {"radii": np.array(RADII), "linVelVec": np.array([[0.0, 0, -1], [0, 0, -2]])}
    mesh = meshio.Mesh(np.array(PLACES), [("vertex", np.array([[0], [1]]))], point_data=data)
    mesh.write(tmp_path / f"bed.{suffix}")
    bed = read_table(tmp_path / f"bed.{suffix}", case_of(tmp_path))
    np.testing.assert_allclose(bed.position_m, PLACES, rtol=1e-6)
    np.testing.assert_allclose(bed.grains.sieve_size_m, [0.005, 0.01])
    assert bed.velocity_m_per_s[:, 2].tolist() == [-1.0, -2.0]


def test_a_file_for_paraview_that_ends_too_early(tmp_path: Path) -> None:
    """VTK reads what is there."""
    head = b"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\nPOINTS 2 float\n"
    radii = b"\nPOINT_DATA 2\nSCALARS radius float 1\nLOOKUP_TABLE default\n"
    whole = head + np.array(PLACES, ">f4").tobytes() + radii + np.array(RADII, ">f4").tobytes() + b"\n"
    file = tmp_path / "bed.vtk"
    file.write_bytes(whole)
    assert len(read_table(file, case_of(tmp_path))) == 2
    for length in (len(head) + 10, len(whole) - 6):
        file.write_bytes(whole[:length])
        with pytest.raises(UnreadableBed, match="whole"):
            read_table(file, case_of(tmp_path))


def test_a_file_over_which_vtk_takes_too_long_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """VTK reads in a process of its own, which may hang or crash."""
    file = tmp_path / "bed.vtu"
    meshio.Mesh(np.array(PLACES), [("vertex", np.array([[0], [1]]))], point_data={"radii": RADII}).write(file)
    assert len(read_table(file, case_of(tmp_path))) == 2
    monkeypatch.setattr(particle_files, "LONGEST_S", 0.01)
    with pytest.raises(UnreadableBed, match="whole"):
        read_table(file, case_of(tmp_path))


@pytest.mark.parametrize(
    ("text", "clue"),
    [
        (UNITLESS, r"m or mm\? columns\."),
        ("x_m,y_m,z_m,size_m,material\n0.1,0.1,0.02,0.005,coal\n", r"'size_m'.*radius or a diameter\?"),
        ("x_m,y_m,z_m,r_m,d_m\n0.1,0.1,0.02,0.0025,0.005\n", "a radius and a diameter"),
        ("x_m,y_m,z_m,d_m,type\n0.1,0.1,0.02,0.005,1\n0.2,0.1,0.02,0.005,2\n", r"bed\.material = \{1 = "),
        ("#format x_y_z_r_matId\n0.1 0.1 0.02 0.0025 0\n0.2 0.1 0.02 0.0025 1\n", r"bed\.material = \{0 = "),
        ("x_m,y_m,z_m,d_m,d50\n0.1,0.1,0.02,0.005,1\n", "'d50'.*ignore"),
        ("x_m,y_m,z_m,d_m\n100,100,20,5\n", "mm"),
        ("#x y z r clumpId\n0.1 0.1 0.02 0.0025 4\n", "clumps"),
        (
            "x_m,y_m,z_m,Korn [mm]\n0.1,0.1,0.02,5\n",
            r"columns\.\"Korn \[mm\]\" = \"sieve size / mm\" would name it",
        ),
        (DUMP.replace("radius\n7", "fuzz\n7"), r"\"sieve_size_m\"; have it written"),
        (DUMP.replace("ATOMS\n2", "ATOMS\n3"), "2 of 3"),
        (DUMP.replace("radius\n7", "shapex\n7"), "not spheres"),
        (DUMP.replace("ITEM: TIMESTEP\n100", "ITEM: UNITS\nlj\nITEM: TIMESTEP\n100"), '"lj"'),
        (DATA.replace("# granular", ""), "Atoms # sphere"),
        (DATA.replace("# granular", "# atomic"), '"atomic"'),
    ],
)
def test_what_is_unsure_is_asked(tmp_path: Path, text: str, clue: str) -> None:
    with pytest.raises(UnreadableBed, match=clue):
        bed_of(tmp_path, text)


@pytest.mark.parametrize("suffix", ["pvd", "pvtu"])
def test_a_file_that_only_names_others(tmp_path: Path, suffix: str) -> None:
    with pytest.raises(UnreadableBed, match=r"names other files.*\.vtu"):
        bed_of(tmp_path, '<?xml version="1.0"?>\n<VTKFile/>\n', f"bed.{suffix}")


def test_a_case_answers(tmp_path: Path) -> None:
    """What columns are, and of which material each type is."""
    text = (
        UNITLESS.replace("radius", "size,type").replace(".0025\n", ".005,1\n").replace("0.005\n", "0.01,2\n")
    )
    columns = 'bed.columns={x="x / m", y="y / m", z="z / m", size="diameter / m"}'
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / "bed.csv").write_text(text)
    carried = load_case(
        folder, overrides=["bed.table=bed.csv", columns, 'bed.material={1="coal", 2="PU"}']
    ).case.bed.carried
    assert carried is not None
    assert carried.materials == ("PU", "coal")
    assert carried.grains.sieve_size_m.tolist() == [0.005, 0.01]


def spoilt(text: str, draw: Callable[[st.SearchStrategy[int]], int]) -> bytes:
    data = bytearray(text.encode())
    for _ in range(draw(st.integers(1, 4))):
        place = draw(st.integers(0, len(data) - 1))
        data[place : place + draw(st.integers(0, 30))] = bytes([draw(st.integers(0, 255))])
    return bytes(data)


@settings(deadline=None, max_examples=100, suppress_health_check=[*HealthCheck])
@given(data=st.data(), name=st.sampled_from([*TWINS]))
def test_a_damaged_file_is_read_or_refused(data: st.DataObject, name: str, tmp_path: Path) -> None:
    if not (tmp_path / "case").exists():
        case_of(tmp_path)
    (tmp_path / name).write_bytes(spoilt(TWINS[name], data.draw))
    with suppress(UnreadableBed):
        read_table(tmp_path / name, loaded(tmp_path / "case").case)
