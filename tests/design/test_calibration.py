"""Calibrations of known functions: hidden factors are found, or said not to be."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from orchestrator.case.file.errors import CaseError
from orchestrator.cli.main import app
from orchestrator.studies.design.calibration import Calibration, calibrate
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import Crew
from tests.cases import keys_and_kinds

Truth = Callable[[float, float], float]
NOISE = 0.02  # standard deviation of a run and of a measurement


def slope(sliding: float, rolling: float) -> float:
    """A heap knows one combination of the two."""
    return 20 + 15 * (sliding + 1.5 * rolling) - 4 * (sliding + 1.5 * rolling) ** 2


def strength(sliding: float, rolling: float) -> float:
    """A shear box knows another one."""
    return 0.3 + 0.4 * sliding - 0.2 * rolling + 0.1 * sliding**2


def write_study(folder: Path, name: str, truth: Truth, target: float, seed: int) -> Path:
    """Write a study of a table with runs of a function, which have noise of 2 % of its range."""
    rng = np.random.default_rng([seed, len(name)])
    settings = rng.uniform((0.2, 0.0), (0.8, 0.4), (24, 2))
    values = np.array([truth(*each) for each in settings])
    deviation = NOISE * float(np.ptp(values))
    rows = [f"{s},{r},{v}" for (s, r), v in zip(settings, rng.normal(values, deviation), strict=True)]
    place = folder / name
    place.mkdir(parents=True)
    (place / "runs.csv").write_text("\n".join(["sliding,rolling,answer", *rows]))
    (place / "study.toml").write_text(f"""
table = "runs.csv"
[factors.sliding]
range = [0.2, 0.8]
[factors.rolling]
range = [0.0, 0.4]
[responses.answer]
target = {rng.normal(target, deviation)}
target_deviation = {deviation}
""")
    return place / "study.toml"


def calibration(files: Sequence[Path], folder: Path, **known: float) -> Calibration:
    campaigns = []
    for number, file in enumerate(files):
        design = DesignStudy(read_study(file), Crew(), folder / f"out{number}")
        design.load_finished()
        campaigns.append(design.campaign)
    return calibrate(campaigns, known)


def test_two_measurements_find_two_factors_with_honest_intervals(tmp_path: Path) -> None:
    """Of twenty factors, intervals of 90 % hold 15 or more in 99 of 100 such trials (binomial)."""
    held = 0
    for number in range(10):
        hidden = np.random.default_rng(number).uniform((0.25, 0.05), (0.75, 0.35))
        files = [
            write_study(tmp_path / str(number), name, truth, truth(*hidden), number)
            for name, truth in (("heap", slope), ("shear", strength))
        ]
        answer = calibration(files, tmp_path / str(number))
        for value, factor in zip(hidden, answer.factors(), strict=True):
            assert factor.is_found, factor
            held += factor.low <= value <= factor.high
        assert not answer.missed()
    assert held >= 15


def test_one_measurement_tells_two_factors_together_only(tmp_path: Path) -> None:
    """The larger the one, the smaller the other; so says the function."""
    answer = calibration([write_study(tmp_path, "heap", slope, slope(0.5, 0.2), 1)], tmp_path)
    assert not any(factor.is_found for factor in answer.factors())
    ((first, second, correlation),) = answer.bound_pairs()
    assert (first, second) == ("sliding", "rolling")
    assert correlation < -0.9


def test_one_measurement_tells_the_other_factor_where_one_is_known(tmp_path: Path) -> None:
    file = write_study(tmp_path, "heap", slope, slope(0.5, 0.2), 1)
    answer = calibration([file], tmp_path, sliding=0.5)
    (rolling,) = answer.factors()
    assert rolling.name == "rolling"
    assert rolling.is_found
    assert rolling.likeliest == pytest.approx(0.2, abs=0.05)
    assert answer.likeliest["sliding"] == 0.5
    assert not [*answer.bound_pairs()]


@pytest.mark.parametrize(
    ("known", "why"),
    [
        ("slding=0.5", 'no factor "slding"; did you mean "sliding"'),
        ("sliding=0.9", "sliding = 0.9 is not between 0.2 and 0.8"),
        ("sliding", '"sliding" is not FACTOR=VALUE; as bond=0'),
        ("sliding=0.5 rolling=0.2", "all factors are known: nothing is sought"),
    ],
)
def test_a_wrong_known_factor_is_refused(tmp_path: Path, known: str, why: str) -> None:
    file = write_study(tmp_path, "heap", slope, 30.0, 1)
    options = [word for each in known.split() for word in ("--known", each)]
    result = CliRunner().invoke(app, ["study", "calibrate", str(file.parent), *options])
    assert result.exit_code == 2
    assert why in " ".join(result.output.split())


def test_the_likeliest_setting_meets_an_exact_target(tmp_path: Path) -> None:
    files = [
        write_study(tmp_path, name, truth, truth(0.5, 0.2), 3)
        for name, truth in (("heap", slope), ("shear", strength))
    ]
    likeliest = calibration(files, tmp_path).likeliest
    assert likeliest["sliding"] == pytest.approx(0.5, abs=0.05)
    assert likeliest["rolling"] == pytest.approx(0.2, abs=0.04)


def test_what_no_setting_meets_is_said(tmp_path: Path) -> None:
    file = write_study(tmp_path, "heap", slope, 50.0, 1)
    result = CliRunner().invoke(app, ["study", "calibrate", str(file.parent), "--out", str(tmp_path / "out")])
    assert result.exit_code == 4, result.output
    assert "no setting within the ranges meets all targets; missed: answer" in result.output
    assert (tmp_path / "out/calibration.png").is_file()
    assert (tmp_path / "out/calibration.csv").read_text().startswith("factor,unit,likeliest,low,high")


@pytest.mark.parametrize(
    ("old", "missing"), [("target_deviation =", "target_deviation"), ("target =", "target")]
)
def test_half_a_target_is_refused(tmp_path: Path, old: str, missing: str) -> None:
    file = write_study(tmp_path, "heap", slope, 30.0, 1)
    file.write_text(file.read_text().replace(f"\n{old}", "\nnoise = 0.1 #"))
    with pytest.raises(CaseError) as raised:
        read_study(file)
    assert keys_and_kinds(raised.value.problems) == [f"responses.answer.{missing}: missing"]


@pytest.mark.parametrize("rows", [1, 3])
def test_without_runs_enough_nothing_is_calibrated(tmp_path: Path, rows: int) -> None:
    file = write_study(tmp_path, "heap", slope, 30.0, 1)
    table = file.parent / "runs.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:rows]))
    result = CliRunner().invoke(app, ["study", "calibrate", str(file.parent)])
    assert result.exit_code == 2, result.output
    assert "Traceback" not in result.output


def test_without_a_target_nothing_is_calibrated(tmp_path: Path) -> None:
    file = write_study(tmp_path, "heap", slope, 30.0, 1)
    file.write_text("\n".join(row for row in file.read_text().splitlines() if "target" not in row))
    result = CliRunner().invoke(app, ["study", "calibrate", str(file.parent)])
    assert result.exit_code == 2
    assert "no response has a target" in result.output
