"""The figures at the top: each says from how much it is, and whether it will last."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from orchestrator.output.report.formatting import number
from orchestrator.output.report.headline import NOT_STEADY, Tile, headline
from orchestrator.output.report.page import Film, page
from orchestrator.output.results.compute import compute_results
from tests.results.synthetic import CYCLE_S, folder_of


def tiles_of(found: dict[str, Any]) -> dict[str, Tile]:
    return {tile.name: tile for tile in headline(found)}


def test_a_steady_run_says_from_how_much_its_figures_are(tmp_path: Path) -> None:
    """Ten particles leave in a cycle, eight of them fine."""
    tiles = tiles_of(compute_results(folder_of(tmp_path / "run")))
    assert tiles["screening efficiency η"].over == "490 particles that left, 49 cycles, 3.92 s"
    assert tiles["undersize recovery"].over == "392 fine particles that left, 49 cycles, 3.92 s"
    assert tiles["feed"].over == "49 cycles, 3.92 s"
    depth = tiles["largest bed depth"]
    assert depth.over == "100 particles at 490 output times, 49 cycles, 3.92 s"
    assert depth.line == f"largest bed depth: 50.000 ± 0.000 mm (over {depth.over})"
    assert not [tile.name for tile in tiles.values() if tile.unsteady]


@pytest.mark.parametrize("cycles", [11, 15])
def test_a_transient_says_that_it_is_one(tmp_path: Path, cycles: int) -> None:
    """After one cycle in which particles left, everything that passed is all that there is."""
    folder = folder_of(tmp_path / "run", cycles=cycles)
    found = compute_results(folder)
    tiles = tiles_of(found)
    out = 10 * (cycles - 10)
    over = f"{out} particles that left, {cycles} cycles, {number(cycles * CYCLE_S)} s"
    assert tiles["screening efficiency η"].over == over
    for name, tile in tiles.items():
        assert tile.unsteady is (
            name not in ("largest panel stretch", "peak panel acceleration")
            and not name.startswith("relative")
        )
        assert tile.line.endswith(f"; {NOT_STEADY})") is tile.unsteady
    text = re.sub(r"\s+", " ", page(folder, found, lambda *_: Film(b"", reason="none")))
    assert f"over {over}<br><strong>{NOT_STEADY}</strong>" in text


def test_a_machine_that_still_runs_up_is_not_steady(tmp_path: Path) -> None:
    """Two cycles are averaged over: nobody can see whether they settle."""
    folder = folder_of(tmp_path / "run", particles=False, cycles=4)
    found = compute_results(folder)
    assert found["motion"]["reason"] == "averaged over 2 cycles; 4 are needed to see it settle"
    assert all(tile.unsteady for tile in headline(found))
