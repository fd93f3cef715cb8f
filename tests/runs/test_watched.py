"""The watch on a whole run: what it stops can go on, what it shortens is one run for everybody."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path

import h5py
import pytest

from orchestrator.cli import launch
from orchestrator.cli.launch import resume
from orchestrator.coupling.ledger import share_created
from orchestrator.output import checkpoints
from orchestrator.output.records import trust
from tests.runs.outside import flipflow, left_usable, run_words, said_plainly, summary
from tests.runs.same_run import run_differences
from tests.runs.test_failed import FAR_TOO_LONG
from tests.runs.test_resumed import QUICKSTART, UNSAVED, checkpoint_folders, run

# 30 pieces of coal fall faster and faster: too fast for this at 5 ms, when the bed is first judged
FAST = "monitor.largest_step_share=4.5e-4"
UNEASY = [FAST, "monitor.long_steps=shorten", "monitor.calm_s=0.0018"]


def test_stopped_it_names_the_last_good_state_and_goes_on_from_there(tmp_path: Path) -> None:
    whole = run(tmp_path / "whole", QUICKSTART, [*UNSAVED, FAST])
    folder = tmp_path / "run"
    sets = [*QUICKSTART[1:], FAST, "monitor.long_steps=stop", "checkpoint.every_s=0.0011"]
    done = flipflow(*run_words(QUICKSTART[0], folder, sets))
    assert done.returncode == 4, done.stderr
    said_plainly(done)
    stopped, _, good, command, tried = done.stderr.strip().splitlines()[-5:]
    assert stopped.startswith("stopped by the monitor at t = 0.005 s: particle ")
    assert tried.startswith("tried: with coupling.sync_interval_s = 5e-05, half of the run's, ")
    assert left_usable(folder, "failed")["reason"] == stopped
    assert good == f"last good state: t = 0.0044 s, {checkpoint_folders(folder)[-2]}"
    assert checkpoint_folders(folder)[-1].name == f"{50:012d}"  # that of the stop is there, too
    words = shlex.split(command.removeprefix("to go on from there: flipflow "))
    assert words == ["resume", str(folder), "--checkpoint", "44"]
    gone_on = flipflow(*words, "--set", "monitor.long_steps=warn")
    assert gone_on.returncode == 0, gone_on.stderr
    assert run_differences(whole, folder) == []


def test_stopped_before_anything_was_saved_it_can_go_on_from_where_it_stopped(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, (name, *sets) = tmp_path / "run", QUICKSTART
    words = [*sets, *UNSAVED, FAST, "monitor.long_steps=stop"]
    code = launch.run(Path("cases") / name, "draft", folder, words)
    assert code == launch.FAILED
    output = capsys.readouterr().err.replace("\n", " ")
    assert f"nothing was saved before; state at t = 0.005 s: {checkpoint_folders(folder)[0]}" in output
    assert resume(folder, ["monitor.long_steps=warn"]) == launch.DONE
    assert summary(folder)["status"] == "done"


def test_shortened_it_is_saved_and_resumed_bit_for_bit(tmp_path: Path) -> None:
    whole = run(tmp_path / "whole", QUICKSTART, [*UNSAVED, *UNEASY])
    folder = run(tmp_path / "run", QUICKSTART, ["checkpoint.every_s=0.0077", *UNEASY])
    shutil.rmtree(checkpoint_folders(folder)[-1])
    assert resume(folder, []) == launch.DONE
    assert run_differences(whole, folder) == []
    watched = summary(whole)["monitor"]
    # from 5 ms in halves, from 6.8 ms whole, trusted from 8.6 ms on, from 10 ms in halves again
    assert watched["shortened_intervals"] == 18 + 18
    assert watched["shortest_interval_s"] == 1e-4 / 2
    assert watched["figures"]["long_steps"]["first_s"] == 0.005
    with h5py.File(whole / "history.h5") as history:
        assert len(history["forces/deck-1/time_s"]) == 121  # as of any run
    assert "sync intervals of 5e-05 s from here on" in (whole / "run.log").read_text()


def test_the_save_from_before_stays(tmp_path: Path) -> None:
    """Later saves are not trusted while intervals are shortened."""
    sets = ["checkpoint.every_s=0.0011", *UNEASY, "monitor.calm_s=1.0"]
    names = [save.name for save in checkpoint_folders(run(tmp_path / "run", QUICKSTART, sets))]
    assert names[-2:] == [f"{110:012d}", f"{120:012d}"]
    assert len(names) == 3
    assert int(names[0]) == 44


def test_a_resumed_run_still_knows_the_save_from_before(tmp_path: Path) -> None:
    """The run is not trusted to the end: what it saves after it was resumed must neither take the place of
    the last good save nor forget which one that is."""
    sets = ["checkpoint.every_s=0.0011", *UNEASY, "monitor.calm_s=1.0"]
    folder = run(tmp_path / "run", QUICKSTART, sets)
    assert resume(folder, ["duration_s=0.0145"]) == launch.DONE
    names = [int(save.name) for save in checkpoint_folders(folder)]
    assert names == [44, 143, 145]
    newest = checkpoints.find_newest(folder)
    assert newest is not None
    assert (newest.sync_points, newest.good) == (145, 44)


def test_a_save_that_is_not_there_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = run(tmp_path / "run", QUICKSTART, ["duration_s=0.003"])
    assert resume(folder, [], 7) == launch.WRONG
    assert "has no whole checkpoint of sync point 7" in capsys.readouterr().err


def test_an_interval_far_too_long_is_shortened_where_it_has_to_be(tmp_path: Path) -> None:
    """Fifty times the quickstart's, which fails without the watch (``test_failed.py``): with it the run
    comes to its end.  Intervals as long as this one are judged one by one.

    Its mats are clamped flat and without slack, so that they pull from the start."""
    folder, deck = tmp_path / "run", "screen.panels.deck"
    flat = [f"{deck}.length_m=0.3", f"{deck}.tension_m=0.0", f"{deck}.clamp_angle_deg=0.0"]
    flat.append("screen.bushings.shear.stiffness_N_per_m=[28.9e3, 97.0e3, 97.0e3]")
    code = launch.run(Path("cases/quickstart"), "draft", folder, [*FAR_TOO_LONG, *flat])
    assert code in (trust.EXIT_CODES[trust.DONE], trust.EXIT_CODES[trust.DOUBTFUL])
    table = summary(folder)
    assert table["monitor"]["shortest_interval_s"] < 5e-3 / 4
    terms_J = table["energy_ledger_J"]
    assert abs(terms_J["created.particles-panel"]) < 0.02 * terms_J["supplied.frames.exciter"]
    assert abs(share_created(table)) < 0.15  # 0.10 measured
    assert "WARNING: the monitor ran " in (folder / "run.log").read_text()


def test_two_ranks_shorten_together(tmp_path: Path) -> None:
    """The first one decides for both: the same intervals, in the same parts."""
    alone, both = tmp_path / "alone", tmp_path / "both"
    for folder, ranks in ((alone, 1), (both, 2)):
        done = flipflow(*run_words(QUICKSTART[0], folder, [*QUICKSTART[1:], *UNEASY]), ranks=ranks)
        assert done.returncode == 0, done.stderr
    of_alone, of_both = (summary(folder)["monitor"] for folder in (alone, both))
    assert of_alone["shortened_intervals"] == of_both["shortened_intervals"] > 0
    with h5py.File(alone / "history.h5") as first, h5py.File(both / "history.h5") as second:
        for name in ("position_m", "velocity_m_per_s"):
            ours, theirs = (file[f"probes/middle-1/{name}"][:] for file in (first, second))
            assert abs(ours - theirs).max() < 1e-10
