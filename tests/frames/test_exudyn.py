"""exudyn against closed forms and against two_mass; each tolerance is the scheme's own error."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from adapters.frames import exudyn, two_mass
from orchestrator.ports import Array, Load
from orchestrator.ports.clock import Interval, intervals
from orchestrator.ports.plans import FramesPlan, SolverFailed
from tests.frames.machines import (
    ACROSS,
    ALONG,
    GRAVITY,
    POINTS_M,
    body,
    bushing,
    exciter,
    steady_amplitudes_m,
    two_bodies,
)

pytestmark = pytest.mark.solver


def end_of(plan: FramesPlan, duration_s: float, load: Load | None = None) -> Array:
    """Displacements of the carried points (4, 3) after ``duration_s``."""
    frames = exudyn.build(plan)
    for interval in intervals(duration_s, plan.sync_interval_s):
        motion = frames.advance(interval, load or Load.zero(4))
    frames.close()
    return np.asarray(motion.position_m - POINTS_M)


def shaken_along(speed_rad_per_s: float, run_up_s: float = 0.0, **changed: float) -> FramesPlan:
    """Two counter-rotating unbalances, and no weight: all forces and stretches lie along x, so
    the bodies only translate, as in two_mass.  (A bushing whose stretch turns about an axis
    passes a couple c w X^2 on, and one that carries weight a couple stretch x force; with one
    unbalance they pitch the driving frame by 1e-4 rad, which is real.)"""
    pair = tuple(
        exciter(speed_rad_per_s, run_up_s, axis=axis, start=ALONG, mass_moment_kg_m=1.75)
        for axis in (ACROSS, -ACROSS)
    )
    return replace(two_bodies(pair, **changed), gravity_m_per_s2=np.zeros(3))  # type: ignore[arg-type]


@pytest.mark.parametrize("speed", [40.0, 78.5, 90.0, 120.0])
def test_amplitude_and_phase_follow_the_two_mass_closed_form(speed: float) -> None:
    """The motion is compared after 1.2 s (transient e^-12). The trapezoidal rule sees the frequency (2/h)
    tan(w h/2) = w (1 + (w h)^2 / 12): at h = 5e-4 s, 3e-4 at 120 rad/s, times up to three where a resonance
    is near; 0.1 % of the larger amplitude."""
    plan = shaken_along(speed, loss_factor=2.0, interval_s=5e-4, step_s=5e-4)
    moved = end_of(plan, 1.2)[[0, 2]]
    amplitude = steady_amplitudes_m(plan, speed)
    expected = (amplitude * np.exp(1j * speed * 1.2)).real
    assert moved == pytest.approx(expected, abs=1e-3 * np.abs(amplitude).max())


def test_second_order_in_the_step() -> None:
    """The reference is two_mass, which is exact where nothing rotates: halving quarters the error. Its
    size: phase w t (w h)^2 / 12 at the resonance of 108 rad/s, 8e-3, times some 10 mm."""
    errors = []
    for step_s in (1e-3, 5e-4):
        plan = shaken_along(95.0, run_up_s=0.1, interval_s=1e-3, step_s=step_s)
        exact = two_mass.build(replace(plan, step_s=0.0))
        for interval in intervals(0.3, 1e-3):
            motion = exact.advance(interval, Load.zero(4))
        errors.append(np.abs(end_of(plan, 0.3) - (motion.position_m - POINTS_M)).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.03)
    assert errors[1] < 8e-5


def test_a_free_body_falls_by_half_g_t2() -> None:
    plan = replace(
        two_bodies(drawn_at_rest=False, interval_s=1e-2, step_s=1e-2),
        bodies=(body("driving"),),
        bushings=(),
        carrier=("driving",) * 4,
    )
    fallen = np.tile(GRAVITY * 0.3**2 / 2, (4, 1))
    assert end_of(plan, 0.3) == pytest.approx(fallen, abs=1e-13)


def pitching(center_m: Array) -> FramesPlan:
    """One body on four ground bushings, x = +-0.9 m, level with its centre of mass."""
    plan = two_bodies(interval_s=5e-4, step_s=5e-4, loss_factor=0.0)
    places = [center_m + np.array([x, y, 0.0]) for x in (-0.9, 0.9) for y in (-0.4, 0.4)]
    return replace(
        plan,
        bodies=(body("driving", center_m=center_m),),
        bushings=tuple(bushing(("ground", "driving"), p, (225e3,) * 3, 0.0) for p in places),
        carrier=("driving",) * 4,
    )


def test_pitch_frequency_is_sqrt_of_k_x2_over_I() -> None:
    """A small pitch moment held for the whole run: theta = M / (sum k x^2) (1 - cos(w t)); half
    a period after the start the swing is at its top, 2 M / sum k x^2 (cosine flat there), and
    after a quarter it passes the middle, sensitive to the frequency: 0.1 %."""
    center_m = np.array([0.2, 0.1, 0.3])
    plan = pitching(center_m)
    stiffness, inertia = 4 * 225e3 * 0.9**2, 0.67 * 764.0
    period_s = 2 * np.pi / np.sqrt(stiffness / inertia)
    points_m = center_m + np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 0, 0], [0, 0, 1.0]])
    plan = replace(plan, points_m=points_m)
    load = Load(np.array([[0, 0, 50.0], [0, 0, -50.0], [0, 0, 0], [0, 0, 0]]))  # -100 N m
    for fraction, share in ((0.25, 1.0), (0.5, 2.0), (1.25, 1.0)):
        steps = round(fraction * period_s / 5e-4)
        plan = replace(plan, sync_interval_s=fraction * period_s / steps, step_s=1e-3)
        frames = exudyn.build(plan)
        for index in range(steps):
            motion = frames.advance(Interval(index, plan.sync_interval_s), load)
        lift_m = motion.position_m[:, 2] - points_m[:, 2]
        expected = share * 100.0 / stiffness
        assert lift_m[0] == pytest.approx(expected, rel=1e-3)
        assert lift_m[1] == pytest.approx(-expected, rel=1e-3)
        assert abs(lift_m[2]) < 1e-6 * expected


def test_an_exciter_off_centre_pitches_the_body() -> None:
    """Rigid body, exciter at height b above the centre: steady pitch amplitude
    me w^2 b / |k_pitch - I w^2 + i w c_pitch|, about y; and the period's mean vanishes."""
    w, height = 78.5, 0.226
    plan = two_bodies(interval_s=5e-4, step_s=5e-4)
    places = [np.array([x, y, 0.0]) for x in (-0.9, 0.9) for y in (-0.4, 0.4)]
    loss = 2.0
    plan = replace(
        plan,
        bodies=(body("driving"),),
        bushings=tuple(bushing(("ground", "driving"), p, (225e3,) * 3, loss) for p in places),
        exciters=(exciter(w, position_m=np.array([0.0, 0.0, height])),),
        carrier=("driving",) * 4,
        points_m=np.array([[0.0, 0, 0], [1.0, 0, 0], [-1.0, 0, 0], [0, 1.0, 0]]),
    )
    frames = exudyn.build(plan)
    pitch = []
    for interval in intervals(1.0, 5e-4):
        motion = frames.advance(interval, Load.zero(4))
        pitch.append((motion.position_m[2, 2] - motion.position_m[1, 2]) / 2)
    stiffness = 4 * 225e3 * 0.9**2
    dynamic = stiffness - 0.67 * 764 * w**2 + 1j * w * loss / 78.5 * stiffness
    expected = 3.5 * w**2 * height / abs(dynamic)
    last = np.array(pitch[-round(2 * np.pi / w / 5e-4) :])
    # the peak between two samples is (w h)^2 / 8 = 2e-4 higher at most; scheme 3e-4
    assert (last.max() - last.min()) / 2 == pytest.approx(expected, rel=1e-3)


def test_preload_keeps_the_machine_still_with_everything_off_centre() -> None:
    base = two_bodies()
    shift_m = np.array([0.1, 0.05, -0.1])
    tilted = np.array([[0.8, 0, 0.6], [0, 1, 0], [-0.6, 0, 0.8]])
    bushings = [replace(b, position_m=b.position_m + shift_m) for b in base.bushings]
    bushings[0] = replace(bushings[0], axes=tilted)
    reaction_N = 200.0 * np.random.default_rng(4).normal(size=(4, 3))
    plan = replace(base, bushings=tuple(bushings), reaction_N=reaction_N)
    assert np.abs(end_of(plan, 1.0, Load(reaction_N))).max() < 1e-12


def test_a_machine_at_rest_stays_for_seconds() -> None:
    """Its residuals are the rounding of large forces, which Newton must take for zero."""
    assert np.abs(end_of(two_bodies(), 2.0)).max() < 1e-12


def test_a_body_without_preload_settles_at_its_static_sag() -> None:
    plan = two_bodies(drawn_at_rest=False, loss_factor=2.0)
    sag = end_of(plan, 1.2)[0, 2]
    weight_N = (764 + 287) * 9.81
    # the transient is down to e^-12 = 6e-6
    assert sag == pytest.approx(-weight_N / 0.9e6, rel=2e-5)


def test_a_torque_free_top_keeps_momentum_and_energy() -> None:
    """No bushings: a spun-up asymmetric body; nothing acts, so its kinetic energy stays (1e-5
    for the trapezoidal rule over 2 rad of tumbling)."""
    plan = replace(
        two_bodies(drawn_at_rest=False, interval_s=1e-3, step_s=1e-3),
        bodies=(body("driving"),),
        bushings=(),
        carrier=("driving",) * 4,
        gravity_m_per_s2=np.zeros(3),
    )
    frames = exudyn.build(plan)
    kick = np.random.default_rng(5).normal(size=(4, 3))
    kick = Load(2e4 * (kick - kick.mean(axis=0)))
    run = list(intervals(1.0, 1e-3))
    for interval in run[:50]:
        frames.advance(interval, kick)
    kinetic_J = frames.account().stored_J["kinetic"]
    for interval in run[50:]:
        frames.advance(interval, Load.zero(4))
    assert frames.account().stored_J["kinetic"] == pytest.approx(kinetic_J, rel=1e-5)
    assert frames.account().momentum_kg_m_per_s == pytest.approx(np.zeros(3), abs=1e-9)


def test_a_body_that_turns_over_stops_the_run_with_its_time() -> None:
    """The couple of two forces that stay upright gives angle'' = M / I cos(angle), with M / I =
    2 * 1e5 / 512 = 391 rad/s^2: 1.4 rad after the integral of 1 / sqrt(2 M / I sin(angle)), 0.0875 s."""
    plan = replace(
        two_bodies(drawn_at_rest=False, interval_s=1e-3, step_s=1e-3),
        bodies=(body("driving"),),
        bushings=(),
        carrier=("driving",) * 4,
        points_m=np.array([[1.0, 0, 0], [-1.0, 0, 0], [0, 0, 0], [0, 0, 0]]),
    )
    up = Load(1e5 * np.array([[0, 0, 1.0], [0, 0, -1.0], [0, 0, 0], [0, 0, 0]]))
    frames = exudyn.build(plan)

    def run() -> None:
        for interval in intervals(0.3, 1e-3):
            frames.advance(interval, up)

    with pytest.raises(SolverFailed) as stopped:
        run()
    time_s, tilt_rad = map(float, re.findall(r"\d+\.\d+", str(stopped.value)))
    expected_s = quad(lambda angle_rad: (2 * 2e5 / 512 * np.sin(angle_rad)) ** -0.5, 0.0, 1.4)[0]
    assert time_s == pytest.approx(expected_s, abs=1e-3)  # one sync interval
    assert tilt_rad == pytest.approx(1.4, abs=0.04)


def test_only_the_y_axis_exciter_stays_in_plane() -> None:
    plan = two_bodies((exciter(axis=ACROSS),), interval_s=1e-3)
    assert np.abs(end_of(plan, 0.05)[:, 1]).max() < 1e-12
