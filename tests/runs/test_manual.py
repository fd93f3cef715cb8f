"""docs/run-folder.md says what is in the folder: no more, no less."""

from __future__ import annotations

import re
import sys
import tempfile
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas
import pytest

from orchestrator.coupling.schemes import create_scheme
from orchestrator.output import checkpoints
from orchestrator.output.records.run_folder import PICTURES
from tests.runs.outside import QUICK, ROOT, flipflow, run_words, summary

MANUAL = (ROOT / "docs/run-folder.md").read_text()
SOLVERS = ("frames.solver=exudyn", "particles.solver=liggghts", "panel.cells=[8, 3]")


def documented(heading: str, column: int = 1) -> set[str]:
    """The words in backticks in one column of the table under a heading."""
    section = re.split(r"^#+ ", MANUAL.split(f"{heading}\n", 1)[1], maxsplit=1, flags=re.M)[0]
    cells = [row.split("|")[column] for row in section.splitlines() if row.startswith("|`")]
    return {word for cell in cells for word in re.findall(r"`([^`]+)`", cell)}


LEDGER = documented("### `energy_ledger_J`")
WEAR = "contacts.1.specific_wear_m3_per_N_m=1e-12"
STOPS = "screen.panels.deck.stops.flange={from_m=0.0, to_m=0.04, gap_m=0.012}"
BULK = "bulk.bed={box_m=[[0.1, 0.0, -0.1], [0.2, 0.2, 0.1]]}"
CUT = "output.cut_size_m=0.017"  # the quickstart's panels have no openings that would tell it
MOTOR = (
    "screen.exciters.shaft.motor={rated_power_W=900, synchronous_speed_rad_per_s=80, rated_slip=0.04, "
    "moment_of_inertia_kg_m2=0.05}"
)
SOLID = {"stored.panel.isochoric", "stored.panel.volumetric"}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A short run with everything in it."""
    folder = tmp_path_factory.mktemp("manual") / "run"
    return short_run(folder)


def short_run(folder: Path) -> Path:
    done = flipflow(*run_words("quickstart", folder, ["duration_s=0.02", WEAR, STOPS, BULK]))
    assert done.returncode == 0, done.stderr
    return folder


def ledger_of(sets: tuple[str, ...], case: str, folder: Path) -> set[str]:
    done = flipflow(*run_words(case, folder, [*QUICK, "duration_s=0.001", *sets]))
    assert done.returncode == 0, done.stderr
    return set(summary(folder)["energy_ledger_J"])


def test_the_keys_of_the_summary(folder: Path) -> None:
    table = summary(folder)
    assert set(table) == documented("## `summary.json`")
    for row in table["effects"].values():
        assert set(row) == documented("### each of `effects`")
    assert set(table["accuracy"]) == documented("### `accuracy`")
    for figure in table["accuracy"]["figures"].values():
        assert set(figure) == documented("### each of `accuracy.figures`")
    assert set(table["material"]) == documented("### `material`")
    assert set(table["monitor"]) == documented("### `monitor`")
    for figure in table["monitor"]["figures"].values():
        assert set(figure) == documented("### each of `monitor.figures`")
    assert set(table["wall_by_part_s"]) == documented("### `wall_by_part_s`")
    assert set(table["energy_ledger_J"]) <= LEDGER
    assert set(table["probes"]) == {"driving", "driven", "driven-end", "middle-1", "middle-2"}
    for figures in table["probes"].values():
        assert set(figures) == documented("### each of `probes`")


def test_the_keys_of_the_iterations() -> None:
    assert set(create_scheme("aitken").figures()) == documented("### `iterations`")


def test_the_keys_of_the_results(folder: Path) -> None:
    cycles = folder.parent / "cycles"
    done = flipflow(*run_words("quickstart", cycles, [*QUICK, "duration_s=0.17", CUT, WEAR, BULK]))
    assert done.returncode == 0, done.stderr
    results = summary(cycles)["results"]
    others = {"course", "contacts", "slice_width_m"}  # eighteen cycles; a hundred fines that left; a slice
    assert set(results) == documented("### `results`") - others
    for name in ("steady", "motion", "screening", "wear"):
        of_feeds = {"cohort", "whole_feed"}  # of what was fed
        assert set(results[name]) == documented(f"### `results.{name}`") - of_feeds
    with h5py.File(cycles / "history.h5") as history:
        assert set(history["results"]) == set(results)
    few = {"missing", "failed", "share_of_width", "bulk"}
    assert set(summary(folder)["results"]) == few, "it lasts less than a cycle"


def test_the_files(folder: Path) -> None:
    named = {name.rstrip("/") for name in documented("# The folder of a run")}
    elsewhere = {"<surface>.stl", "failure.txt", "report.html", "bed.h5"}
    elsewhere |= {"point_orbits.png", "panel_instants.png"}  # of three probes or more
    elsewhere |= {"spheres.pvd", "spheres"}  # of clumps
    assert {name for name in named if name.endswith(".png")} == set(PICTURES)
    files = {path.name for path in folder.iterdir()}
    assert files == named - elsewhere | {"walls.stl"}


def test_the_time_series(folder: Path) -> None:
    wanted: dict[str, set[str]] = {}
    section = MANUAL.split("## `history.h5`\n", 1)[1].split("\n## ", 1)[0]
    for row in re.findall(r"^\|`([a-z_]+)[^`]*` \|(.*?) \|", section, flags=re.M):
        wanted.setdefault(row[0], set()).update(re.findall(r"`([^`]+)`", row[1]))
    with h5py.File(folder / "history.h5") as history:
        assert set(history) == set(wanted) - {"feeds", "loads", "shafts", "shapes"}  # it has none
        for kind, group in history.items():
            if kind == "results":
                continue
            inner: list[Any] = [group] if "time_s" in group else list(group.values())
            for columns in inner:
                names = set(columns) - {"time_s"}
                if kind in ("energy", "energy_cycles"):
                    assert {name.removesuffix("_J") for name in names} <= LEDGER
                else:
                    assert names == wanted[kind] - {"time_s"}


def test_the_arrays_of_a_checkpoint(folder: Path) -> None:
    """Their names are those of attributes of solvers and books: whoever renames one changes the format
    of checkpoints, and raises ``checkpoints.FORMAT``."""
    names = ROOT / "tests/runs/checkpoint_names.txt"
    head = f"format {checkpoints.FORMAT}"
    content = "\n".join([head, *sorted(array_names(folder)), ""])
    assert content == names.read_text(), (
        f"raise checkpoints.FORMAT, then write the names anew: python -m tests.runs.test_manual {names}"
    )


def array_names(folder: Path) -> set[str]:
    save = checkpoints.find_newest(folder)
    assert save is not None
    return checkpoints.array_names(save.state(None))


def test_the_line_for_pandas_gives_floats(folder: Path) -> None:
    """The line is taken as it is printed: every frame is made of one array of floats with a column for each
    component, which pandas takes as it is. (A list of rows would become objects.)"""
    (line,) = re.findall(r"^pandas\.concat.*$", MANUAL, flags=re.M)
    line = line.replace("probes/middle", "probes/middle-1")
    data = eval(line, {"pandas": pandas, "h5py": h5py, "f": folder / "history.h5"})
    assert set(data["position_m"].shape[1:]) == {3}
    for name in ("time_s", "position_m", "velocity_m_per_s"):
        columns = np.asarray(data[name])
        assert columns.dtype == float
        assert len(columns) == len(data["time_s"]) > 1


def test_the_terms_of_the_cheap_solvers(tmp_path: Path) -> None:
    """Every documented term is one that a solver has, by this test and the next together."""
    cheap = ledger_of((STOPS, "air={}"), "quickstart", tmp_path / "a")
    moved = ledger_of(("screen.frames.moving.drive.run_up_s=0",), "panel-cycle", tmp_path / "b")
    turned = ledger_of(("frames.solver=planar", MOTOR), "quickstart", tmp_path / "c")
    assert cheap | moved | turned == LEDGER - SOLID


@pytest.mark.solver
@pytest.mark.parametrize("panel", ["sheet", "solid"])
def test_the_terms_of_the_real_solvers(tmp_path: Path, panel: str) -> None:
    terms = ledger_of((*SOLVERS, f"panel.solver={panel}"), "quickstart", tmp_path / "run")
    assert terms <= LEDGER
    assert {"lost.particles.contact_dissipation", "supplied.frames.exciter"} <= terms
    assert terms & SOLID == (SOLID if panel == "solid" else set())


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as place:
        written = array_names(short_run(Path(place) / "run"))
    text = "\n".join([f"format {checkpoints.FORMAT}", *sorted(written), ""])
    Path(sys.argv[1]).write_text(text)
