"""Beds from runs and from tables: what is read, what does not fit, and what is pushed out."""

from __future__ import annotations

import json
from pathlib import Path

import meshio
import numpy as np
import pandas as pd
import pytest
import tomli_w

from orchestrator.case.bed import saved_bed
from orchestrator.case.bed.carry import read_run
from orchestrator.case.bed.contact_times import impact_speed_m_per_s
from orchestrator.case.bed.grains import sieve_sizes_m
from orchestrator.case.bed.push_out import SETTLED, overlapping_pairs, push_out
from orchestrator.case.bed.sources import initial_particles
from orchestrator.case.file.errors import dotted_key
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.output.records.run_folder import changed_files, create_run_folder, resolved_case
from orchestrator.output.records.snapshots import Series, particle_mesh
from orchestrator.ports import Array, ParticleSnapshot
from orchestrator.ports.geometry import overlap_m
from orchestrator.ports.plans import ParticleList
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.scene.scene import bed_kg
from orchestrator.views.openings import sizes_m
from tests.cases import (
    CASE,
    case_folder,
    complaints,
    contact,
    grains,
    keys_and_kinds,
    kinds,
    load_case,
    loaded,
    only_complaint,
    problems,
)
from tests.grains import spheres

FLOOR = np.array([[[-1, -1, 0], [1, -1, 0], [0, 1, 0]]], dtype=float)
UP = np.array([0.0, 0.0, 1.0])
# the panel's upper side is at z = 0
ROWS = pd.DataFrame(
    {
        "x_m": [0.10, 0.1195, 0.20],
        "y_m": [0.10, 0.10, 0.10],
        "z_m": [0.0099, 0.0101, 0.02],
        "sieve_size_m": [0.02, 0.02, 0.01],
        "material": ["coal", "coal", "coal"],
        "vz_m_per_s": [0.0, -0.5, 2.0],
    }
)


def write_table(folder: Path, rows: pd.DataFrame = ROWS, name: str = "bed.csv") -> str:
    case_folder(folder)
    file = folder / name
    if name.endswith(".csv"):
        rows.to_csv(file, index=False)
    else:
        rows.to_parquet(file)
    return f"bed.table={name}"


@pytest.mark.smoke
@pytest.mark.parametrize("name", ["bed.csv", "bed.parquet"])
def test_a_table_replaces_the_particles_that_the_case_describes(tmp_path: Path, name: str) -> None:
    """Settled spheres touch each other and the panel, here by half a millimetre of 20."""
    judged = load_case(tmp_path, CASE, [write_table(tmp_path, name=name)])
    particles = initial_particles(judged.case)
    assert find_problems(judged) == []
    np.testing.assert_allclose(particles.position_m[:, 2], ROWS["z_m"])
    np.testing.assert_allclose(particles.velocity_m_per_s[:, 2], ROWS["vz_m_per_s"])
    assert not particles.spin_rad_per_s.any()
    assert set(particles.grains.density_kg_per_m3) == {1430.0}
    assert sieve_sizes_m(judged.case)[1] == 0.02
    assert sizes_m(judged.case.whole_machine) == [0.01, 0.02]  # beside the drawing of the openings
    assert impact_speed_m_per_s(judged.case) == 2.0
    mass_kg = 1430 * np.pi / 6 * (ROWS["sieve_size_m"] ** 3).sum()
    assert bed_kg(judged.case) == pytest.approx(mass_kg, rel=1e-6)


def test_velocities_are_zeroed_on_request(tmp_path: Path) -> None:
    judged = load_case(tmp_path, CASE, [write_table(tmp_path), "bed.velocities=zero"])
    assert not initial_particles(judged.case).velocity_m_per_s.any()


def test_a_table_may_be_larger_than_a_case_file(tmp_path: Path) -> None:
    """20 000 particles need more than the megabyte that a case file may have."""
    count = np.arange(20_000)
    grid = {"x_m": count % 200, "y_m": count // 200 % 10, "z_m": 1 + count // 2000}
    rows = pd.DataFrame({name: 0.0015 * number + 1e-4 for name, number in grid.items()})
    rows = rows.assign(sieve_size_m=0.001, material="coal", vx_m_per_s=np.linspace(0, 1e-3, 20_000))
    judged = load_case(tmp_path, CASE, [write_table(tmp_path, rows)])
    assert (tmp_path / "bed.csv").stat().st_size > 1_000_000
    assert find_problems(judged) == []
    assert len(initial_particles(judged.case)) == 20_000


def test_one_message_names_everything_that_does_not_fit(tmp_path: Path) -> None:
    rows = ROWS.assign(z_m=[0.002, 0.01, 5.0], x_m=[0.10, 0.105, 0.2])
    problems = find_problems(load_case(tmp_path, CASE, [write_table(tmp_path, rows)]))
    assert keys_and_kinds(problems) == ["bed.table: misplaced"] * 3
    for number, key in ((3, "bed.outside"), (2, "bed.push_out"), (1, "bed.push_out")):
        assert any(str(number) in row.what.split() and key in row.hint for row in problems), number


def test_one_message_names_places_beside_an_unknown_material(tmp_path: Path) -> None:
    """Overlaps outside of the domain, or that are to be pushed apart, are none of its lines."""
    rows = ROWS.assign(z_m=[0.0099, 0.0101, 5.0], x_m=[0.10, 0.105, 0.2], material=["coal", "cool", "coal"])
    table = write_table(tmp_path, rows)
    messages = complaints(tmp_path, table)
    assert len(messages) == 3
    assert 'are of "cool", which the case does not have; did you mean "coal"?' in messages[0]
    assert "particle 3 at [0.2, 0.1, 5.0] is outside domain_m; bed.outside" in messages[1]
    assert "overlaps particle" in messages[2]
    assert "by 0.015 m; up to 0.05 of the diameter" in messages[2]
    assert len(complaints(tmp_path, table, "bed.outside=leave-out", "bed.push_out=true")) == 1
    write_table(tmp_path, rows.assign(z_m=[5.0, 5.0, 0.02]))
    (_, outside) = complaints(tmp_path, table)
    assert "particle 1 at [0.1, 0.1, 5.0] is outside domain_m (1 more)" in outside


def test_one_message_names_materials_coarse_graining_sides_and_surfaces(tmp_path: Path) -> None:
    """The slice is the middle 0.1 of 0.2 m; one grain lies in the panel, one beside the slice, and one
    outside of all."""
    run = saved_run(tmp_path, coarse_graining=2.0)
    place_m = np.array([[0.1, 0.1, 0.004], [0.2, 0.19, 0.02], [0.25, 0.1, 5.0], [0.2, 0.1, 0.05]])
    still, ones = np.zeros((4, 3)), np.ones(4)
    bed = CarriedBed(
        ("coal", "cool"), place_m, still, still, spheres(0.01 * ones, material=[0, 1, 0, 0]), 0.2, 2.0, ""
    )
    saved_bed.write(run / "checkpoints" / f"{20:012d}" / saved_bed.BED, bed)
    messages = complaints(tmp_path, f"bed.from_run={run}", "slice.width_m=0.1")
    assert len(messages) == 5
    assert 'are of "cool", which the case does not have; did you mean "coal"?' in messages[0]
    assert "take particles.coarse_graining = 1" not in messages[1]
    assert "take particles.coarse_graining = 2" in messages[1]
    assert "particle 3 at [0.25, 0.1, 5.0] is outside domain_m; bed.outside" in messages[2]
    assert "1 particles of" in messages[3]
    assert "are not in the slice from y = 0.05 to 0.15 m; bed.outside" in messages[3]
    assert "particle 1 is 0.001 m inside panel deck" in messages[4]


def test_a_bed_from_a_periodic_slice_fits_the_same_slice(tmp_path: Path) -> None:
    """A solver has grains up to half a search skin beyond a side, and ParaView's files round to single
    precision."""
    slice_of = ["slice.width_m=0.1"]
    run = saved_run(tmp_path)
    (run / "case.toml").write_text(tomli_w.dumps(resolved_case(loaded(tmp_path, slice_of))))
    place_m = np.array([[0.1, 0.15 + 79e-6, 0.02], [0.2, 0.05 - 79e-6, 0.02], [0.15, np.float32(0.05), 0.02]])
    still, ones = np.zeros((3, 3)), np.ones(3)
    bed = CarriedBed(("coal",), place_m, still, still, spheres(0.01 * ones), 0.2, 1.0, "")
    saved_bed.write(run / "checkpoints" / f"{20:012d}" / saved_bed.BED, bed)
    sets = [f"bed.from_run={run}"]
    judged = load_case(tmp_path, CASE, [*sets, *slice_of])
    assert find_problems(judged) == []
    y_m = initial_particles(judged.case).position_m[:, 1]
    np.testing.assert_allclose(y_m[:2], [0.05 + 79e-6, 0.15 - 79e-6], rtol=1e-9)
    narrower = "\n".join(complaints(tmp_path, *sets, "slice.width_m=0.08"))
    assert "3 particles of" in narrower


def test_particles_outside_are_left_out_on_request(tmp_path: Path) -> None:
    sets = [write_table(tmp_path, ROWS.assign(z_m=[0.0099, 0.0101, 5.0])), "bed.outside=leave-out"]
    judged = load_case(tmp_path, CASE, sets)
    assert find_problems(judged) == []
    assert len(initial_particles(judged.case)) == 2
    sets[0] = write_table(tmp_path, ROWS.assign(z_m=5.0))
    assert "all 3 particles" in only_complaint(tmp_path, *sets)


@pytest.mark.parametrize("sides", ["walls", "periodic"])
def test_particles_beside_a_slice_are_refused_or_left_out(tmp_path: Path, sides: str) -> None:
    """The slice has the middle 0.1 of 0.2 m."""
    sets = [
        write_table(tmp_path, ROWS.assign(y_m=[0.1, 0.1, 0.19])),
        f'slice={{width_m=0.1, sides="{sides}"}}',
    ]
    assert "1 particles of" in only_complaint(tmp_path, *sets)
    judged = load_case(tmp_path, CASE, [*sets, "bed.outside=leave-out"])
    assert len(initial_particles(judged.case)) == 2


def test_a_run_of_an_earlier_bed_is_not_one_of_the_bed_that_stands_there_now(tmp_path: Path) -> None:
    """Studies take finished runs for theirs by what they ran, not by the names of files."""
    sets = [write_table(tmp_path / "case", ROWS)]
    judged = load_case(tmp_path / "case", CASE, sets)
    run = create_run_folder(judged, tmp_path / "run", None)
    assert [*changed_files(judged, run)] == []
    write_table(tmp_path / "case", ROWS.iloc[:2])
    assert [*changed_files(load_case(tmp_path / "case", CASE, sets), run)] == ["bed"]


def test_a_run_of_an_earlier_surface_is_not_one_of_the_surface_that_stands_there_now(tmp_path: Path) -> None:
    corners_m = np.array([[0.0, 0.0, 1.0], [0.1, 0.0, 1.0], [0.0, 0.1, 1.0], [0.0, 0.0, 1.1]])
    triangles = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
    file = tmp_path / "case" / "wall.stl"
    file.parent.mkdir()
    meshio.stl.write(file, meshio.Mesh(corners_m, [("triangle", triangles)]))
    wall = 'screen.surfaces.wall={stl="wall.stl", frame="driving", material="PU"}'
    judged = load_case(tmp_path / "case", CASE, [wall])
    run = create_run_folder(judged, tmp_path / "run", None)
    assert [*changed_files(judged, run)] == []
    meshio.stl.write(file, meshio.Mesh(1.01 * corners_m, [("triangle", triangles)]))
    assert [*changed_files(judged, run)] == ["screen.surfaces.wall.stl"]


@pytest.mark.parametrize("sets", [[], ["slice.width_m=0.1"], ["particles.coarse_graining=2"]])
def test_a_run_that_left_particles_out_knows_them_and_its_materials(tmp_path: Path, sets: list[str]) -> None:
    """A material of which no particle is left has no number in the run's states for ParaView."""
    ash = CASE.replace("[materials.coal]", grains("ash", 1000.0, 1e7) + "[materials.coal]")
    ash += contact("ash", "ash", 0.3, 0.3) + contact("ash", "PU", 0.3, 0.3) + contact("ash", "coal", 0.3, 0.3)
    rows = ROWS.assign(y_m=[0.19, 0.1, 0.1], z_m=[5.0, 0.0101, 0.02], material=["ash", "coal", "coal"])
    sets = [write_table(tmp_path / "case", rows), "bed.outside=leave-out", *sets]
    judged = load_case(tmp_path / "case", ash, sets)
    run = create_run_folder(judged, tmp_path / "run", None)
    origin = json.loads((run / "provenance.json").read_text())["bed"]
    assert (origin["particles"], origin["left_out"]) == (2, 1)
    began = initial_particles(judged.case)
    snapshot = ParticleSnapshot(id=np.arange(1, len(began) + 1), **vars(began))
    Series(run, "particles").add(0.1, particle_mesh(snapshot))
    state = read_run(run, 0.1)
    assert state.materials == ("coal",)
    np.testing.assert_allclose(state.position_m, began.position_m, rtol=1e-6)


@pytest.mark.parametrize(
    ("rows", "kind", "name"),
    [
        (ROWS.rename(columns={"vz_m_per_s": "vz_m_s"}), "file", "'vz_m_s'"),
        (ROWS.rename(columns={"vz_m_per_s": "fall_m_per_s"}), "file", "'fall_m_per_s'"),
        (ROWS.assign(sieve_size_m=[0.02, -0.01, 0.02]), "file", "-0.01"),
        (ROWS.assign(x_m=["a", 0.1, "b"]), "file", "'a'"),
        (ROWS.assign(material="cool"), "conflict", '"coal"'),
        (ROWS.iloc[:0], "file", "bed.csv"),
    ],
)
def test_a_wrong_table_is_refused_with_a_reason(
    tmp_path: Path, rows: pd.DataFrame, kind: str, name: str
) -> None:
    (problem,) = problems(tmp_path, write_table(tmp_path, rows))
    assert (dotted_key(problem.key), problem.kind) == ("bed.table", kind)
    assert name in problem.what_helps


@pytest.mark.parametrize(
    ("sets", "kind"),
    [
        (["bed.from_run=nowhere"], "bed.from_run: file"),
        (["bed.from_run=levels"], "bed.from_run: file"),
        (["bed.from_time_s=1"], "bed.from_time_s: conflict"),
        (["bed.table=bed.csv", "bed.from_run=levels"], "bed.table: conflict"),
        (["bed.table=case.toml"], "bed.table: file"),
    ],
)
def test_a_wrong_source_is_refused_with_a_reason(tmp_path: Path, sets: list[str], kind: str) -> None:
    assert kinds(tmp_path, *sets) == [kind]


def saved_run(folder: Path, coarse_graining: float = 1.0) -> Path:
    """The folder of a run with two checkpoints."""
    (folder / "run").mkdir()
    for name in ("case.toml", "provenance.json"):
        (folder / "run" / name).write_text("")
    for number, time_s in ((10, 0.1), (20, 0.2)):
        checkpoint = folder / "run" / "checkpoints" / f"{number:012d}"
        checkpoint.mkdir(parents=True)
        place_m = np.array([[0.1, 0.1, time_s]])
        spin = np.array([[1.0, 2.0, 3.0]])
        bed = CarriedBed(("coal",), place_m, -place_m, spin, spheres([0.01]), time_s, coarse_graining, "")
        saved_bed.write(checkpoint / saved_bed.BED, bed)
    return folder / "run"


@pytest.mark.parametrize(("wanted", "taken_s"), [(None, 0.2), (0.12, 0.1), (0.2, 0.2)])
def test_the_nearest_state_of_a_run_is_taken(tmp_path: Path, wanted: float | None, taken_s: float) -> None:
    sets = [f"bed.from_run={saved_run(tmp_path)}"]
    sets += [] if wanted is None else [f"bed.from_time_s={wanted}"]
    particles = initial_particles(loaded(tmp_path, sets).case)
    np.testing.assert_array_equal(particles.position_m, [[0.1, 0.1, taken_s]])
    np.testing.assert_array_equal(particles.velocity_m_per_s, [[-0.1, -0.1, -taken_s]])
    np.testing.assert_array_equal(particles.spin_rad_per_s, [[1.0, 2.0, 3.0]])


@pytest.mark.parametrize(
    ("status", "reason", "doubts", "reason_given"),
    [
        ("done", "", [], ""),
        (
            "doubtful",
            "",
            ["The coupling created 7 % of the energy."],
            "is doubtful: The coupling created 7 %",
        ),
        ("interrupted", "stopped", [], "is interrupted: stopped"),
        ("failed", "a panel blew up", [], "is failed: a panel blew up"),
        (None, "", [], "is not at its end"),
    ],
)
def test_a_bed_of_a_run_that_cannot_be_trusted_is_told_by_its_name(
    tmp_path: Path, status: str | None, reason: str, doubts: list[str], reason_given: str
) -> None:
    """The bed of a failed run is refused unless a moment is asked for."""
    run = saved_run(tmp_path)
    if status:
        summary = {"status": status, "reason": reason, "doubts": doubts}
        (run / "summary.json").write_text(json.dumps(summary))
    source = [f"bed.from_run={run}"]
    if status == "failed":
        (refused,) = complaints(tmp_path, *source)
        assert f"the run {run} {reason_given}; bed.from_time_s takes a state from before it failed" in refused
        source.append("bed.from_time_s=0.1")
    lines = [line for line in warnings(loaded(tmp_path, source)) if "bed.from_run" in line]
    assert [f"the run {run} {reason_given}" in line for line in lines] == ([True] if reason_given else [])


def test_runs_with_and_without_an_effect_are_remembered_for_one_state_of_a_run(tmp_path: Path) -> None:
    """A run that has been continued is another origin of the bed."""
    run = saved_run(tmp_path)
    origin = loaded(tmp_path, [f"bed.from_run={run}"]).origin
    before = origin.read()["files"]
    assert list(before) == [str(run)]
    (run / "checkpoints" / f"{20:012d}" / saved_bed.BED).write_bytes(b"another state")
    assert origin.read()["files"] != before


def test_another_density_is_a_warning(tmp_path: Path) -> None:
    source = f"bed.from_run={saved_run(tmp_path)}"
    assert not [line for line in warnings(loaded(tmp_path, [source])) if "kg/m3" in line]
    other = loaded(tmp_path, [source, "materials.coal.density_kg_per_m3=1500.0"])
    (warning,) = (line for line in warnings(other) if "kg/m3" in line)
    assert "had 1430 kg/m3 there, and have 1500" in warning


def test_a_state_after_the_end_and_other_coarse_particles_are_refused(tmp_path: Path) -> None:
    run = saved_run(tmp_path, coarse_graining=2.0)
    assert kinds(tmp_path, f"bed.from_run={run}", "bed.from_time_s=1") == ["bed.from_run: file"]
    assert kinds(tmp_path, f"bed.from_run={run}") == ["bed.from_run: conflict"]


def column(diameter_m: Array, height_m: Array) -> ParticleList:
    """Particles above each other, with a small offset along x."""
    count = len(diameter_m)
    return at_rest(np.column_stack([1e-4 * np.arange(count), np.zeros(count), height_m]), diameter_m)


def at_rest(place_m: Array, diameter_m: Array) -> ParticleList:
    count = len(diameter_m)
    still = np.zeros((count, 3))
    return ParticleList(place_m, still, still, spheres(diameter_m))


def test_particles_are_pushed_out_of_surfaces_and_apart() -> None:
    """A column of twelve that settled 8 mm too low is lifted as a whole, and not thrown: it moves by little
    more than it must."""
    diameter_m = np.full(12, 0.02)
    settled = column(diameter_m, 0.002 + 0.0199 * np.arange(12))
    pushed = push_out(settled, FLOOR, UP)
    assert (overlap_m(pushed.position_m, diameter_m / 2, FLOOR) <= SETTLED * diameter_m).all()
    assert overlapping_pairs(pushed.position_m, diameter_m / 2)[2].max() <= SETTLED * 0.02
    moved_m = np.linalg.norm(pushed.position_m - settled.position_m, axis=1)
    assert 0.006 < moved_m.max() < 0.0085
    assert not pushed.velocity_m_per_s.any()


def test_particles_that_fit_stay_where_they_are() -> None:
    settled = column(np.array([0.02, 0.02]), np.array([0.0098, 0.0295]))
    np.testing.assert_array_equal(push_out(settled, FLOOR, UP).position_m, settled.position_m)


def test_pairs_of_very_different_sizes_are_all_found() -> None:
    """Five hundred fine grains around ten coarse ones of ten times their size, against brute force."""
    rng = np.random.default_rng(3)
    diameter_m = np.concatenate([rng.uniform(1e-3, 2e-3, 500), np.full(10, 0.015), np.full(5, 0.004)])
    place_m = rng.uniform(0.0, 0.03, (len(diameter_m), 3))
    apart_m = np.linalg.norm(place_m[:, None] - place_m, axis=2)
    overlap_m = (diameter_m[:, None] + diameter_m) / 2 - apart_m
    wanted = {(i, j) for i, j in np.argwhere(np.triu(overlap_m, 1) > 0).tolist()}
    first, second, found_m = overlapping_pairs(place_m, diameter_m / 2)
    assert {(min(pair), max(pair)) for pair in zip(first.tolist(), second.tolist(), strict=True)} == wanted
    assert len(first) == len(wanted) > 200
    np.testing.assert_allclose(found_m, overlap_m[first, second], rtol=1e-9)


def test_overlaps_across_periodic_sides_are_found_and_pushed_apart(tmp_path: Path) -> None:
    """Grains of 6 mm at both sides of a slice of 100 mm, half a millimetre inside, are neighbours."""
    diameter_m = np.full(2, 0.006)
    place_m = np.array([[0.1, 0.0505, 0.05], [0.1, 0.1495, 0.0502]])
    assert len(overlapping_pairs(place_m, diameter_m / 2)[0]) == 0
    first, second, depth_m = overlapping_pairs(place_m, diameter_m / 2, 0.1)
    assert sorted([*first, *second]) == [0, 1]
    assert depth_m[0] == pytest.approx(0.006 - np.hypot(0.001, 0.0002), rel=1e-9)
    pushed = push_out(at_rest(place_m, diameter_m), FLOOR, UP, 0.1)
    assert overlapping_pairs(pushed.position_m, diameter_m / 2, 0.1)[2].max(initial=0.0) <= SETTLED * 0.006
    rows = pd.DataFrame(dict(zip(("x_m", "y_m", "z_m"), place_m.T, strict=True)))
    rows = rows.assign(sieve_size_m=diameter_m, material="coal")
    sets = [write_table(tmp_path, rows), "slice.width_m=0.1"]
    assert any("overlaps" in line for line in complaints(tmp_path, *sets))


def test_a_bed_on_a_part_of_the_width_is_warned_of(tmp_path: Path) -> None:
    """Sixty grains in a strip of 60 mm on a panel of 200 mm, as those of a slice are."""
    number = np.arange(60)
    rows = pd.DataFrame({"x_m": 0.02 + 0.01 * (number % 20), "y_m": 0.07 + 0.03 * (number // 20)})
    rows = rows.assign(z_m=0.02, sieve_size_m=0.008, material="coal")
    warned = warnings(load_case(tmp_path, CASE, [write_table(tmp_path, rows)]))
    assert any({"68", "200"} <= {*line.split()} for line in warned)
