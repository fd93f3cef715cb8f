"""A machine recorded with strips and run again with what was recorded, from outside."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.case.recordings import turning
from orchestrator.ports import Array
from orchestrator.preflight.judge import load_judged
from tests.panel.elastic_plans import difference
from tests.runs.outside import QUICK, ROOT, flipflow, left_usable, run_words, said_plainly, summary

pytestmark = [pytest.mark.slow, pytest.mark.process]
SERIES = ("panel.cells=[12, 1]", "output.series_s=5e-4", "output.interval_s=0.01", *QUICK)
EMPTY = (*SERIES, "duration_s=0.5")
# thrown, but not felt: what a recorded panel leaves out is left out of both
THROWN = (*SERIES, "coupling.sync_interval_s=2e-4", "exchange.particle_load=false")


def both(case: str, place: Path, sets: tuple[str, ...]) -> tuple[Path, Path]:
    """Folders of a run with strips and of the same with its recording."""
    strips, played, file = place / "strips", place / "played", place / "panels.h5"
    done = flipflow(*run_words(case, strips, [*sets, "output.shapes_s=5e-4"]))
    assert done.returncode == 0, done.stderr
    done = flipflow("record", str(strips), "--out", str(file), "--cycles", "4")
    assert done.returncode == 0, done.stderr
    recorded = ("panel.solver=recorded", f"panel.recording={file}")
    done = flipflow(*run_words(case, played, [*sets, *recorded]))
    assert done.returncode == 0, done.stderr
    return strips, played


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    return both("empty-machine", tmp_path_factory.mktemp("empty"), EMPTY)


def as_recorded(folder: Path, series: str) -> Array:
    """The last three cycles less the last quarter, which is faded into another cycle's."""
    cycle_s = summary(folder)["cycle_s"]
    with h5py.File(folder / "history.h5") as history:
        time_s = history[f"{series.rpartition('/')[0]}/time_s"][:]
        before_s = time_s[-1] - time_s
        return np.asarray(history[series][(before_s < 3 * cycle_s) & (before_s > cycle_s / 4)])


@pytest.mark.parametrize(
    ("series", "allowed"),
    [
        ("probes/middle-1/position_m", 0.03),
        ("probes/middle-2/position_m", 0.03),
        ("forces/deck-1/first_clamp_N", 0.03),
        ("forces/deck-2/second_clamp_N", 0.03),
        ("frames/driven/displacement_m", 0.1),
    ],
)
def test_an_empty_machine_does_again_what_was_recorded(
    machine: tuple[Path, Path], series: str, allowed: float
) -> None:
    """Relative to the motion about its mean.  The run-up is not played back, and 0.5 s later the
    frames still ring from it (docs/theory/panel_recorded.md: 1 % after 1.5 s)."""
    strips, played = (as_recorded(folder, series) for folder in machine)
    mean = strips.mean(axis=0)
    assert difference(played - mean, strips - mean) < allowed


def test_its_books_close(machine: tuple[Path, Path]) -> None:
    """Momentum to rounding, energy to 1e-3 of what was supplied; the case in the folder runs."""
    said = left_usable(machine[1], "done")
    ledger = said["energy_ledger_J"]
    assert said["momentum_residual_relative"] < 1e-11
    supplied_J = sum(abs(value) for name, value in ledger.items() if name.startswith("supplied."))
    assert abs(ledger["supplied.panel.recording"]) > 0.01 * supplied_J
    assert abs(ledger["defect.panel"]) < 1e-3 * supplied_J
    assert set(said["left_out"]) >= {"panel-response"}
    again = flipflow("check", str(machine[1]))
    assert again.returncode == 0, again.stderr


def test_particles_are_thrown_alike(tmp_path: Path) -> None:
    """Mean speed of 100 spheres from the third cycle on: within 15 %, what four cycles of a
    chaotic bed leave open."""
    folders = both("quickstart", tmp_path, THROWN)
    speeds = []
    for folder in folders:
        with h5py.File(folder / "history.h5") as history:
            late = history["bed/time_s"][:] > 0.2
            speeds.append(float(history["bed/mean_speed_m_per_s"][late].mean()))
    assert speeds[1] == pytest.approx(speeds[0], rel=0.15)
    assert speeds[0] > 0.5


@pytest.mark.parametrize("axis", ["[0, 1, 0]", "[0, 0, 2]"])
def test_an_angle_counts_from_the_same_direction_wherever_the_force_starts(axis: str) -> None:
    """A force that starts a quarter turn further on is one with a phase that is larger by a quarter turn."""
    first, next_ = ("[0, 0, 1]", "[3, 0, 0]") if axis == "[0, 1, 0]" else ("[1, 0, 0]", "[0, 1, 0]")
    shaft = "screen.exciters.shaft"
    zeros_s = []
    for start, phase_rad in ((first, 0.3 + np.pi / 2), (next_, 0.3)):
        sets = [f"{shaft}.axis={axis}", f"{shaft}.start={start}", f"{shaft}.phase_rad={phase_rad!r}"]
        machine = turning(load_judged(ROOT / "cases/empty-machine", "draft", sets).case)
        assert machine is not None
        zeros_s.append(machine.zero_s)
    assert zeros_s[0] == pytest.approx(zeros_s[1], abs=1e-12)


def test_what_does_not_fit_is_said(machine: tuple[Path, Path], tmp_path: Path) -> None:
    file = machine[0].parent / "panels.h5"
    base = ["check", "cases/empty-machine", "--level", "draft", "--set", "panel.solver=recorded"]
    none = flipflow(*base)
    assert (none.returncode, "panel.recording: missing" in none.stderr) == (2, True)
    base += ["--set", f"panel.recording={file}"]
    thicker = flipflow(*base, "--set", "screen.panels.deck.thickness_m=0.005")
    assert thicker.returncode == 2
    assert "thickness_m = 0.005, the recorded one 0.004" in thicker.stderr
    backwards = flipflow(*base, "--set", "screen.exciters.shaft.axis=[0, -1, 0]")
    assert backwards.returncode == 2
    assert "a shaft about (0, 1, 0) turned the recorded machine" in backwards.stderr
    gone = flipflow(*base, "--set", f"panel.recording={tmp_path / 'none.h5'}")
    assert (gone.returncode, "no such file" in gone.stderr) == (2, True)
    faster = flipflow(*base, "--set", "screen.exciters.shaft.speed_rad_per_s=90")
    assert (faster.returncode, "played back at 90 rad/s" in faster.stdout) == (0, True)
    nothing = flipflow("record", str(machine[1]), "--out", str(tmp_path / "again.h5"))
    assert (nothing.returncode, "no shapes were recorded" in nothing.stderr) == (2, True)
    empty = flipflow("record", "cases/double-deck", "--out", str(tmp_path / "again.h5"))
    assert (empty.returncode, "the case has no panels" in empty.stderr) == (2, True)
    other = tmp_path / "bed.h5"
    other.write_text("no recording")
    taken = flipflow("record", str(machine[0]), "--out", str(other))
    assert (taken.returncode, taken.stderr.startswith(f"{other}: exists already")) == (2, True)
    assert other.read_text() == "no recording"
    for done in (none, thicker, backwards, taken, gone, nothing, empty):
        said_plainly(done)
