"""Exit code 4: a solver fails, the run becomes unstable, or its folder vanishes.  The
message says which member, when and why, and the folder holds all up to then."""

from __future__ import annotations

from pathlib import Path

import h5py
import pytest

from orchestrator.output.results.quantities import outcome
from tests.runs.failures import failed
from tests.runs.outside import (
    HANG_S,
    QUICK,
    flipflow,
    left_usable,
    run_words,
    said_plainly,
    started,
    times,
    wait_until,
)

# Python that breaks a solver from the inside at its third interval
# (panels of one kind are advanced together), by the load in the middle of the second of two
NAN_IN_PANEL = """
from adapters.panel.common import compiled_panel
advance = compiled_panel.CompiledPanels.__call__
def poisoned(panels, interval, clamps, load):
    if interval.index == 2 and interval.end_s < 5e-4:
        load.force_N[3 * len(load) // 4] = float("nan")
    return advance(panels, interval, clamps, load)
compiled_panel.CompiledPanels.__call__ = poisoned
"""
NAN_FROM_FRAMES = """
from adapters.frames import two_mass
advance = two_mass.{cls}.advance
def poisoned(self, interval, reaction):
    motion = advance(self, interval, reaction)
    if interval.index == 2:
        motion.velocity_m_per_s[1, 2] = float("nan")
        type(motion)(motion.position_m, motion.velocity_m_per_s)
    return motion
two_mass.{cls}.advance = poisoned
"""
NAN_IN_LIGGGHTS = """
from adapters.particles.liggghts.particles import Liggghts
advance = Liggghts.advance
def poisoned(self, interval, path):
    if interval.index == 2:
        self.arrays()["v"][0] = float("nan")
    return advance(self, interval, path)
Liggghts.advance = poisoned
"""
# {what} is done in the panels' third interval, not in the longer ones of the trial of mats
IN_PANELS = """
import resource, numpy
from pathlib import Path
from adapters.panel.common import compiled_panel
advance = compiled_panel.CompiledPanels.__call__
hoard = []
def used_bytes():
    return 4096 * int(Path("/proc/self/statm").read_text().split()[0])
def greedy(panels, interval, clamps, load):
    if interval.index == 2 and interval.end_s < 5e-4:
        {what}
    return advance(panels, interval, clamps, load)
compiled_panel.CompiledPanels.__call__ = greedy
"""
PANELS = "panel deck-1 (strip) and 1 more"
TOO_MUCH = "numpy.ones(2**50)"
NOTHING_LEFT = (
    "resource.setrlimit(resource.RLIMIT_AS, (used_bytes() + 2**26, -1)); "
    "hoard.append([bytearray(2**16) for _ in range(2**20)])"
)
LOSES_A_PARTICLE = """
from adapters.particles.liggghts.particles import Liggghts
advance = Liggghts.advance
def careless(self, interval, path):
    if interval.index == 2:
        self._engine.command("group lost id 1")
        self._engine.command("delete_atoms group lost compress no")
    return advance(self, interval, path)
Liggghts.advance = careless
"""


def test_a_nan_in_a_panel(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    done = flipflow(*run_words("quickstart", folder), before=NAN_IN_PANEL)
    when = "failed between t = 0.0002 s and 0.0003 s (sync interval 2)"
    failed(folder, done, f"{PANELS} {when}: panel deck-2: strip unstable", "nan")
    assert done.stderr.count("failed between") == 1
    assert times(folder, "frames/driving")[-1] == pytest.approx(2e-4)


def test_a_nan_from_the_frames(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    before = NAN_FROM_FRAMES.format(cls="TwoMassFrames")
    done = flipflow(*run_words("empty-machine", folder), before=before)
    failed(folder, done, "frames (two-mass) failed between t = 0.0008 s", "velocity_m_per_s: point 1")


@pytest.mark.solver
def test_a_nan_in_liggghts(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    sets = [*QUICK, "particles.solver=liggghts"]
    done = flipflow(*run_words("quickstart", folder, sets), before=NAN_IN_LIGGGHTS)
    failed(folder, done, "particles (liggghts) failed between t = 0.0002 s and 0.0003 s")


@pytest.mark.parametrize(("what", "why"), [(TOO_MUCH, "Unable to allocate 8.00 PiB"), (NOTHING_LEFT, "")])
def test_out_of_memory(tmp_path: Path, what: str, why: str) -> None:
    """More than there is at once, and bit by bit until nothing is left of ``ulimit -v``."""
    folder = tmp_path / "run"
    before = IN_PANELS.format(what=what)
    done = flipflow(*run_words("quickstart", folder), before=before)
    beginning = f"{PANELS} failed between t = 0.0002 s and 0.0003 s (sync interval 2): "
    failed(folder, done, f"{beginning}out of memory. {why}".strip())


@pytest.mark.solver
def test_liggghts_loses_a_particle(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    sets = [*QUICK, "particles.solver=liggghts"]
    done = flipflow(*run_words("quickstart", folder, sets), before=LOSES_A_PARTICLE)
    failed(folder, done, "particles (liggghts) failed between t = 0.0002 s", "99 of 100 are left")
    assert str(folder / "log.liggghts") in done.stderr


FAR_TOO_LONG = [*QUICK, "coupling.sync_interval_s=5e-3", "output.interval_s=0.01", "duration_s=0.3"]


def test_particles_that_outrun_their_step(tmp_path: Path) -> None:
    """A sync interval that is far too long, where the watch does not shorten it
    (``test_watched.py``): the run comes to its end, and says that it is doubtful and why."""
    folder = tmp_path / "run"
    done = flipflow(*run_words("quickstart", folder, [*FAR_TOO_LONG, "monitor.created_energy=warn"]))
    assert done.returncode == 5, done.stderr
    doubts = left_usable(folder, "doubtful")["doubts"]
    assert any("energy" in doubt for doubt in doubts), doubts
    assert "WARNING: do not trust this run: " in done.stderr
    assert "warning: coupling.sync_interval_s = 0.005 s: for accuracy, the usual rules" in done.stderr
    assert "sure to be stable: coal of" in done.stderr


def test_a_frame_too_light_for_its_panels(tmp_path: Path) -> None:
    """Panels of 0.3 kg each on a frame of 0.1 kg: no staggered scheme is stable when the load
    comes from more mass than it acts on (Causin, P., Gerbeau, J.-F. and Nobile, F., Computer
    Methods in Applied Mechanics and Engineering 194, 2005, 4506-4527); where the watch only warns,
    the net below it holds."""
    folder = tmp_path / "run"
    watch = ["monitor.created_energy=warn", "monitor.growing_modes=warn"]
    sets = [*QUICK, "screen.frames.driven.mass_kg=0.1", *watch]
    done = flipflow(*run_words("empty-machine", folder, sets))
    failed(folder, done, "strip unstable before ", "stretches are ")
    why = "the panels are too heavy for a frame that carries them; make that frame heavier"
    assert f"s: no interval is short enough: {why}" in done.stderr
    assert f"No shorter interval helps: {why} or its panels lighter." in done.stderr
    assert "smaller coupling.sync_interval_s" not in done.stderr


def test_a_folder_that_vanishes(tmp_path: Path) -> None:
    folder, gone = tmp_path / "run", tmp_path / "gone"
    run = started(*run_words("quickstart", folder))
    wait_until(lambda: (folder / "particles.pvd").exists())
    folder.rename(gone)
    output = run.communicate(timeout=HANG_S)[1]
    assert run.returncode == 4, output
    assert "Traceback" not in output
    assert "cannot be written: [Errno 2] No such file or directory" in output
    assert f"{folder} has gone" in output
    with h5py.File(gone / "history.h5") as history:
        assert len(history["energy/time_s"]) > 0


@pytest.mark.parametrize(
    ("error", "is_refused"),
    [
        ("OSError(28, 'No space left')", True),
        ("MemoryError()", True),
        ("SolverFailed('no form') from OSError(28, 'No space left')", True),
        ("SolverFailed('no form') from MemoryError()", True),
        ("SolverFailed('no form')", False),
    ],
)
def test_what_the_computer_refuses_is_no_failure_of_the_case(
    error: str, is_refused: bool, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    before = f"""
from orchestrator.ports.plans import SolverFailed
from orchestrator.run import run

def fail(*_):
    raise {error}

run.check_speeds = fail
"""
    done = flipflow(*run_words("panel-cycle", folder), before=before)
    assert done.returncode == 4
    said_plainly(done)
    assert left_usable(folder, "failed")["reason"].startswith("the computer refused: ") == is_refused
    assert outcome(folder) == ("not run" if is_refused else "stopped")


def test_an_internal_error_is_called_one(tmp_path: Path) -> None:
    """Exit code 1; the traceback is for the log."""
    folder = tmp_path / "run"
    before = "from orchestrator.run import run\nrun.check_speeds = lambda *_: {}['absent']"
    done = flipflow(*run_words("panel-cycle", folder), before=before)
    assert done.returncode == 1
    said_plainly(done)
    assert "internal error: KeyError: 'absent'" in done.stderr
    assert "Traceback" in (folder / "run.log").read_text()
    left_usable(folder, "failed")


def test_an_internal_error_inside_a_member_names_it(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    before = IN_PANELS.format(what="{}['absent']")
    done = flipflow(*run_words("quickstart", folder), before=before)
    assert done.returncode == 1
    said_plainly(done)
    place = f"{PANELS} between t = 0.0002 s and 0.0003 s (sync interval 2)"
    assert f"internal error: KeyError: 'absent'; {place}" in done.stderr
    left_usable(folder, "failed")
