"""The case near-mesh at its quick level, by the command of its README.

Grains near the size of the openings, of one sphere and of several, over openings with and without a depth.
"""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from orchestrator.workbench import Run
from tests.runs.outside import flipflow

pytestmark = [pytest.mark.slow, pytest.mark.solver]
SHORT = ("duration_s=1.2", "output.pictures=false")
SHAPE, RIMS = "bed.feeds.coal.shape", "screen.decks.deck.apertures.rims"


def test_shapes_and_rims_stand_in_one_table_and_one_picture(tmp_path: Path) -> None:
    out = tmp_path / "out"
    sets = [word for each in SHORT for word in ("--set", each)]
    vary = ["--vary", f"{SHAPE}=sphere,stone", "--vary", f"{RIMS}=thin,deep", "--plan", "list"]
    results = ["--result", "efficiency", "--result", "results.held.pegged_percent"]
    done = flipflow(
        "study", "sweep", "cases/near-mesh", *vary, *results, *sets, "--out", str(out), "--jobs", "1"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    rows = list(csv.DictReader((out / "sweep.csv").read_text().splitlines()))
    assert [(row[SHAPE], row[RIMS], row["status"]) for row in rows] == [
        ("sphere", "thin", "done"),
        ("stone", "deep", "done"),
    ]
    assert (out / "results.png").is_file()
    for row in rows:
        run = Run(out / f"shape-{row[SHAPE]}_rims-{row[RIMS]}")
        material = run.summary["material"]
        assert material["fed"]["number"] > 100
        assert material["lost"]["number"] == 0
        assert run.summary["momentum_residual_relative"] < 1e-10
