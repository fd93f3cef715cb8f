"""Cases over other cases: ``base`` in case.toml."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from orchestrator.case.file.errors import CaseError, CaseProblem, dotted_key
from orchestrator.case.file.layers import Layers
from orchestrator.case.file.origin import CHEAP_LEVEL
from orchestrator.output.records.run_folder import create_run_folder, resolved_case
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.level_file import write_level
from tests.cases import CASE, case_folder, keys_and_kinds

LEVEL = 'about = "strips"\nwithout = ["variation-across"]\n[panel]\nsolver = "strip"\n'
FEEDS = """
[bed.feeds.chute]
material = "coal"
rate_kg_per_s = 1.0
box_m = [[0.0, 0.0, 0.1], [0.1, 0.1, 0.2]]
velocity_m_per_s = [0.0, 0.0, -1.0]
sizes = [{ smallest_m = 0.01, largest_m = 0.02, mass_fraction = 1.0 }]
"""
HEAVIER = 'base = "../below"\ntitle = "a heavier frame"\n[screen.frames.driving]\nmass_kg = 90.0\n'
CORNERS = ("0 0 0", "1 0 0", "0 1 0")
PLATE = (
    "solid a\nfacet normal 0 0 1\nouter loop\n"
    + "".join(f"vertex {corner}\n" for corner in CORNERS)
    + "endloop\nendfacet\nendsolid a\n"
)
SURFACE = '[screen.surfaces.plate]\nstl = "plate.stl"\nframe = "driving"\nmaterial = "PU"\n'


@pytest.fixture
def below(tmp_path: Path) -> Path:
    return case_folder(tmp_path / "below", CASE, draft=LEVEL)


def over(below: Path, text: str = HEAVIER, name: str = "above", **levels: str) -> Path:
    return case_folder(below.parent / name, text, **levels)


def refusal(folder: Path) -> CaseProblem:
    with pytest.raises(CaseError) as caught:
        load_judged(folder)
    (problem,) = caught.value.problems
    return problem


def read(folder: Path, level: str | None = None) -> JudgedCase:
    loaded = load_judged(folder, level)
    assert find_problems(loaded) == []
    return loaded


def test_a_case_overlays_the_tables_of_its_base(below: Path) -> None:
    """Keys that it does not give are the base's; the base itself stays as it is."""
    ours, theirs = read(over(below)), read(below)
    assert (ours.name, ours.case.title) == ("above", "a heavier frame")
    frames = [each.case.screen.frames["driving"] for each in (ours, theirs)]
    assert [frame.mass_kg for frame in frames] == [90.0, 76.0]
    assert frames[0].inertia_kg_m2 == frames[1].inertia_kg_m2
    assert ours.changed == ()


def test_a_base_may_have_a_base(below: Path) -> None:
    over(below)
    top = read(over(below, 'base = "../above"\nduration_s = 0.2\n', "top"))
    assert (top.case.duration_s, top.case.screen.frames["driving"].mass_kg) == (0.2, 90.0)


def test_levels_of_the_base_are_usable_and_own_ones_hide_them(below: Path) -> None:
    assert read(over(below), "draft").case.panel.solver == "strip"
    own = LEVEL + "cells = [5, 1]\n"
    assert read(over(below, name="own", draft=own, fine=own), "draft").case.panel.cells == (5, 1)


def test_new_levels_lie_in_the_cases_own_folder(below: Path) -> None:
    above = over(below)
    file = write_level(load_judged(above, "draft"), "coarse", ["panel.cells=[4, 1]"], "coarse")
    assert file == above / "levels/coarse.toml"
    assert read(above, "coarse").case.panel.cells == (4, 1)


def test_files_are_found_where_their_names_were_written(below: Path) -> None:
    """The files are the base's surface and the base's level; the run's folder has its own copies of both."""
    (below / "case.toml").write_text(CASE + SURFACE)
    (below / "plate.stl").write_text(PLATE)
    (below / "levels/draft.toml").write_text(
        LEVEL + "[screen.surfaces.second]\n" + SURFACE.partition("\n")[2]
    )
    above = over(below)
    loaded = read(above, "draft")
    assert loaded.case.screen.surfaces["second"].stl == "../below/plate.stl"
    run = create_run_folder(loaded, below.parent / "run", None)
    assert {file.name for file in run.glob("*.stl")} == {"plate.stl", "second.stl"}
    table = tomllib.loads((run / "case.toml").read_text())
    assert "base" not in table
    assert table["screen"]["frames"]["driving"]["mass_kg"] == 90.0
    assert resolved_case(read(run)) == resolved_case(loaded)
    assert [*loaded.origin.read()["files"]] == ["../below/plate.stl"]
    assert CHEAP_LEVEL in loaded.origin.read()["levels"]


def test_a_bed_of_the_base_is_found_beside_the_base(below: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The bed is found there also if the upper case or the working directory has a file of that name."""
    bed = "x_m,y_m,z_m,sieve_size_m,material\n0.1,0.1,{},0.01,coal\n"
    (below / "bed.csv").write_text(bed.format(0.1))
    (below / "case.toml").write_text(CASE + '[bed]\ntable = "bed.csv"\n')
    above = over(below)
    (above / "bed.csv").write_text(bed.format(0.2))
    monkeypatch.chdir(above)
    judged = read(above)
    assert judged.case.bed.carried is not None
    assert judged.case.bed.carried.position_m[0, 2] == 0.1
    assert [*judged.origin.read()["files"]] == ["../below/bed.csv"]
    (below / "bed.csv").unlink()
    assert read(over(below, name="other")).case.bed.table == "bed.csv"


def test_files_outside_of_all_folders_are_refused(below: Path) -> None:
    (below.parent / "plate.stl").write_text(PLATE)
    (below / "case.toml").write_text(CASE + SURFACE.replace("plate.stl", "../plate.stl"))
    for folder in (below, over(below)):
        assert keys_and_kinds(find_problems(load_judged(folder))) == ["screen.surfaces.plate.stl: file"]


@pytest.mark.parametrize(
    ("value", "file", "kind"),
    [
        ('"../belov"', "case.toml", "file"),
        ("3", "case.toml", "wrong-type"),
        ('"/etc"', "case.toml", "wrong-type"),
        ('"."', "case.toml", "conflict"),
        ('"../circle"', "../circle/case.toml", "conflict"),
    ],
)
def test_a_wrong_base_is_one_message(below: Path, value: str, file: str, kind: str) -> None:
    over(below, 'base = "../above"\n', "circle")
    problem = refusal(over(below, f"base = {value}\n"))
    assert (problem.file, problem.key, problem.kind) == (file, ("base",), kind)


def test_a_wrong_key_is_said_with_the_file_that_gives_it(below: Path) -> None:
    problem = refusal(over(below, HEAVIER + "mas_kg = 1.0\n"))
    assert (problem.file, dotted_key(problem.key)) == ("case.toml", "screen.frames.driving.mas_kg")
    assert '"mass_kg"' in problem.hint
    (below / "case.toml").write_text(CASE.replace("thickness_m", "thicknes_m"))
    problem = refusal(over(below, name="other"))
    assert (problem.file, dotted_key(problem.key)) == ("../below/case.toml", "screen.panels.deck.thicknes_m")


def test_a_list_is_named_with_all_that_gave_it_or_changed_its_elements() -> None:
    layers = Layers({"sizes": [{"mass": 0.5}, {"mass": 0.5}]}, "case.toml")
    layers.lay({"sizes": {"1": {"mass": 0.6}}}, "levels/fine.toml")
    layers.lay({"sizes": {"0": {"mass": 0.6}}}, "--set")
    assert layers.source(("sizes",)) == "case.toml, levels/fine.toml, --set"
    assert layers.source(("sizes", 1, "mass")) == "levels/fine.toml"
    layers.lay({"sizes": [{"mass": 0.9}, {"mass": 0.2}]}, "other.toml")
    assert layers.source(("sizes",)) == layers.source(("sizes", 1, "mass")) == "other.toml"


def test_a_level_of_the_base_that_feeds_less_is_said(tmp_path: Path) -> None:
    below = case_folder(tmp_path / "below", CASE + FEEDS, thin="[bed.feeds.chute]\nrate_kg_per_s = 0.1\n")
    for folder in (below, over(below)):
        lines = warnings(load_judged(folder, "thin"))
        assert sum("levels/thin.toml feeds 10% of the case's throughput" in line for line in lines) == 1


def test_base_is_no_key_of_levels_and_sets(below: Path) -> None:
    with pytest.raises(CaseError) as refused:
        load_judged(below, None, ["base=../above"])
    assert keys_and_kinds(refused.value.problems) == ["base: unknown-key"]
