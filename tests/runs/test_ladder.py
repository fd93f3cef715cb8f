"""``flipflow ladder`` from outside: what it runs, what it leaves, and that it resumes."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from tests.runs.outside import flipflow

pytestmark = [pytest.mark.solver, pytest.mark.slow, pytest.mark.process]


def words(out: Path, *more: str) -> list[str]:
    case = ["ladder", "cases/ball-on-panel", "--level", "draft", "--out", str(out)]
    return [*case, "--ladder", "particles", "--duration", "0.15", "--jobs", "2", *more]


@pytest.fixture(scope="module")
def ladder(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("ladder") / "ball"
    done = flipflow(*words(out))
    assert done.returncode == 0, done.stdout + done.stderr
    return out, done.stdout


def test_every_rung_that_fits_is_measured(ladder: tuple[Path, str]) -> None:
    """Of one ball: none, NumPy, LIGGGHTS softer, as it is, stiffer; the last is the reference.
    Without the ball the panel stays where it is; NumPy and LIGGGHTS agree to 1 %; contacts a
    hundred times softer than the reference throw the panel's middle within 10 % as far."""
    said = json.loads((ladder[0] / "ladder.json").read_text())
    rungs = {entry["rung"]: entry for entry in said["rungs"]}
    assert list(rungs) == ["none", "spheres", "coarser", "softer", "as it is", "stiffer"]
    assert "single particles" in rungs.pop("coarser")["omitted"]
    assert not any(entry["omitted"] for entry in rungs.values())
    assert rungs["none"]["error"]["deflection_m"] > 0.9
    assert rungs["spheres"]["values"]["deflection_m"] == pytest.approx(
        rungs["as it is"]["values"]["deflection_m"], rel=0.01
    )
    assert rungs["softer"]["error"]["deflection_m"] < 0.1
    assert {entry["reference"] for entry in rungs.values()} == {"stiffer"}
    assert rungs["stiffer"]["error"] == {}
    assert all(entry["peak_memory_MiB"] > 20 for entry in rungs.values())
    with (ladder[0] / "ladder.csv").open() as text:
        assert [row["rung"] for row in csv.DictReader(text) if not row["omitted"]] == list(rungs)


def test_pictures_table_and_page_are_there(ladder: tuple[Path, str]) -> None:
    out, said = ladder
    assert "particles: error against stiffer" in said
    page = (out / "ladder.html").read_text()
    pictures = list(out.glob("ladder-*.png"))
    assert pictures
    assert page.count("data:image/png") == len(pictures)
    assert "http" not in page


def test_what_is_done_is_not_run_again(ladder: tuple[Path, str]) -> None:
    done = flipflow(*words(ladder[0]))
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("done before") == 5


def test_what_is_too_dear_and_unknown_ladders_are_said(tmp_path: Path) -> None:
    done = flipflow(*words(tmp_path / "x", "--budget", "1"))
    assert done.returncode == 0, done.stderr
    assert "more than --budget 1" in done.stdout
    wrong = flipflow("ladder", "cases/ball-on-panel", "--ladder", "panels")
    assert wrong.returncode == 2
    assert 'did you mean "panel"?' in wrong.stderr
