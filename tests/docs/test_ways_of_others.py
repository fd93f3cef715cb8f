"""docs/measured/ways_of_others.csv: what its rows say, and the runs that belong to them."""

from __future__ import annotations

import pytest

import flipflow
from tools.ways_of_others import Way, parse, read, ways

ROWS = read()
OURS = {(way.way, way.scene, way.settings): way for way in ways()}


def test_every_way_of_ours_has_a_row_and_is_named() -> None:
    rows = {(row["way"], row["scene"], row["settings"]): row for row in ROWS}
    assert len(rows) == len(ROWS)
    assert rows.keys() >= OURS.keys()
    assert all(rows[key]["source"] == way.command for key, way in OURS.items())
    assert {row["way"] for key, row in rows.items() if key not in OURS} == {"Kratos"}


@pytest.mark.parametrize("way", OURS.values(), ids=[", ".join(key) for key in OURS])
def test_the_command_of_a_row_is_a_case_with_these_keys(way: Way) -> None:
    case, level, sets = parse(way.command)
    settings = flipflow.load(case, level, sets).settings
    assert settings["coupling"]["sync_interval_s"] > 0.0


@pytest.mark.parametrize("row", ROWS, ids=[", ".join([*row.values()][:3]) for row in ROWS])
def test_a_row_says_how_it_ended_and_its_error_follows_from_the_values(row: dict[str, str]) -> None:
    assert row["status"] in ("done", "doubtful", "stopped")
    assert row["error_of"] in ("numerics", "model and numerics")
    assert float(row["processor_s_per_s"]) > 0.0
    (exact,) = (r["value"] for r in ROWS if r["way"] == "reference" and r["scene"] == row["scene"])
    has_error = bool(row["value"]) and row["way"] != "reference"
    assert bool(row["error"]) == has_error
    assert bool(row["value"]) == (row["status"] != "stopped")
    if has_error:
        error = abs(float(row["value"]) / float(exact) - 1.0)
        assert float(row["error"]) == pytest.approx(error, rel=0.05)  # it has two digits
