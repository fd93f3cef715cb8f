"""``flipflow study corners``: restitution and rolling friction at the ends of their ranges."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.cli.studies import corners
from orchestrator.figures.short_names import Value
from orchestrator.output.report.corners import CENTRE, FILE, corner_lines, range_lines
from orchestrator.output.report.page import Film, page
from orchestrator.output.results.compute import compute_results
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.material_ranges import corner_sets, ranged_contacts
from orchestrator.studies.points import CaseStudy, Point
from tests.cases import CASE, case_folder
from tests.results.synthetic import folder_of

ANGULAR = "materials.coal.shape=angular"
OF_LIBRARY = ('screen.panels.deck.material="polyurethane 85 Shore A"',)


def study(folder: Path, case: str = CASE, sets: tuple[str, ...] = ()) -> CaseStudy:
    return CaseStudy(case_folder(folder / "case", case), None, sets, folder / "out", name="corners")


def contacts_of(point: Point) -> dict[frozenset[str], Any]:
    return {frozenset(row.between): row for row in point.loaded.tables.contacts}


def corner_points(given: CaseStudy, **own: tuple[float, float]) -> dict[str, Point]:
    judged = given.check().judged
    sets = corner_sets(judged, [*ranged_contacts(judged, own)])
    return {name: given.point(name, [overlay]) for name, overlay in sets.items()}


def test_the_corners_are_the_ends_of_the_library(tmp_path: Path) -> None:
    """Coal: restitution 0.1 to 0.5, on polyurethane 0.2 to 0.5; angular grains roll with 0.15 to 0.4."""
    sets = (*OF_LIBRARY, "materials.coal.like=coal")
    corner = corner_points(study(tmp_path, CASE, (*sets, ANGULAR, "contacts=[]")))
    assert len(corner) == 4
    rows = contacts_of(corner["low-restitution-high-rolling-friction"])
    own, deck = rows[frozenset({"coal"})], rows[frozenset({"coal", "polyurethane-85-Shore-A"})]
    assert (own.restitution, own.rolling_friction) == (0.1, 0.4)
    assert (deck.restitution, deck.rolling_friction) == (0.2, 0.4)
    assert deck.sliding_friction > 0  # that of the library
    rows = contacts_of(corner["high-restitution-low-rolling-friction"])
    assert (rows[frozenset({"coal"})].restitution, rows[frozenset({"coal"})].rolling_friction) == (0.5, 0.15)


def test_what_has_no_range_stays_as_it_is_given(tmp_path: Path) -> None:
    """The library does not know PU, and coal of the case has no shape: two runs for coal among coal."""
    corner = corner_points(study(tmp_path))
    assert sorted(corner) == ["high-restitution", "low-restitution"]
    rows = contacts_of(corner["low-restitution"])
    assert rows[frozenset({"coal"})].restitution == 0.1
    assert rows[frozenset({"coal", "PU"})].restitution == 0.34
    assert rows[frozenset({"coal"})].sliding_friction == 0.36


def test_own_ranges_hold_for_all_grains(tmp_path: Path) -> None:
    corner = corner_points(study(tmp_path), restitution=(0.2, 0.3), rolling_friction=(0.05, 0.35))
    rows = contacts_of(corner["high-restitution-low-rolling-friction"])
    assert {(row.restitution, row.rolling_friction) for row in rows.values()} == {(0.3, 0.05)}


def test_points_over_speed_are_taken_as_known(tmp_path: Path) -> None:
    points = "contacts.1.restitution=[{impact_m_per_s=1, restitution=0.5}]"
    with pytest.raises(CaseError, match="no range"):
        list(corners.command(study(tmp_path, sets=(points,))))


@pytest.mark.parametrize("text", ["0.5", "0.5:0.1", "a:b", "-1:1", "0.1:0.2:0.3"])
def test_a_range_that_is_none_is_one_message(tmp_path: Path, text: str) -> None:
    with pytest.raises(CaseError, match="two numbers from low to high") as raised:
        list(corners.command(study(tmp_path), restitution=text))
    assert len(raised.value.problems) == 1


def test_the_page_of_the_centre_says_what_was_found(tmp_path: Path) -> None:
    given = study(tmp_path, sets=(ANGULAR,))
    ranged = [*ranged_contacts(given.check().judged, {})]
    points = [given.point(CENTRE), *corner_points(given).values()]
    given.folder.mkdir()
    speeds = {
        point.value: {"efficiency": None, "velocity": Value(float(number))}
        for number, point in enumerate(points)
    }
    corners.write_corners(given.folder, ranged, points, speeds)
    (line,) = corner_lines(given.folder / CENTRE)
    assert line.startswith(
        "velocity from 0 to 4.00 m/s within the ranges of the materials, by 5 runs of one seed each"
    )
    assert "coal on PU: restitution as given, rolling friction 0.15 to 0.4" in line
    assert "5 of them did not end well" in line  # none was run here
    assert corner_lines(given.folder / points[1].value) == []
    assert corner_lines(tmp_path) == []


@pytest.mark.parametrize("content", ["[]", "{}", "nonsense", json.dumps({"results": {"a": 1}})])
def test_a_foreign_file_says_nothing(tmp_path: Path, content: str) -> None:
    (tmp_path / FILE).write_text(content)
    assert corner_lines(tmp_path / CENTRE) == []


def test_a_run_tells_the_range_or_the_command_that_computes_it(tmp_path: Path) -> None:
    """The command is that of the run's own folder, which is a case with all that was set."""
    run = folder_of(tmp_path / "mine-1", cycles=15)
    results, judged = compute_results(run), load_judged(run)
    (line,) = range_lines(run, judged, results)
    assert line.endswith(f"was not computed: flipflow study corners {run} does")
    assert results.screening is not None
    without = replace(results.screening, efficiency_percent=None)
    assert range_lines(run, judged, replace(results, screening=without)) == []
    write_found(tmp_path / "mine-1-corners", run / "case.toml")
    (line,) = range_lines(run, judged, results)
    assert line.startswith("efficiency from 31.0 to 62.0 % within the ranges of the materials")
    assert line in page(run, results, lambda *_: Film(b"", reason="left out by the test"))
    assert range_lines(run, judged, replace(results, screening=None)) == []


def test_the_range_of_another_case_is_not_told(tmp_path: Path) -> None:
    run = folder_of(tmp_path / "mine-1", cycles=15)
    write_found(tmp_path / "mine-1-corners", run / "case.toml")
    case = (run / "case.toml").read_text()
    (run / "case.toml").write_text(f"{case}\n[air]\n")
    assert corner_lines(run) == []
    (run / "case.toml").write_text(case)
    assert len(corner_lines(run)) == 1


def test_a_run_of_unknown_materials_asks_for_ranges(tmp_path: Path) -> None:
    run = folder_of(tmp_path / "run", cycles=15)
    points = "[{impact_m_per_s=1, restitution=0.5}]"
    rows = range(len(load_judged(run).case.contacts))
    judged = load_judged(run, None, [f"contacts.{row}.restitution={points}" for row in rows])
    (line,) = range_lines(run, judged, compute_results(run))
    assert line.endswith("--restitution LOW:HIGH --rolling-friction LOW:HIGH does")


def write_found(study: Path, case: Path) -> None:
    """Write the folder of a study of the case whose efficiency went from 31 to 62 %."""
    (study / CENTRE).mkdir(parents=True)
    shutil.copy(case, study / CENTRE)
    results = {"efficiency": {"unit": "%", "from": 31.0, "to": 62.0, "runs": 5}}
    ranges = [{"between": ["coal", "PU"], "restitution": [0.2, 0.5]}]
    (study / FILE).write_text(json.dumps({"results": results, "ranges": ranges, "doubtful": []}))
