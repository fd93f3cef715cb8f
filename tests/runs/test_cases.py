"""Every case of this project runs at its draft level, and its folder holds what the manual says."""

from __future__ import annotations

import json
import subprocess
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import h5py
import matplotlib.image
import meshio
import numpy as np
import pytest

from orchestrator.figures.results import parse_results
from orchestrator.output.records.run_folder import WALLS
from orchestrator.output.report import page
from orchestrator.output.report.headline import headline
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import load_judged
from tests.runs.outside import (
    QUICK,
    ROOT,
    flipflow,
    has_results,
    left_usable,
    run_words,
    said_plainly,
    summary,
)

CASES = sorted(file.parent.name for file in (ROOT / "cases").glob("*/case.toml"))
DURATION_S = {
    "ball-on-panel": 0.15,
    "empty-machine": 0.2,
    "panel-cycle": 0.2,
    "ffs0827": 0.05,
    "ffs0827-effects": 0.09,
    "iron-ore": 0.116676,  # two outputs
    "near-mesh": 0.09,
    "wedged-grains": 0.05,
}
COAL = (
    "banana",
    "ffs0827",
    "ffs0827-effects",
    "ffs0827-flowing",
    "ffs0827-flowing-twelve-springs",
    "ffs0827-slice",
)
FED_SOON = dict.fromkeys((*COAL, "near-mesh"), "coal") | {"iron-ore": "iron-ore"}
FED_SOON |= dict.fromkeys(("bulk-density", "heap"), "trickle")
PICTURED = "quickstart"
BENCHES = ("bulk-density", "heap", "shear-box")  # of grains
WITHOUT_PANELS = (*BENCHES, "bushing-hysteresis", "double-deck", "piecewise-springs", "shear-spring")
WITHOUT_FRAMES = ("ball-on-panel", "bulk-density", "heap")
Done = tuple[str, Path, subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module", params=CASES)
def case(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Done:
    """One run of each case at its draft level, shortened; with pictures of one of them."""
    name = request.param
    folder = tmp_path_factory.mktemp(name) / "run"
    sets = [f"duration_s={DURATION_S.get(name, 0.1)}"]
    sets += ["output.series_s=0"]  # a row at every sync point
    sets += [f"bed.feeds.{FED_SOON[name]}.start_s=0.01"] if name in FED_SOON else []
    sets += [] if name == PICTURED else ["output.pictures=false"]
    return name, folder, flipflow(*run_words(name, folder, sets))


def test_it_ends_well_and_says_where_the_time_went(case: Done) -> None:
    _, folder, done = case
    assert done.returncode == 0, done.stderr
    said_plainly(done)
    for text in ("where the time went", "momentum residual", f"results in {folder}"):
        assert text in done.stderr
    assert left_usable(folder, "done")["reason"] == ""


def test_results_are_made_and_shown(case: Done, monkeypatch: pytest.MonkeyPatch) -> None:
    """A result that a run cannot have is no failure: a case without frames has no orbits.  The page of one
    case has the charts of its mats, which take seconds."""
    name, folder, done = case
    if name != PICTURED:
        monkeypatch.setattr(page, "draw_mats", lambda _: ())
    results = has_results(folder)
    for tile in headline(parse_results({"results": results})):
        assert tile.line in done.stderr
        if tile.value != "unknown":  # else the reason stands there
            assert " over " in tile.line.replace("(", " "), "from how much it is"
    assert ("orbits" in results["missing"]) is (name in WITHOUT_FRAMES) or "everything" in results["missing"]
    assert ("bulk" in results) is (name in ("bulk-density", "heap"))
    if name not in WITHOUT_PANELS and "motion" in results:
        for panel in results["motion"]["panels"].values():
            assert panel["stretch_largest_percent"] >= panel["stretch_smallest_percent"]


def test_all_files_are_there(case: Done) -> None:
    name, folder, _ = case
    wanted = {"case.toml", "provenance.json", "run.log", "summary.json", "history.h5"}
    wanted |= {"surface", "surface.pvd"} if name not in WITHOUT_PANELS else set()
    if summary(folder)["particles"]:
        wanted |= {"particles", "particles.pvd"}
    names = {path.name for path in folder.iterdir()}
    assert wanted <= names
    assert not [name for name in names if name.startswith(".")], "left over from writing"


def test_the_wall_time_is_accounted_for(case: Done) -> None:
    """None of the parts is asked to take time: a virtual computer's clock may tick every 50 ms."""
    _, folder, _ = case
    table = summary(folder)
    parts, again = table["wall_by_part_s"], table["repeated_by_part_s"]
    assert sum(parts.values()) == pytest.approx(table["wall_s"], rel=1e-9)
    assert min(parts.values()) >= 0.0
    assert 0.0 <= sum(again.values()) <= parts["coupling"]


def test_momentum_balances_to_rounding(case: Done) -> None:
    """10 000 rounding errors of 1e-16 add up to less than 1e-11."""
    name, folder, _ = case
    residual = summary(folder)["momentum_residual_relative"]
    assert residual < 1e-11
    assert residual > 0.0 or name in WITHOUT_PANELS


def test_the_watch_finds_nothing(case: Done) -> None:
    """No false alarm; most figures are far from their limits."""
    _, folder, _ = case
    watch = summary(folder)["monitor"]
    assert watch["shortened_intervals"] == 0
    assert {name: figure for name, figure in watch["figures"].items() if figure["times"]} == {}


def test_time_series_have_units_and_no_gap(case: Done) -> None:
    _, folder, _ = case
    table = summary(folder)
    with h5py.File(folder / "history.h5") as history:
        assert "energy" in history
        every = [history["energy"]]
        for kind in ("frames", "probes", "forces", "bushings"):
            every += history.get(kind, {}).values()
        for group in every:
            time = group["time_s"][:]
            assert time[0] == 0.0
            assert time[-1] == pytest.approx(table["simulated_s"], rel=1e-12)
            assert np.diff(time) == pytest.approx(np.diff(time).mean(), rel=1e-9)
            for name, series in group.items():
                assert len(series) == len(time), name
                assert series.attrs["unit"], name
                assert np.isfinite(series[:]).all(), name
        for probe in history.get("probes", {}).values():
            assert len(probe["time_s"]) == table["sync_intervals"] + 1
            assert probe["position_m"].attrs["unit"] == "m"


def test_paraview_finds_every_output_time(case: Done) -> None:
    name, folder, _ = case
    with h5py.File(folder / "history.h5") as history:
        wanted = history["energy/time_s"][:]
    for series in ("surface", "particles"):
        if not (folder / f"{series}.pvd").exists():
            assert summary(folder)["particles"] == 0
            assert series == "particles" or name in WITHOUT_PANELS
            continue
        listed = ElementTree.parse(folder / f"{series}.pvd").getroot().findall("*/DataSet")
        walls = [entry for entry in listed if entry.get("file") == WALLS]
        listed = [entry for entry in listed if entry not in walls]
        for entries in filter(None, (listed, walls)):
            assert [float(entry.get("timestep", "")) for entry in entries] == pytest.approx(wanted)
        if not listed:
            assert walls, "nothing to show"
            continue
        for entry in (listed[-1],) if fed_later(name, series) else (listed[0], listed[-1]):
            mesh = meshio.read(folder / entry.get("file", ""))
            assert np.isfinite(mesh.points).all()
            assert "velocity_m_per_s" in mesh.point_data
        assert len(listed) == len(list((folder / series).iterdir()))


def fed_later(name: str, series: str) -> bool:
    """Return whether a series begins without particles at t = 0: VTK reads such a file, meshio does not."""
    return series == "particles" and name in FED_SOON


def test_a_pvd_opens_in_vtk(case: Done) -> None:
    pyvista = pytest.importorskip("pyvista")
    name, folder, _ = case
    if name in WITHOUT_PANELS:
        return
    reader = pyvista.get_reader(folder / "surface.pvd")
    reader.set_active_time_value(reader.time_values[-1])
    assert reader.read()[0].n_cells > 0


def test_pictures_are_not_blank(case: Done) -> None:
    name, folder, _ = case
    names = {"bushing_loops.png", "deck.png", "energy.png", "frame_motion.png", "panel_shapes.png"}
    assert {path.name for path in folder.glob("*.png")} == (names if name == PICTURED else set())
    for path in folder.glob("*.png"):
        pixels = matplotlib.image.imread(path)[..., :3]
        assert pixels.shape[0] > 400
        inked = (np.abs(pixels - pixels[0, 0]).max(axis=-1) > 0.1).mean()
        assert 0.01 < inked < 0.9, path.name


def test_the_resolved_case_gives_the_same_run_again(case: Done, tmp_path: Path) -> None:
    name, folder, _ = case
    assert find_problems(load_judged(folder)) == []
    if name not in ("quickstart", "panel-cycle"):
        return
    again = tmp_path / "again"  # the level is in the resolved case
    done = flipflow(*run_words(str(folder), again))
    assert done.returncode == 0, done.stderr
    with h5py.File(folder / "history.h5") as first, h5py.File(again / "history.h5") as second:
        for path in ("probes", "energy", "forces"):
            first[path].visititems(lambda key, _, path=path: _same(first[path], second[path], key))


def _same(first: h5py.Group, second: h5py.Group, key: str) -> None:
    """Compare to rounding: sums of numpy's BLAS depend on where arrays happen to lie in memory, and a tenth
    of a second of bouncing enlarges 1e-16 by less than a million."""
    if isinstance(first[key], h5py.Dataset):
        values, again = first[key][:], second[key][:]
        if not key.startswith(("defect.", "created.")):  # small differences of large numbers
            np.testing.assert_allclose(again, values, rtol=0, atol=1e-10 * np.abs(values).max(), err_msg=key)


def test_a_followed_particle_that_leaves(tmp_path: Path) -> None:
    """The particle flies up at 20 m/s through the top of the domain, 0.16 m above; the other never comes."""
    sets = [*QUICK, "duration_s=0.05", "bed.particles.ball.velocity_m_per_s=[0, 0, 20]"]
    sets += ["probes.nobody={particle=7}", "output.interval_s=0.005"]
    done = flipflow(*run_words("ball-on-panel", tmp_path / "run", sets))
    assert done.returncode == 0, done.stderr
    said_plainly(done)
    text = (tmp_path / "run/summary.json").read_text()
    table = json.loads(text, parse_constant=pytest.fail)  # NaN is no JSON
    assert table["particles"] == 0
    assert 0.15 < table["probes"]["ball"]["peak_m"] < 0.2
    nobody = table["probes"]["nobody"]
    assert nobody.pop("reason") == "it never was there"
    assert set(nobody.values()) == {None}
    has_results(tmp_path / "run")


def test_a_mistake_in_the_results_is_said_and_has_its_exit_code(tmp_path: Path) -> None:
    """The rest of the results is made, and the report says what is not."""
    broken = "import orchestrator.output.results.compute as compute\ncompute.bed_metrics = lambda *_: [][0]\n"
    filmless = "import orchestrator.output.report.page as page\npage.make_film = lambda *_: page.Film(b'')\n"
    words = run_words("quickstart", tmp_path / "run", [*QUICK, "duration_s=0.1"])
    done = flipflow(*words, before=broken)
    assert done.returncode == 6, done.stderr
    said_plainly(done)
    assert "WARNING: results not made: bed: IndexError: list index out of range" in done.stderr
    table = left_usable(tmp_path / "run", "incomplete")
    assert table["reason"] == "results could not be made: bed"
    assert list(table["results"]["failed"]) == ["bed"]
    assert table["results"]["motion"]["panels"]
    made = flipflow("report", str(tmp_path / "run"), before=broken + filmless)
    assert made.returncode == 0, made.stderr
    text = (tmp_path / "run/report.html").read_text()
    assert "The run is incomplete: results could not be made: bed" in text
    assert "Results not made: bed: IndexError" in text


def test_surfaces_from_elsewhere_are_copied_into_the_folder(tmp_path: Path) -> None:
    stl = ROOT / "cases/quickstart/walls.stl"
    sets = [*QUICK, "duration_s=0.002", f"screen.surfaces.walls.stl={stl}"]
    done = flipflow(*run_words("quickstart", tmp_path / "run", sets))
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "run/walls.stl").read_bytes() == stl.read_bytes()
    assert 'stl = "walls.stl"' in (tmp_path / "run/case.toml").read_text()
    assert flipflow("check", str(tmp_path / "run")).returncode == 0
