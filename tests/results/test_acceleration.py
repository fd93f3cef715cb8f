"""Sine motions have the accelerations of the textbook."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.output.records.history import write_accelerations
from orchestrator.output.results.estimate import chance
from orchestrator.output.results.machine import acceleration_series, panel_points, rms
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports.acceleration import acceleration_m_per_s2, band_hz
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from tests.results.synthetic import folder_of

SPEED = 78.5
STEP_S = 1e-4
TIME = np.arange(0.0, 10 * 2 * np.pi / SPEED, STEP_S)
Z = np.array([0.0, 0.0, 1.0])


def test_a_sine_has_a_w_squared() -> None:
    """5 mm at 78.5 rad/s: 3.142 g; RMS by the square root of 2."""
    velocity = np.outer(0.005 * SPEED * np.cos(SPEED * TIME), Z)
    acceleration_g = acceleration_m_per_s2(velocity, STEP_S)[1000:-1000, 2] / STANDARD_GRAVITY_M_PER_S2
    peak = 0.005 * SPEED**2 / STANDARD_GRAVITY_M_PER_S2
    assert np.abs(acceleration_g).max() == pytest.approx(peak, rel=1e-3)
    assert rms(acceleration_g) == pytest.approx(peak / np.sqrt(2), rel=0.02)


@pytest.mark.parametrize(("hertz", "kept"), [(50.0, True), (2500.0, False)])
def test_the_band_ends_at_500_hz(hertz: float, kept: bool) -> None:
    w = 2 * np.pi * hertz
    velocity = np.outer(np.cos(w * TIME) / w, Z)
    size = np.abs(acceleration_m_per_s2(velocity, STEP_S)[2000:-2000]).max()
    assert size == pytest.approx(1.0, rel=1e-3) if kept else size < 2e-3


@pytest.mark.parametrize("hertz", [80.0, 250.0, 450.0])
@pytest.mark.parametrize("step_s", [1e-4, 4e-4, 8e-4])
def test_rows_that_are_farther_apart_show_the_same_accelerations(hertz: float, step_s: float) -> None:
    """Central differences would show 0.34 of those of 450 Hz at 0.8 ms.  The filter lets pass
    1 / (1 + (f / 500 Hz)^8)."""
    w, time_s = 2 * np.pi * hertz, np.arange(0.0, 1.0, step_s)
    velocity = np.outer(np.sin(w * time_s) / w, Z)
    inside = slice(len(time_s) // 4, -len(time_s) // 4)
    expected = np.cos(w * time_s) / (1.0 + (hertz / 500.0) ** 8)
    computed_m_per_s2 = acceleration_m_per_s2(velocity, step_s)[:, 2]
    np.testing.assert_allclose(computed_m_per_s2[inside], expected[inside], atol=2e-3)


def test_steps_longer_than_the_band_are_not_filtered() -> None:
    velocity = np.outer(np.arange(50) * 2.0, Z)
    assert acceleration_m_per_s2(velocity, 1.0)[:, 2] == pytest.approx(np.full(50, 2.0))


def test_the_series_of_a_run_are_those_of_the_report(tmp_path: Path) -> None:
    """The series stand in ``history.h5``, with the band; the probes' largest ones are the report's."""
    folder = folder_of(tmp_path / "run", particles=False, cycles=12)
    with RunReader(folder) as run:
        series = acceleration_series(run)
        reported = panel_points(run, *run.second_half_s, chance)
        time_s, span_s = run.series_s(), run.second_half_s
    write_accelerations(folder / "history.h5", series, band_hz(float(time_s[1] - time_s[0])))
    with h5py.File(folder / "history.h5") as history:
        assert history["accelerations"].attrs["band_Hz"] == pytest.approx(499.7, abs=0.1)
        assert {"driving", "driven"} <= set(history["accelerations"])
        for name, figures in reported.items():
            recorded = history[f"accelerations/{name}"]
            inside = (recorded["time_s"][:] > span_s[0]) & (recorded["time_s"][:] <= span_s[1])
            size = np.linalg.norm(recorded["acceleration_m_per_s2"][:][inside], axis=1)
            assert size.max() / STANDARD_GRAVITY_M_PER_S2 == pytest.approx(figures.peak_g, rel=1e-6)


def test_a_series_that_a_resumed_run_made_coarser_has_no_accelerations(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run", particles=False, cycles=3)
    with h5py.File(folder / "history.h5", "r+") as history:
        times = history["frames/driven/time_s"]
        times[-5:] = times[-5:] + np.arange(5)
    with RunReader(folder) as run:
        assert "driven" not in acceleration_series(run)
        assert "driving" in acceleration_series(run)
