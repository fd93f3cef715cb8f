"""One run, and the same amplitude wherever it is told: results, summary, history, report, sweep, paper."""

from __future__ import annotations

import csv
import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from orchestrator.figures.estimate import Estimate
from orchestrator.figures.short_names import named
from orchestrator.output.records.history import write_results
from orchestrator.output.records.summary import write_summary
from orchestrator.output.report.formatting import interval
from orchestrator.output.report.headline import headline
from orchestrator.output.report.page import Film, page
from orchestrator.output.results.observed import ObservedMotion
from orchestrator.output.results.quantities import number_of
from orchestrator.output.results.run_reader import RunReader
from orchestrator.preflight.scene.scene import scene
from orchestrator.studies.criteria import Criterion
from orchestrator.studies.points import Vary
from orchestrator.studies.sweep import sweep_rows, write_sweep
from orchestrator.workbench import Run
from tests.results.synthetic import folder_of, parsed, results_table

PAIR = "driven-driving"
VARY = Vary("screen.exciters.shaft.speed_rad_per_s", ("78.5",))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a run in which both frames swing, shake and have a third harmonic beside their first one, so
    that a half range, a mean of the cycles' amplitudes and an amplitude without a window are other numbers.
    """
    folder = folder_of(tmp_path_factory.mktemp("digits") / "run", particles=False, cycles=24)
    rng = np.random.default_rng(2)
    with h5py.File(folder / "history.h5", "a") as history:
        for sign, group in zip((1, -1), history["frames"].values(), strict=True):
            time_s = group["time_s"][:][:, None]
            swing_m = 4e-4 * np.exp(-time_s) * np.cos(29 * time_s) + 3e-4 * np.cos(3 * 78.5 * time_s)
            noise_m = rng.normal(0.0, 1e-4, (len(time_s), 3))
            group["displacement_m"][...] = group["displacement_m"][:] + sign * swing_m + noise_m
    table = results_table(folder)
    write_summary(folder, RunReader(folder).summary | {"results": table})
    write_results(folder / "history.h5", table)
    return folder


@pytest.fixture(scope="module")
def along(folder: Path) -> dict[str, Any]:
    """Return the relative amplitude along the deck in the results."""
    estimate: dict[str, Any] = results_table(folder)["motion"]["relative"][PAIR]["along_m"]
    return estimate


def test_it_is_the_first_harmonic(along: dict[str, Any]) -> None:
    assert along["value"] == pytest.approx(6e-3, rel=2e-3)
    assert abs(along["value"] - 6e-3) < along["half_width"] < 6e-5


def test_the_results_agree_with_themselves(folder: Path, along: dict[str, Any]) -> None:
    with RunReader(folder) as run:
        orbit = run.summary["results"]["motion"]["relative"][PAIR]
        assert orbit["amplitude_m"][0] == orbit["along_m"]["value"] == along["value"]
        assert orbit["half_width_m"][0] == orbit["along_m"]["half_width"] == along["half_width"]
        stored = run.history[f"results/motion/relative/{PAIR}/along_m"]
        assert (stored[()], stored.attrs["half_width"]) == (along["value"], along["half_width"])


def test_the_sweep_and_the_paper_have_the_same_bits(
    folder: Path, along: dict[str, Any], tmp_path: Path
) -> None:
    point: Any = SimpleNamespace(value="78.5", folder=folder, run=Run(folder))
    (row,) = csv.DictReader(write_sweep(VARY, [point], tmp_path)[0].read_text().splitlines())
    assert float(row[f"{PAIR}.x_m"]) == along["value"]
    assert float(row[f"{PAIR}.x_m.half_width"]) == along["half_width"]
    assert float(row[f"motion.relative.{PAIR}.along_m"]) == along["value"]
    assert float(row[f"motion.relative.{PAIR}.amplitude_m.x"]) == along["value"]
    asked = Criterion(what="a", run="speed", measure="amplitude", of=PAIR, axis="x")
    assert number_of(asked, folder) == along["value"]


def test_explain_and_the_accuracy_study_ask_for_the_same(folder: Path, along: dict[str, Any]) -> None:
    stroke = named("stroke").of(RunReader(folder).summary)
    assert stroke is not None
    assert (stroke.value, stroke.half_width) == (along["value"], along["half_width"])


def test_the_report_has_the_same_digits(folder: Path, along: dict[str, Any]) -> None:
    table = results_table(folder)
    text = re.sub(r"\s+", " ", page(folder, parsed(table), lambda *_: Film(b"", reason="none")))
    shown = interval(Estimate(along["value"], along["half_width"]), 1e3)
    (tile,) = [tile for tile in headline(parsed(table)) if tile.name.startswith("relative amplitude")]
    assert f"{tile.value} ± {tile.interval}" == shown
    row = re.search(rf"{PAIR}, relative.*?</tr>", text)
    assert row is not None
    assert shown in row[0]
    assert shown.split(" ± ")[0] in text.split("Frames: orbits")[0], "the headline has it, too"


def test_the_verdicts_see_the_same_stroke(folder: Path, along: dict[str, Any]) -> None:
    """The frames' rotations count at the panels' ends, too: without them it is the frames'."""
    with RunReader(folder) as run:
        motion = results_table(folder)["motion"]
        observed = ObservedMotion(scene(run.case), run, motion["start_s"], motion["end_s"])
        first, second = (np.array(observed.phasor(name)) for name in ("driving", "driven"))
        seen_m = abs((second - first) @ run.deck_axes[:, 0])
    assert seen_m == pytest.approx(along["value"], rel=1e-12)


def test_another_settled_state_is_the_same_everywhere(folder: Path, tmp_path: Path) -> None:
    with RunReader(folder) as run:
        motion = run.summary["results"]["motion"]
    assert motion["is_settled"]
    assert not headline(parsed({"motion": motion}))[0].unsteady
    point: Any = SimpleNamespace(value="78.5", folder=folder, run=Run(folder))
    (row,) = sweep_rows(VARY, [point])
    assert (row["settled"], row["drift"]) == ("yes", motion["drift"])
