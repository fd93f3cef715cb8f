"""``flipflow study sweep`` from outside: against the two-mass closed form, and resumed."""

from __future__ import annotations

import csv
import os
import signal
import time
from pathlib import Path

import numpy as np
import pytest

from orchestrator.output.records.run_folder import is_at_work
from tests.runs.outside import ENDED_S, HANG_S, flipflow, of, started, wait_until

pytestmark = pytest.mark.slow
SPEED = "screen.exciters.shaft.speed_rad_per_s"
SPEEDS = "58:110:26"
# Linear: panels do not push the frames, and the bushings have their share of 1 MN/m; damped so
# that it settles within the run
LINEAR = (
    "frames.solver=two-mass",
    "panel.solver=rigid",
    "exchange.panel_reaction=false",
    "screen.bushings.shear.stiffness_N_per_m=[391.7e3, 970e3, 970e3]",
    "screen.bushings.shear.damping_N_s_per_m=[1500, 3000, 3000]",
    "screen.bushings.isolation.damping_N_s_per_m=[6000, 6000, 6000]",
    "screen.exciters.shaft.run_up_s=0.1",
    "screen.drawn_at_rest=true",
    "coupling.sync_interval_s=1e-3",
    "output.interval_s=0.1",
    "duration_s=1.2",
    "output.pictures=false",
)


def words(out: Path, *sets: str) -> list[str]:
    options = [word for each in (*LINEAR, *sets) for word in ("--set", each)]
    case = ["cases/ffs0827-empty", "--level", "draft", "--out", str(out)]
    return ["study", "sweep", *case, "--vary", f"{SPEED}={SPEEDS}", *options]


@pytest.fixture(scope="module")
def swept(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("sweep") / "speed"
    done = flipflow(*words(out))
    assert done.returncode == 0, done.stderr
    return out


def closed_form(speed: float, stiffness: float, damping: float) -> tuple[complex, complex]:
    """Two masses along one axis (M1 = 764, M2 = 287 kg, ground 0.9 MN/m with 24 kN s/m), excited by
    3.5 kg m, by Cramer's rule."""
    ground, shear = 0.9e6 + 24e3j * speed, stiffness + 1j * damping * speed
    a, d = ground + shear - 764 * speed**2, shear - 287 * speed**2
    force = 3.5 * speed**2
    return force * d / (a * d - shear**2), force * shear / (a * d - shear**2)


def test_amplitudes_over_58_to_110_rad_s_follow_two_masses(swept: Path) -> None:
    """The amplitudes agree within 2e-3 of the larger one, what is left of the start after 1.2 s."""
    table = list(csv.DictReader((swept / "sweep.csv").read_text().splitlines()))
    assert [float(row[SPEED]) for row in table] == [58.0, 84.0, 110.0]
    for row in table:
        for axis, stiffness, damping in (("x", 6 * 391.7e3, 9e3), ("z", 6 * 970e3, 18e3)):
            driving, driven = closed_form(float(row[SPEED]), stiffness, damping)
            allowed_m = 2e-3 * max(abs(driving), abs(driven))
            assert float(row[f"driving.{axis}_m"]) == pytest.approx(abs(driving), abs=allowed_m)
            assert float(row[f"driven.{axis}_m"]) == pytest.approx(abs(driven), abs=allowed_m)
            relative_m = float(row[f"driven-driving.{axis}_m"])
            assert relative_m == pytest.approx(abs(driven - driving), abs=allowed_m)
        assert float(row["drift"]) < 0.02
        assert row["settled"] == "yes"
        results_m = float(row["motion.relative.driven-driving.amplitude_m.x"])
        assert results_m == pytest.approx(float(row["driven-driving.x_m"]), rel=0.05)


def test_what_is_done_is_not_run_again_and_what_is_not_is(swept: Path) -> None:
    """A run that was cut short is put aside and run anew; the others are left as they are."""
    kept, cut = swept / "speed_rad_per_s-58.0", swept / "speed_rad_per_s-84.0"
    before = (kept / "summary.json").stat().st_mtime_ns
    text = (cut / "summary.json").read_text()
    (cut / "summary.json").write_text(text.replace('"done"', '"interrupted"'))
    done = flipflow(*words(swept))
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("done before") == 2
    assert (kept / "summary.json").stat().st_mtime_ns == before
    assert (swept / "speed_rad_per_s-84.0-unfinished-1").is_dir()
    assert '"done"' in (cut / "summary.json").read_text()


def test_runs_of_another_case_are_not_taken_for_these(swept: Path) -> None:
    done = flipflow(*words(swept, "duration_s=1.1"))
    assert done.returncode == 2
    assert "holds a run of another case (it differs in duration_s)" in done.stderr


def test_a_point_that_is_wrong_is_said_before_any_is_run(tmp_path: Path) -> None:
    options = ["--vary", "panel.solver=rigid,strap", "--out", str(tmp_path / "x")]
    done = flipflow("study", "sweep", "cases/ffs0827-empty", "--level", "draft", *options)
    assert done.returncode == 2
    assert 'did you mean "strip"?' in done.stderr
    assert not os.listdir(tmp_path)


def test_the_picture_is_drawn(swept: Path) -> None:
    import matplotlib.image

    pixels = matplotlib.image.imread(swept / "sweep.png")[..., :3]
    assert 0.01 < (np.abs(pixels - pixels[0, 0]).max(axis=-1) > 0.1).mean() < 0.9


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_signal_stops_the_runs_too(tmp_path: Path, workers: str, number: signal.Signals) -> None:
    """The signal reaches the study alone, as batch systems, service managers and a lack of memory send it."""
    out = tmp_path / "long"
    runs = [out / f"speed_rad_per_s-{speed}" for speed in ("58.0", "84.0")[: int(workers)]]
    with started(*words(out, "duration_s=1000"), "--workers", workers) as study:
        wait_until(lambda: all((run / "history.h5").exists() for run in runs))
        study.send_signal(number)
        study.wait(timeout=HANG_S)
    assert study.returncode == (143 if number == signal.SIGTERM else -number)
    ended_s = time.monotonic() + ENDED_S
    while of(out) and time.monotonic() < ended_s:
        time.sleep(0.05)
    assert of(out) == []
    assert not any(is_at_work(run) for run in runs)


def test_several_keys_and_any_result(tmp_path: Path) -> None:
    """A list of two settings; called again after one of its runs was lost, only that one is made."""
    out, key = tmp_path / "two", "screen.panels.deck"
    keys = ("--vary", f"{key}.tension_m=0.002,0.004", "--vary", f"{key}.thickness_m=0.003,0.004")
    quick = ("--set", "duration_s=0.002", "--set", "output.pictures=false", "--set", "panel.solver=strip")
    wanted = ("--plan", "list", "--result", "probes.middle.peak_m", "--out", str(out))
    command = ("study", "sweep", "cases/ball-on-panel", "--level", "draft", *keys, *quick, *wanted)
    first = flipflow(*command)
    assert first.returncode == 0, first.stderr
    table = list(csv.DictReader((out / "sweep.csv").read_text().splitlines()))
    assert [(row[f"{key}.tension_m"], row[f"{key}.thickness_m"]) for row in table] == [
        ("0.002", "0.003"),
        ("0.004", "0.004"),
    ]
    assert all(float(row["probes.middle.peak_m"]) >= 0 for row in table)
    assert {"sweep.csv", "sweep.parquet", "results.png"} <= {file.name for file in out.iterdir()}
    (out / "tension_m-0.002_thickness_m-0.003" / "summary.json").unlink()
    again = flipflow(*command)
    assert again.returncode == 0, again.stderr
    assert again.stdout.count("done before") == 1
    assert (out / "tension_m-0.002_thickness_m-0.003-unfinished-1").is_dir()
