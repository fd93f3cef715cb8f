"""``flipflow bushing``: loops of known elements, the elements found again, and the picture."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from scipy.integrate import trapezoid
from typer.testing import CliRunner, Result

from orchestrator.case.file.bushing_curve import Elements, harmonic_stiffness, steady_loop
from orchestrator.cli.main import app

KNOWN = Elements(150e3, ((40e3, 8e-4),), ((20e3, 0.01),))
FREQUENCY_Hz = 12.5


def write_loop(folder: Path, amplitude_m: float) -> Path:
    deformation_m, force_N = steady_loop(KNOWN, amplitude_m, FREQUENCY_Hz)
    time_s = np.linspace(0, 1 / FREQUENCY_Hz, len(force_N))
    rows = np.column_stack([time_s, 1e3 * deformation_m, 1e-3 * force_N])
    file = folder / f"loop-{1e3 * amplitude_m:g}mm.csv"
    file.write_text("Zeit [s];Weg [mm];Kraft [kN]\n" + "\n".join(";".join(map(str, row)) for row in rows))
    return file


def call(*words: object) -> Result:
    return CliRunner().invoke(app, ["bushing", *map(str, words)], env={"COLUMNS": "200"})


@pytest.mark.parametrize("amplitude_m", [2e-4, 1e-3, 6e-3])
def test_a_steady_loop_has_the_first_harmonic_of_the_closed_form(amplitude_m: float) -> None:
    """Area pi k'' A^2 and force in phase k' A, within 1e-4, which 400 rows leave."""
    deformation_m, force_N = steady_loop(KNOWN, amplitude_m, FREQUENCY_Hz)
    in_phase, ahead = harmonic_stiffness(KNOWN, np.array([amplitude_m]), np.array([FREQUENCY_Hz]))
    area_J = abs(trapezoid(force_N, deformation_m))
    assert area_J == pytest.approx(np.pi * ahead[0] * amplitude_m**2, rel=3e-4)
    assert 2 * np.mean((force_N * deformation_m)[1:]) == pytest.approx(in_phase[0] * amplitude_m**2, rel=1e-3)
    assert force_N[0] == pytest.approx(force_N[-1], rel=1e-12)


def test_loops_are_fitted_and_drawn(tmp_path: Path) -> None:
    files = [write_loop(tmp_path, amplitude_m) for amplitude_m in (5e-4, 2e-3, 6e-3)]
    done = call(*files, "--out", tmp_path / "fit.png")
    assert done.exit_code == 0, done.output
    assert "loop-2mm.csv: a loop of 2 mm at 12.5 Hz" in done.output
    elastic = next(line for line in done.output.splitlines() if line.startswith("elastic_N_per_m"))
    assert float(elastic.split("=")[1]) == pytest.approx(150e3, rel=0.05)
    picture = matplotlib.image.imread(tmp_path / "fit.png")
    assert picture.shape[0] > 500
    assert float(picture.std()) > 0.05


def test_what_a_file_leaves_open_is_asked_and_answered(tmp_path: Path) -> None:
    lines = [line.split(";", 1)[1] for line in write_loop(tmp_path, 2e-3).read_text().splitlines()]
    file = tmp_path / "bare.csv"
    file.write_text("\n".join(["s;F", *lines[1:]]))
    answers = ["--column", "s=displacement / mm", "--column", "F=force / kN"]
    asked, without = call(file), call(file, *answers)
    assert (asked.exit_code, without.exit_code) == (2, 2)
    assert "bare.csv" in asked.output
    assert "frequency" in without.output
    done = call(file, *answers, "--frequency", "12.5 Hz", "--out", tmp_path / "fit.svg")
    assert done.exit_code == 0, done.output


@pytest.mark.parametrize("words", [("--column", "s"), ("--decimal", "x"), ("--frequency", "fast")])
def test_wrong_answers_are_refused(tmp_path: Path, words: tuple[str, str]) -> None:
    done = call(write_loop(tmp_path, 2e-3), *words)
    assert done.exit_code == 2
    assert words[0] in done.output


def test_a_missing_file_and_a_picture_that_cannot_be_written(tmp_path: Path) -> None:
    assert call(tmp_path / "none.csv").exit_code == 2
    done = call(write_loop(tmp_path, 2e-3), "--out", tmp_path / "none" / "fit.png")
    assert done.exit_code == 2
