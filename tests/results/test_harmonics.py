"""First harmonics of motions whose amplitude, phase and disturbance are known."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.cycles import (
    count_whole_cycles,
    cycle_number,
    cycle_numbers,
    cycle_s,
    is_driven,
    within,
)
from orchestrator.output.results.estimate import TOO_FEW, remaining_drift
from orchestrator.output.results.harmonics import drift, ellipse, first_harmonic
from orchestrator.output.results.machine import mostly_other
from orchestrator.output.results.run_reader import cut_size_m
from orchestrator.ports import Array
from orchestrator.preflight.judge import load_judged
from tests.runs.outside import ROOT

SPEED = 78.5
CYCLE_S = 2 * np.pi / SPEED
STEP_S = 4e-4
AMPLITUDE_M = np.array([5.6e-3, 0.0, 3e-3])
PHASE = np.array([0.7, 0.0, -2.0])
PHASOR = AMPLITUDE_M * np.exp(1j * PHASE)


def times(cycles: float, step_s: float = STEP_S) -> Array:
    return np.arange(0.0, cycles * CYCLE_S, step_s)


def wave(time_s: Array, phasor: Array = PHASOR, speed: float = SPEED) -> Array:
    return np.real(phasor * np.exp(1j * speed * time_s)[:, None])


@pytest.mark.parametrize("cycles", [1, 1.3, 2, 5.5, 7.4, 20, 33.9])
def test_amplitude_and_phase_of_a_sine_at_any_place(cycles: float) -> None:
    """The sine is met also where the rows are no whole number of cycles, and drift."""
    time_s = times(cycles + 0.01)
    moved = wave(time_s) + np.array([0.1, 0.0, 3.0]) + np.outer(time_s, [0.01, 0.0, -0.02])
    harmonic = first_harmonic(time_s, moved, CYCLE_S)
    assert harmonic.phasor == pytest.approx(PHASOR, abs=1e-13)
    assert harmonic.amplitude == pytest.approx(AMPLITUDE_M, abs=1e-13)
    assert harmonic.other == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize("cycles", [2.2, 5.0, 9.7])
def test_harmonics_change_nothing(cycles: float) -> None:
    """Half the range would be 6.6 mm, not 5.6: a slack panel's middle, a frame with a stop."""
    time_s = times(cycles)
    moved = wave(time_s) + sum(wave(time_s, 1e-3 * np.ones(3), k * SPEED) for k in (2, 3, 7))
    harmonic = first_harmonic(time_s, moved, CYCLE_S)
    assert harmonic.amplitude == pytest.approx(AMPLITUDE_M, abs=1e-5)
    assert harmonic.phasor == pytest.approx(PHASOR, abs=1e-5)
    assert harmonic.other[0] > 2e-3


def test_a_slow_swing_hardly_leaks_into_it() -> None:
    """2 mm at 29 rad/s, which decays, beside 5.6 mm at 78.5 rad/s: Hann's side lobes beyond the sixth
    are below 1e-3; without a window it would be 2 %."""
    time_s = times(10)
    swing = np.outer(2e-3 * np.exp(-time_s) * np.cos(29 * time_s), [1.0, 0.0, 0.0])
    harmonic = first_harmonic(time_s, wave(time_s) + swing, CYCLE_S, interval_of=remaining_drift)
    assert harmonic.amplitude[0] == pytest.approx(5.6e-3, rel=2e-3)
    assert harmonic.half_width is not None
    assert harmonic.half_width[0] > abs(harmonic.amplitude[0] - 5.6e-3)


def test_the_interval_holds_the_amplitude_under_noise() -> None:
    """The interval holds in 95 of 100 runs or so, and is not raised by the noise: a mean of half ranges
    would be."""
    time_s, rng = times(40), np.random.default_rng(1)
    inside, amplitudes_m = 0, []
    for _ in range(200):
        moved = wave(time_s) + rng.normal(0.0, 1e-3, (len(time_s), 3))
        harmonic = first_harmonic(time_s, moved, CYCLE_S)
        assert harmonic.half_width is not None
        inside += abs(harmonic.amplitude[0] - AMPLITUDE_M[0]) <= harmonic.half_width[0]
        amplitudes_m.append(harmonic.amplitude[0])
    assert 180 <= inside <= 199
    assert np.mean(amplitudes_m) == pytest.approx(AMPLITUDE_M[0], rel=1e-3)


def test_few_cycles_have_no_interval() -> None:
    time_s = times(4.2)
    harmonic = first_harmonic(time_s, wave(time_s), CYCLE_S)
    assert (harmonic.half_width, harmonic.batches) == (None, 4)
    assert harmonic.estimate(0).half_width is None
    assert harmonic.estimate(0).reason == TOO_FEW


def test_drift_is_the_change_between_the_halves() -> None:
    """An amplitude that grows by a tenth from cycle 5 of 10 to the end."""
    time_s = times(10.01)
    grown = np.where(time_s > 5 * CYCLE_S, 1.1, 1.0)[:, None]
    assert drift([first_harmonic(time_s, grown * wave(time_s), CYCLE_S)]) == pytest.approx(
        0.1 / 1.05, rel=0.01
    )
    assert drift([first_harmonic(time_s, wave(time_s), CYCLE_S)]) == pytest.approx(0.0, abs=1e-12)
    assert drift([first_harmonic(times(2), wave(times(2)), CYCLE_S)]) is None


def test_less_than_a_cycle_is_refused() -> None:
    time_s = times(0.9)
    with pytest.raises(ValueError, match="cycle"):
        first_harmonic(time_s, wave(time_s), CYCLE_S)


@pytest.mark.parametrize(
    ("x", "z", "major", "minor", "tilt_deg"),
    [
        (2.0, 0.0, 2.0, 0.0, 0.0),  # a line along x
        (1.0, 1.0, np.sqrt(2), 0.0, 45.0),  # a line
        (3.0, -1j, 3.0, 1.0, 0.0),  # cos, sin: turns from x towards z
        (3.0, 1j, 3.0, -1.0, 0.0),  # and back
        (1.0, -2j, 2.0, 1.0, 90.0),
        (1.0, -1j, 1.0, 1.0, 0.0),  # a circle
    ],
)
def test_ellipses(x: complex, z: complex, major: float, minor: float, tilt_deg: float) -> None:
    result = ellipse(x, z)
    assert result[:2] == pytest.approx((major, minor), abs=1e-12)
    if abs(major) != abs(minor):
        assert np.degrees(result[2]) % 180 == pytest.approx(tilt_deg, abs=1e-9)


def test_the_end_of_a_cycle_belongs_to_it_whatever_the_rounding() -> None:
    time_s = np.array([0.0, 0.5, 1.0 - 1e-12, 1.0, 1.0 + 1e-12, 1.1, 2.0, 2.0 + 1e-9]) * CYCLE_S
    assert cycle_numbers(time_s, CYCLE_S).tolist() == [0, 0, 0, 0, 0, 1, 1, 1]
    assert [cycle_number(t, CYCLE_S) for t in time_s.tolist()] == [0, 0, 0, 0, 0, 1, 1, 1]
    assert cycle_numbers(time_s + 3.0, CYCLE_S, 3.0).tolist() == [0, 0, 0, 0, 0, 1, 1, 1]
    assert [count_whole_cycles(t, 1.0) for t in (0.0, 0.9, 1.0 - 1e-9, 1.0, 2.5)] == [0, 0, 1, 1, 2]
    assert within(time_s, 0.0, CYCLE_S, CYCLE_S).tolist() == [False] + 4 * [True] + 3 * [False]


def test_a_run_of_exactly_one_cycle_is_one_of_a_driven_machine() -> None:
    """A cycle takes 0.08 s at 750 rpm."""
    sets = ["duration_s=0.08", f"screen.exciters.shaft.speed_rad_per_s={25 * np.pi!r}"]
    case = load_judged(ROOT / "cases/empty-machine", None, sets).case
    assert cycle_s(case) == case.duration_s
    assert is_driven(case)
    still = load_judged(ROOT / "cases/ball-on-panel", "draft", []).case
    assert not is_driven(still)


def test_a_drive_without_amplitude_drives_nothing() -> None:
    case = load_judged(ROOT / "cases/panel-cycle", "draft", []).case
    row = case.screen.frames["moving"]
    assert row.drive is not None
    assert is_driven(case)
    still = row.drive.model_copy(update={"amplitude_m": (0.0, 0.0, 0.0)})
    frames = case.screen.frames | {"moving": row.model_copy(update={"drive": still})}
    screen = case.screen.model_copy(update={"frames": frames})
    assert not is_driven(case.model_copy(update={"screen": screen}))


@pytest.mark.parametrize(("twice", "named"), [(0.3, ""), (3.0, "fast")])
def test_a_motion_of_twice_the_frequency_is_named(twice: float, named: str) -> None:
    """A machine with a slow shaft that is weak has such a motion, for example; what hardly moves does not
    count."""
    time_s = times(20)
    slow, noise = wave(time_s), 1e-3 * wave(time_s, speed=3.3 * SPEED)
    motions = {"slow": slow, "still": noise, "fast": slow + twice * wave(time_s, speed=2 * SPEED)}
    harmonics = {name: first_harmonic(time_s, values, CYCLE_S) for name, values in motions.items()}
    assert mostly_other(harmonics) == named


def test_the_cut_of_coarse_particles_is_as_coarse_as_they_are() -> None:
    case = load_judged(ROOT / "cases/quickstart", "draft", ["output.cut_size_m=0.012"]).case
    coarse = case.particles.model_copy(update={"coarse_graining": 1.5})
    assert cut_size_m(case) == 0.012
    assert cut_size_m(case.model_copy(update={"particles": coarse})) == pytest.approx(0.018)
