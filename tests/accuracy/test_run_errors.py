"""Runs that tell their errors by a study, from outside: a ball on a strip."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.runs.outside import HANG_S, ROOT, started, summary

pytestmark = [pytest.mark.slow, pytest.mark.process]
BALL = str(ROOT / "cases/ball-on-panel")
LOW = "bed.particles.ball.position_m=[0.152, 0.10, 0.014]"
SHORT, HALF = "duration_s=0.04", "coupling.sync_interval_s=4e-5"


def done(place: Path, *words: str) -> str:
    process = started(*words, cwd=place)
    output, problems = process.communicate(timeout=HANG_S)
    assert process.returncode == 0, output + problems
    return output + problems


def run(place: Path, name: str, *sets: str) -> tuple[dict[str, Any], str]:
    """The table of errors of a run, and what the run printed."""
    every = (LOW, SHORT, "output.pictures=false", *sets)
    words = [
        "run",
        BALL,
        "--level",
        "draft",
        "--out",
        name,
        *(word for key in every for word in ("--set", key)),
    ]
    output = done(place, *words)
    return summary(place / name)["accuracy"], output


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a small study in its usual place."""
    place = tmp_path_factory.mktemp("errors")
    words = ["--parameters", "sync", "--points", "2", "--seeds", "1", "--workers", "1"]
    done(place, "study", "accuracy", BALL, "--level", "draft", "--set", LOW, "--set", SHORT, *words)
    return place


def study(place: Path) -> dict[str, Any]:
    table: dict[str, Any] = json.loads((place / "runs/ball-on-panel-accuracy/accuracy.json").read_text())
    return table


def test_a_point_of_the_study_and_its_page(place: Path) -> None:
    """The run as it is, and the run that goes on to a later end in its folder."""
    errors, output = run(place, "base")
    base = next(entry for entry in study(place)["points"] if entry["point"] == "base")
    assert errors["basis"] == "measured"
    for name, error in errors["errors"].items():
        assert error["value"] == pytest.approx(base[f"{name}_error"] + (error["remains"] or 0.0))
    assert errors["errors"].keys() >= {"deflection_m", "clamp_rms_N", "middle_rms_g", "points_rms_g"}
    figures = {entry["quantity"]: entry for entry in errors["figures"].values()}
    assert figures["points_rms_g"]["error"] == errors["errors"]["points_rms_g"]["value"]
    assert "how far off, by a study" in output
    done(place, "report", "base")
    assert errors["study"] in (place / "base/report.html").read_text()
    done(place, "resume", "base", "--set", "duration_s=0.05")
    later = summary(place / "base")["accuracy"]
    assert {**later, "figures": 0} == {**errors, "figures": 0}
    assert later["figures"].keys() == errors["figures"].keys()


def test_another_interval_of_the_study(place: Path) -> None:
    errors, _ = run(place, "half", HALF)
    half = next(entry for entry in study(place)["points"] if "4e-05" in entry["sets"])
    assert (errors["basis"], half["point"]) == ("measured", study(place)["reference"])
    assert all(error["value"] == error["remains"] for error in errors["errors"].values())


def test_other_physics_and_no_study(place: Path, tmp_path: Path) -> None:
    other, output = run(place, "other", "contacts.0.restitution=0.5")
    assert (other["basis"], other["errors"]) == ("not known", {})
    assert "contacts.0.restitution" in other["why"]
    assert other["command"] in output
    nothing, output = run(tmp_path, "nothing")
    assert (nothing["basis"], nothing["study"], nothing["errors"]) == ("not known", "", {})
    assert nothing["command"] in output
