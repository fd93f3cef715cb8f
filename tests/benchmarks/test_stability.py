"""``flipflow study stability`` on runs that are made up: nothing finished is run again; map, table
and page say what there is."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.coupling.schemes import SCHEMES
from orchestrator.output.records.run_folder import write_case
from orchestrator.output.records.summary import write_summary
from orchestrator.output.tables import write_csv
from orchestrator.studies import stability
from orchestrator.studies.criteria import interval_sets
from orchestrator.studies.points import CaseStudy, Crew, FolderUnusable, Point, run_points
from orchestrator.studies.verdicts import CriterionResult
from tests.cases import case_folder
from tests.runs.outside import ROOT, flipflow, said_plainly

HARD = ROOT / "cases" / "hard"
STRIP = ("panel.solver=strip", "panel.cells=[8,1]", "panel.surface_cells=[8,4]")
DONE = {"status": "done", "reason": "", "energy_ledger_J": {"lost.a": 1.0}}
IDLE = DONE | {"energy_exchanged_J": {"particles-panel": 0.0, "panel-frames": 1.0}}
WARNED = DONE | {"status": "doubtful"}
STOPPED = {"status": "failed", "reason": "the panel became unstable"}


def made_up(point: Point, figures: dict[str, object]) -> None:
    """The folder that such a run would leave."""
    point.folder.mkdir(parents=True)
    write_summary(point.folder, figures)
    write_case(point.folder, point.loaded.judged)


@pytest.fixture
def spots(tmp_path: Path) -> list[stability.Spot]:
    """The map of the strip, nothing run; two masses, two intervals."""
    texts = [(HARD / "interval" / name).read_text() for name in ("case.toml", "levels/draft.toml")]
    case = case_folder(tmp_path / "case", texts[0], draft=texts[1])
    (case / "map.toml").write_text(
        f'key = "materials.coal.density_kg_per_m3"\nvalues = [350.0, 1430.0]\nmultiples = [1.0, 2.0]\n'
        f"sets = {json.dumps(STRIP)}\n"
    )
    return stability.map_spots(case, tmp_path / "out")


def test_the_map_has_every_scheme_mass_and_interval(spots: list[stability.Spot]) -> None:
    assert len(spots) == 4 * len(SCHEMES)
    assert {spot.scheme for spot in spots} == set(SCHEMES)
    panel_kg = 0.2 * 0.08 * 0.002 * 1150.0
    balls_kg = 60 * np.pi / 6 * 0.015**3 * 1430.0
    ratios = sorted({spot.mass_ratio for spot in spots})
    assert ratios == pytest.approx([balls_kg / panel_kg * 350 / 1430, balls_kg / panel_kg])
    by_mass = {spot.mass_ratio: set() for spot in spots}
    for spot in spots:  # of one mass and multiple every scheme has the same interval
        case = spot.point.loaded.tables
        assert case.coupling.scheme == spot.scheme
        by_mass[spot.mass_ratio].add((spot.multiple, case.coupling.sync_interval_s))
    for pairs in by_mass.values():
        (smaller, one_s), (larger, two_s) = sorted(pairs)
        assert (smaller, larger) == (1.0, 2.0)
        assert two_s == pytest.approx(2 * one_s, rel=0.01)  # three digits


def test_what_was_stopped_is_not_run_again(
    spots: list[stability.Spot], monkeypatch: pytest.MonkeyPatch
) -> None:
    for spot, figures in zip(spots, [DONE, WARNED, STOPPED] * len(spots), strict=False):
        made_up(spot.point, figures)
    monkeypatch.setattr("orchestrator.workbench.run.python", lambda *words, **more: pytest.fail("it was run"))
    lines = list(run_points([spot.point for spot in spots], Crew(1)))
    assert all(line.endswith("done before") for line in lines)
    assert [spot.outcome for spot in spots[:3]] == ["stable", "warned", "stopped"]


def test_a_run_that_is_to_be_resumed_is_not_done_at_its_first_end(tmp_path: Path) -> None:
    point = stability.benchmark(HARD / "restart", tmp_path).runs["resumed"].points[0]
    assert "duration_s=0.002" in point.words
    assert point.then[0] == "resume"
    made_up(point, DONE)
    (point.folder / "provenance.json").write_text("{}")
    assert not point.done()
    (point.folder / "provenance.json").write_text('{"resumed": []}')
    assert point.done()


def test_picture_table_and_page(spots: list[stability.Spot], tmp_path: Path) -> None:
    for spot, figures in zip(spots, [DONE, WARNED, STOPPED, IDLE], strict=False):
        made_up(spot.point, figures)
    picture = stability.draw_map(spots, tmp_path / "map.png")
    pixels = matplotlib.image.imread(picture)[..., :3]
    assert 0.01 < (np.abs(pixels - pixels[0, 0]).max(axis=-1) > 0.1).mean() < 0.9
    table = write_csv([spot.words for spot in spots], tmp_path / "map.csv")
    with table.open() as text:
        rows = [*csv.DictReader(text)]
    assert [row["outcome"] for row in rows[:4]] == ["stable", "warned", "stopped", "idle"]
    assert rows[4]["outcome"] == "not run"
    case = stability.benchmark(HARD / "restart", tmp_path)
    row = case.criteria.criteria[0]
    results = [CriterionResult("restart", row, -2.0), CriterionResult("restart", row, None, "<nothing>")]
    page = stability.write_stability_page([(case, results)], spots, picture, tmp_path).read_text()
    assert "1 met" in page
    assert "1 no number" in page
    assert "&lt;nothing&gt;" in page
    assert "data:image/png;base64," in page


def test_masses_that_are_one_to_three_digits_are_refused(spots: list[stability.Spot]) -> None:
    """Their runs would have one folder, and both places of the map the outcome of the last one."""
    heavier = replace(spots[0].point, words=(*spots[0].point.words, "--set", "title=another"))
    with pytest.raises(FolderUnusable, match="two different runs of this study have this folder"):
        next(run_points([spots[0].point, heavier], Crew(1)))
    made_up(spots[0].point, DONE)
    assert len([*run_points([spots[0].point, spots[0].point], Crew(1))]) == 1  # one that is asked for twice


@pytest.mark.process
@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--part", "hart"), "hard or map"),
        (("docs", "--part", "hard"), "criteria.toml"),
        (("--part", "map", "--map", "jam"), "map.toml"),
    ],
)
def test_what_is_wrong_is_said(tmp_path: Path, words: tuple[str, ...], message: str) -> None:
    done = flipflow("study", "stability", *words, "--out", str(tmp_path / "out"))
    assert done.returncode == 2
    assert message in done.stderr
    said_plainly(done)


def test_an_interval_where_nothing_limits_it_is_refused() -> None:
    with pytest.raises(CaseError, match=r"\binf\b"):
        interval_sets(CaseStudy(HARD / "snapping"), (), 1.0)


def test_points_are_compared_by_what_they_run(tmp_path: Path) -> None:
    point = stability.benchmark(HARD / "restart", tmp_path).runs["whole"].points[0]
    made_up(point, DONE)
    assert point.done()
    other = replace(
        point, loaded=stability.benchmark(HARD / "jam", tmp_path).runs["squeezed"].points[0].loaded
    )
    with pytest.raises(FolderUnusable, match="another case"):
        other.done()
