"""``flipflow study accuracy`` on models of the particles, from outside."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.runs.outside import flipflow

pytestmark = [pytest.mark.solver, pytest.mark.slow, pytest.mark.process]
WANTED = ("particles-model", "stiffness")


def words(out: Path, *more: str) -> list[str]:
    case = ["study", "accuracy", "cases/ball-on-panel", "--level", "draft", "--out", str(out)]
    return [*case, "--quick", "--parameters", ",".join(WANTED), "--duration", "0.15", "--jobs", "2", *more]


@pytest.fixture(scope="module")
def studied(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("models") / "ball"
    done = flipflow(*words(out))
    assert done.returncode == 0, done.stdout + done.stderr
    return out, done.stdout


def test_every_model_is_compared_with_the_best(studied: tuple[Path, str]) -> None:
    """The models of one ball are none, NumPy and LIGGGHTS; without the ball the panel stays where it is;
    NumPy and LIGGGHTS agree to 1 %; contacts ten times softer than the reference throw the panel's middle
    within 10 % as far."""
    models = json.loads((studied[0] / "accuracy.json").read_text())["models"]
    particles = {row["variant"]: row for row in models if row["axis"] == "particles"}
    assert list(particles) == ["none", "spheres", "liggghts"]
    assert {row["reference"] for row in particles.values()} == {"liggghts"}
    assert particles["none"]["error"]["deflection_m"] > 0.9
    assert particles["spheres"]["error"]["deflection_m"] < 0.01
    softest = next(row for row in models if row["axis"] == "stiffness")
    assert 0 < softest["error"]["deflection_m"] < 0.1


def test_models_have_a_picture_and_a_table(studied: tuple[Path, str]) -> None:
    out, _ = studied
    assert (out / "accuracy-particles-models.png").is_file()
    page = (out / "accuracy.html").read_text()
    assert page.count("Every model, against the best of them") == 1
    assert page.count("data:image/png") == len(list(out.glob("*.png")))


def test_no_model_that_leaves_out_the_particles_is_recommended(studied: tuple[Path, str]) -> None:
    study = json.loads((studied[0] / "accuracy.json").read_text())
    labels = [row["label"] for row in study["options"]["particles"]]
    assert sorted(labels) == ["liggghts", "spheres"]
