"""two_mass against the closed form of linear vibration; tolerances are rounding unless stated."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import scipy.linalg

from adapters.frames.two_mass import build
from orchestrator.ports import Array, Load, linear_frames
from orchestrator.ports.clock import Interval, intervals
from orchestrator.ports.plans import FramesPlan
from tests.frames.machines import ALONG, GRAVITY, POINTS_M, body, exciter, steady_amplitudes_m, two_bodies


def closed_form(speed: float, loss: float, ks: float) -> tuple[complex, complex]:
    """Two masses along x, written out (M1 = 764, M2 = 287 kg, Kg = 0.9 MN/m) and solved by
    Cramer's rule; the unbalance's x component is  me w^2 sin(w t) = Re(-i me w^2 e^{iwt})."""
    damped = 1 + 1j * loss * speed / 78.5
    ground, shear = 0.9e6 * damped, ks * damped
    a, b, d = ground + shear - 764 * speed**2, -shear, shear - 287 * speed**2
    force = -1j * 3.5 * speed**2
    return force * d / (a * d - b * b), -force * b / (a * d - b * b)


@pytest.mark.parametrize("speed", [40.0, 78.5, 90.0, 105.0, 120.0])
def test_amplitude_and_phase_follow_the_closed_form(speed: float) -> None:
    plan = two_bodies((exciter(speed),), loss_factor=2.0, interval_s=2e-3)  # settles in 3 s
    frames = build(plan)
    expected = closed_form(speed, 2.0, 2.37e6 + 4)
    for interval in intervals(4.0, 2e-3):
        motion = frames.advance(interval, Load.zero(4))
    moved = (motion.position_m - POINTS_M)[[0, 2], 0]
    turned = np.exp(1j * speed * 4.0)
    for amplitude, at_end, v in zip(expected, moved, motion.velocity_m_per_s[[0, 2], 0], strict=True):
        # 1e-12 m: the transient has decayed by exp(-40)
        assert at_end == pytest.approx((amplitude * turned).real, abs=1e-12)
        assert v == pytest.approx((1j * speed * amplitude * turned).real, abs=1e-10)
    amplitude_m = steady_amplitudes_m(plan, speed)[:, 0]
    assert amplitude_m == pytest.approx(np.array(expected), rel=1e-12)


def test_driving_frame_stands_still_at_its_antiresonance() -> None:
    """Undamped absorber: a1 = 0 at sqrt(ks / M2) = 90.87 rad/s (Den Hartog, Mechanical
    Vibrations, 1956, sec. 3.2), and there a2 = -force / ks."""
    plan = two_bodies((exciter(),), loss_factor=0.0)
    speed = np.sqrt((2.37e6 + 4) / 287)
    driving, driven = steady_amplitudes_m(plan, speed)[:, 0]
    assert abs(driving) < 1e-14
    assert driven == pytest.approx(1j * 3.5 * speed**2 / (2.37e6 + 4), rel=1e-9)


def test_screen_amplitudes_are_those_of_table_4() -> None:
    """Xu et al. 2024, Table 4 (simulation): driving frame 2.0 mm, driven 7.9 mm along the deck;
    within 0.1 mm, their resolution, plus 2 % for M1, M2, ks rounded to the plan's values."""
    amplitude_mm = 1e3 * abs(steady_amplitudes_m(two_bodies((exciter(),), loss_factor=0.05), 78.5)[:, 0])
    assert amplitude_mm[0] == pytest.approx(2.0, abs=0.14)
    assert amplitude_mm[1] == pytest.approx(7.9, abs=0.26)


def reference(plan: FramesPlan, reaction_N: Array, time_s: float) -> tuple[Array, Array]:
    """Displacement and velocity from rest in the drawn position by one matrix exponential: the
    exciter's cosine and sine and the constant 1 are further states."""
    machine = linear_frames.linearise(plan, linear_frames.TRANSLATIONS)
    n = len(machine.mass)
    (turning,) = plan.exciters
    w, size = turning.speed_rad_per_s, turning.mass_moment_kg_m * turning.speed_rad_per_s**2
    side = np.cross(turning.axis, turning.start)
    a = np.zeros((2 * n + 3, 2 * n + 3))
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -machine.stiffness / np.diag(machine.mass)[:, None]
    a[n : 2 * n, n : 2 * n] = -machine.damping / np.diag(machine.mass)[:, None]
    a[n : n + 3, 2 * n] = size * turning.start / plan.bodies[0].mass_kg
    a[n : n + 3, 2 * n + 1] = size * side / plan.bodies[0].mass_kg
    a[n : 2 * n, 2 * n + 2] = reaction_N.ravel() / np.diag(machine.mass)
    a[2 * n, 2 * n + 1], a[2 * n + 1, 2 * n] = -w, w
    start = np.zeros(2 * n + 3)
    start[2 * n :] = np.cos(turning.phase_rad), np.sin(turning.phase_rad), 1.0
    end = scipy.linalg.expm(a * time_s) @ start
    return end[:n].reshape(-1, 3), end[n : 2 * n].reshape(-1, 3)


@pytest.mark.parametrize("count", [1, 7, 100])
def test_transient_is_that_of_the_matrix_exponential(count: int) -> None:
    plan = two_bodies((exciter(95.0, phase_rad=0.7),))
    frames = build(plan)
    load = Load(np.random.default_rng(1).normal(size=(4, 3)) * 1e3)
    for index in range(count):
        motion = frames.advance(Interval(index, 0.7 / count), load)
    reaction_N = np.array([load.force_N[:2].sum(axis=0), load.force_N[2:].sum(axis=0)])
    x_m, v_m_per_s = reference(plan, reaction_N, 0.7)
    assert motion.position_m - POINTS_M == pytest.approx(x_m.repeat(2, axis=0), abs=1e-13)
    assert motion.velocity_m_per_s == pytest.approx(v_m_per_s.repeat(2, axis=0), abs=1e-11)


def test_run_up_does_not_depend_on_the_step() -> None:
    """1e-11 m on some mm: the angle's third derivative jumps where the run-up ends."""
    ends = []
    for step_s in (0.0, 1e-3):
        frames = build(two_bodies((exciter(run_up_s=0.35),), step_s=step_s))
        for interval in intervals(0.5, 0.05):
            motion = frames.advance(interval, Load.zero(4))
        ends.append(motion.position_m)
    assert ends[0] == pytest.approx(ends[1], abs=1e-11)


@pytest.mark.parametrize("run_up_s", [0.0, 0.1])
def test_an_exciter_that_starts_later_does_the_same_later(run_up_s: float) -> None:
    """The machine rests before 0.1 s, and from then on moves as if the exciter had started at once."""
    late = build(two_bodies((exciter(run_up_s=run_up_s, start_s=0.1, phase_rad=0.7),)))
    soon = build(two_bodies((exciter(run_up_s=run_up_s, phase_rad=0.7),)))
    for index in range(5):
        motion = late.advance(Interval(index, 0.02), Load.zero(4))
        assert motion.position_m == pytest.approx(POINTS_M, abs=1e-14)
    for index in range(5, 20):
        motion = late.advance(Interval(index, 0.02), Load.zero(4))
        expected = soon.advance(Interval(index - 5, 0.02), Load.zero(4))
        assert np.abs(expected.position_m - POINTS_M).max() > 1e-6
        assert motion.position_m == pytest.approx(expected.position_m, abs=1e-13)


def test_a_bushing_loses_pi_c_w_X2_per_cycle() -> None:
    plan = two_bodies((exciter(),), loss_factor=2.0)
    frames = build(plan)
    period_s = 2 * np.pi / 78.5
    for index in range(50):
        frames.advance(Interval(index, period_s), Load.zero(4))
    before = frames.account().lost_J["bushing_damping"]
    frames.advance(Interval(50, period_s), Load.zero(4))
    lost_J = frames.account().lost_J["bushing_damping"] - before
    amplitude = steady_amplitudes_m(plan, 78.5)
    relative = amplitude[1] - amplitude[0]
    c_ground = 4 * 2.0 * 225e3 / 78.5
    c_shear = 2.0 / 78.5 * np.array([2.37e6 + 4, 6e6 + 4e3, 5.8e6 + 4e3])
    expected = np.pi * 78.5 * (c_ground * (abs(amplitude[0]) ** 2).sum())
    expected += np.pi * 78.5 * (c_shear @ abs(relative) ** 2)
    assert lost_J == pytest.approx(expected, rel=1e-11)


def test_a_free_body_falls_by_half_g_t2() -> None:
    plan = replace(
        two_bodies(drawn_at_rest=False), bodies=(body("driving"),), bushings=(), carrier=("driving",) * 4
    )
    frames = build(plan)
    for interval in intervals(0.3, 1e-2):
        motion = frames.advance(interval, Load.zero(4))
    assert motion.position_m - POINTS_M == pytest.approx(np.tile(GRAVITY * 0.3**2 / 2, (4, 1)), abs=1e-14)


def test_bushings_that_cannot_hold_the_weight_are_refused() -> None:
    plan = replace(two_bodies(), bushings=two_bodies().bushings[:4])
    with pytest.raises(ValueError, match="hold"):
        build(plan)


def test_tilted_axes_turn_the_stiffness() -> None:
    """A body on one bushing with soft axis tilted by 30 degrees, pulled by F: x = A^T F / k."""
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    axes = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    plan = two_bodies()
    tilted = replace(plan.bushings[0], axes=axes, stiffness_N_per_m=np.array([1e5, 2e5, 4e5]))
    tilted = replace(tilted, damping_N_s_per_m=np.array([1.2e4, 1.7e4, 2.4e4]))
    plan = replace(plan, bodies=plan.bodies[:1], bushings=(tilted,), carrier=("driving",) * 4)
    frames = build(plan)
    pull_N = 100.0 * ALONG
    for interval in intervals(5.0, 1e-2):
        motion = frames.advance(interval, Load(np.outer([1.0, 0, 0, 0], pull_N)))
    expected = axes.T @ (axes @ pull_N / [1e5, 2e5, 4e5])
    assert motion.position_m[0] - POINTS_M[0] == pytest.approx(expected, abs=1e-13)
