"""exudyn with driven bodies among free ones, against closed forms and other integrators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from adapters.frames import exudyn, prescribed, two_mass
from adapters.frames.drive import moved
from orchestrator.clock import Interval, intervals
from orchestrator.plans import Body, Bushing, Drive, FramesPlan
from orchestrator.ports import Array, Frames, Load
from tests.frames.contract import both_driven, defect_J, drive, loads, one_driven
from tests.frames.machines import GRAVITY, body, exciter

pytestmark = pytest.mark.solver
MASS_kg, STIFFNESS_N_m, DAMPING_N_s_m, SPEED_rad_s = 20.0, 1e5, 600.0, 60.0
NONE = np.zeros(3)


def shaken(amplitude_m: Array, rotation_rad: Array = NONE, run_up_s: float = 0.0) -> Drive:
    return Drive("base", NONE, SPEED_rad_s, amplitude_m, NONE, rotation_rad, NONE, run_up_s)


def on_a_base(base: Drive, bushing: Bushing, step_s: float) -> FramesPlan:
    """A mass whose centre is at the bushing, so that the bushing does not turn it."""
    free = Body("mass", MASS_kg, 0.5 * MASS_kg * np.eye(3), bushing.position_m)
    return FramesPlan(
        bodies=(body("base", 50.0), free),
        bushings=(bushing,),
        exciters=(),
        drives=(base,),
        gravity_m_s2=NONE,
        points_m=bushing.position_m[None],
        carrier=("mass",),
        reaction_N=np.zeros((1, 3)),
        drawn_at_rest=True,
        step_s=step_s,
        sync_interval_s=step_s,
    )


def isotropic(position_m: Array, bodies: tuple[str, str] = ("base", "mass")) -> Bushing:
    size = np.ones(3)
    k, c = STIFFNESS_N_m * size, DAMPING_N_s_m * size
    return Bushing("spring", bodies, position_m, np.eye(3), k, c)


def end_of(plan: FramesPlan, steps: int) -> Array:
    """Place of the carried points after as many steps, one to an interval."""
    frames = exudyn.build(plan)
    for index in range(steps):
        motion = frames.advance(Interval(index, plan.sync_interval_s), Load.zero(1))
    frames.close()
    return motion.position_m


@pytest.mark.parametrize("bodies", [("base", "mass"), ("mass", "base")])
@pytest.mark.parametrize("speed", [30.0, 70.7, 150.0])
def test_transmissibility_of_a_shaken_base(speed: float, bodies: tuple[str, str]) -> None:
    """X / Y = (k + i w c) / (k + i w c - m w^2)  (Den Hartog, Mechanical Vibrations, 1956, sec.
    2.12): amplitude and phase at the resonance of 70.7 rad/s, below and above it, after 1.1 s
    (transient e^-16 = 1e-7).

    The trapezoidal rule has the mass oscillate as at  w' = 2/h tan(w h/2) = w (1 + 3.0e-4)  for
    w h = 0.06, while the base is exact: with w' for the mass it agrees to the transient.  Against
    the closed form the resonance enlarges 3e-4 by  2 k / (w c) = 4.7."""
    step_s = 0.06 / speed
    base = replace(shaken(np.array([1e-3, 0.0, 0.0])), speed_rad_s=speed)
    steps = round(1.1 / step_s)
    found_m = end_of(on_a_base(base, isotropic(NONE, bodies), step_s), steps)[0]
    turned = 1e-3 * np.exp(0.06j * steps)
    for of_mass, within in ((2 / step_s * np.tan(0.03), 1e-6), (speed, 1.5e-3)):
        dynamic = STIFFNESS_N_m + 1j * of_mass * DAMPING_N_s_m - MASS_kg * of_mass**2
        ratio = (STIFFNESS_N_m + 1j * speed * DAMPING_N_s_m) / dynamic
        assert found_m[0] == pytest.approx((ratio * turned).imag, abs=within * abs(ratio) * 1e-3)
    assert found_m[1:] == pytest.approx(np.zeros(2), abs=1e-15)


def rocked(step_s: float, bodies: tuple[str, str], stiffness_N_m: Array) -> FramesPlan:
    """The base swings by 0.4 rad about an oblique axis, with the bushing 0.7 m from its centre."""
    base = shaken(np.array([2e-3, 1e-3, 3e-3]), np.array([0.1, 0.35, -0.15]), run_up_s=0.1)
    spring = isotropic(np.array([0.6, 0.2, 0.3]), bodies)
    damping_N_s_m = 3e-3 * stiffness_N_m
    spring = replace(spring, stiffness_N_m=stiffness_N_m, damping_N_s_m=damping_N_s_m)
    return on_a_base(base, spring, step_s)


def carried_along_m(plan: FramesPlan, duration_s: float) -> Array:
    """The mass of ``rocked`` by an integrator of high order, from Newton's law written out:
    m x'' = A (k e + c e'),  e = A^T (mount - x),  e' = A^T (mount' - x'),  A turning with the
    base.  The mount's place is written out, too; its velocity by differences (1e-10)."""
    base, spring = plan.drives[0], plan.bushings[0]

    def ramp(time_s: float) -> float:
        return float((1 - np.cos(np.pi * min(time_s / base.run_up_s, 1.0))) / 2)

    def turned(time_s: float) -> Rotation:
        return Rotation.from_rotvec(ramp(time_s) * base.rotation_rad * np.sin(SPEED_rad_s * time_s))

    def mount_m(time_s: float) -> Array:
        shift_m = ramp(time_s) * base.amplitude_m * np.sin(SPEED_rad_s * time_s)
        return np.asarray(shift_m + turned(time_s).apply(spring.position_m))

    def rate(time_s: float, state: Array) -> Array:
        axes, h = turned(time_s).as_matrix(), 1e-6
        mount_m_s = (mount_m(time_s + h) - mount_m(time_s - h)) / (2 * h)
        stretch_m, stretch_m_s = (axes.T @ (mount_m(time_s) - state[:3])), mount_m_s - state[3:]
        pull_N = spring.stiffness_N_m * stretch_m + spring.damping_N_s_m * (axes.T @ stretch_m_s)
        return np.concatenate([state[3:], axes @ pull_N / MASS_kg])

    start = np.concatenate([spring.position_m, NONE])
    done = solve_ivp(rate, (0.0, duration_s), start, "DOP853", rtol=1e-10, atol=1e-11)
    return np.asarray(done.y[:3, -1])


@pytest.mark.parametrize(
    ("bodies", "stiffness_N_m"),
    [
        (("base", "mass"), np.array([2e5, 5e4, 1e5])),  # the axes turn with the base
        (("mass", "base"), np.full(3, 1e5)),
    ],
)
def test_a_rocking_body_carries_a_free_one_along_in_second_order(
    bodies: tuple[str, str], stiffness_N_m: Array
) -> None:
    """Halving the step quarters the error.  Its size at h = 0.25 ms: the phase w t (w h)^2 / 12
    = 2e-4 at the highest natural frequency of 100 rad/s, of a motion of 0.5 m."""
    expected_m = carried_along_m(rocked(1.0, bodies, stiffness_N_m), 0.2)
    errors = [
        np.abs(end_of(rocked(0.2 / steps, bodies, stiffness_N_m), steps)[0] - expected_m).max()
        for steps in (200, 400, 800)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)
    assert errors[2] < 1e-4


def compared(one: Frames, other: Frames, reactions: Array, interval_s: float) -> None:
    """Motions to 1e-14 m and 1e-12 m/s in every interval, books to 1e-12 of their size."""
    for index, force_N in enumerate(reactions):
        interval = Interval(index, interval_s)
        found, expected = (
            one.advance(interval, Load(force_N)),
            other.advance(interval, Load(force_N)),
        )
        assert found.position_m == pytest.approx(expected.position_m, abs=1e-14)
        assert found.velocity_m_s == pytest.approx(expected.velocity_m_s, abs=1e-12)
    mine, its = one.account(), other.account()
    assert mine.supplied_J["drive"] == pytest.approx(its.supplied_J["drive"], rel=1e-11)
    assert mine.outside_impulse_N_s == pytest.approx(its.outside_impulse_N_s, rel=1e-11)


def test_with_every_body_driven_it_does_what_prescribed_does() -> None:
    """Massless bodies, as prescribed has them, under reactions of 50 kN."""
    weightless = tuple(
        replace(b, mass_kg=0.0, inertia_kg_m2=np.zeros((3, 3))) for b in both_driven(0.0).bodies
    )
    plan = replace(both_driven(0.0), bodies=weightless, bushings=())
    large = tuple(replace(d, rotation_rad=np.array([0.3, 0.5, -0.4])) for d in plan.drives)
    plan = replace(plan, drives=large)
    compared(exudyn.build(plan), prescribed.build(plan), 100 * loads(300), plan.sync_interval_s)


def test_nothing_turns_a_driven_body_from_its_path() -> None:
    """Neither bushings nor 50 kN on its points: places and velocities are the drive's own."""
    plan = one_driven(0.0)
    frames = exudyn.build(plan)
    for index, force_N in enumerate(100 * loads(300)):
        interval = Interval(index, plan.sync_interval_s)
        motion = frames.advance(interval, Load(force_N))
        place_m, speed_m_s = moved(plan.drives[0], plan.points_m[:2], interval.end_s)
        assert motion.position_m[:2] == pytest.approx(place_m, abs=1e-14)
        assert motion.velocity_m_s[:2] == pytest.approx(speed_m_s, abs=1e-12)


def test_a_drive_gives_its_body_momentum_and_energy() -> None:
    """A body of 764 kg alone: after 0.31 s the drive has done  m v^2 / 2 + w I w / 2 + m g z
    less the reaction's work; and with gravity and reaction given it the momentum m v."""
    rock = np.array([0.0, 0.02, 0.0])
    alone = replace(drive("driving"), rotation_rad=rock, center_m=NONE)
    plan = replace(one_driven(0.0), bodies=(body("driving"),), bushings=(), exciters=())
    plan = replace(plan, drives=(alone,), carrier=("driving",) * 4)
    frames, force_N = exudyn.build(plan), loads(2)[1]
    for interval in intervals(0.31, plan.sync_interval_s):
        motion = frames.advance(interval, Load(force_N))
    place_m, speed_m_s = (value[0] for value in moved(alone, np.zeros((1, 3)), 0.31))
    spin_rad_s = 0.02 * 78.5 * np.cos(78.5 * 0.31 + alone.rotation_phase_rad[1])
    inertia_kg_m2 = plan.bodies[0].inertia_kg_m2[1, 1]
    energy_J = 764 * speed_m_s @ speed_m_s / 2 + inertia_kg_m2 * spin_rad_s**2 / 2
    energy_J -= 764 * GRAVITY @ place_m + np.sum(force_N * (motion.position_m - plan.points_m))
    account = frames.account()
    assert account.supplied_J["drive"] == pytest.approx(energy_J, rel=1e-11)
    assert account.momentum_kg_m_s == pytest.approx(764 * speed_m_s, rel=1e-12)
    given_N_s = 764 * speed_m_s - 0.31 * force_N.sum(axis=0)
    assert account.outside_impulse_N_s == pytest.approx(given_N_s, rel=1e-11)


def test_the_drive_feeds_what_the_bushing_loses() -> None:
    """In the steady state a cycle's work is  pi c w |X - Y|^2  (the loop of a viscous damper).
    At 256 steps a cycle the mass oscillates as at  w (1 + 5e-5), which changes  m w^2  by 1e-4,
    X - Y = m w^2 / (k + i w c - m w^2)  by 2.0e-4 and its square by 3.9e-4."""
    step_s = 2 * np.pi / SPEED_rad_s / 256
    base = shaken(np.array([0.0, 0.0, 2e-3]))
    frames = exudyn.build(on_a_base(base, isotropic(NONE), step_s))
    books = [frames.account()]
    for index in range(256 * 9):
        frames.advance(Interval(index, step_s), Load.zero(1))
        if index + 1 in (256 * 8, 256 * 9):
            books.append(frames.account())
    start, before, after = books
    pull = STIFFNESS_N_m + 1j * SPEED_rad_s * DAMPING_N_s_m
    stretch_m = 2e-3 * abs(pull / (pull - MASS_kg * SPEED_rad_s**2) - 1)
    cycle_J = np.pi * DAMPING_N_s_m * SPEED_rad_s * stretch_m**2
    supplied_J = after.supplied_J["drive"] - before.supplied_J["drive"]
    lost_J = after.lost_J["bushing_damping"] - before.lost_J["bushing_damping"]
    assert supplied_J == pytest.approx(cycle_J, rel=4.5e-4)
    assert lost_J == pytest.approx(cycle_J, rel=4.5e-4)
    assert defect_J(start, after) == pytest.approx(0.0, abs=1e-12 * after.supplied_J["drive"])


@pytest.mark.parametrize(
    ("broken", "named"),
    [
        (replace(one_driven(0.0), drives=(drive("ground"),)), "ground cannot be driven"),
        (replace(one_driven(0.0), drives=(drive("drivne"),)), "drivne"),
        (replace(one_driven(0.0), drives=(drive("driving"),) * 2), "one drive per body"),
        (replace(one_driven(0.0), exciters=(exciter(),)), r"driven and excited: \['driving'\]"),
        (
            replace(one_driven(0.0), drives=(replace(drive("driving"), rotation_rad=GRAVITY),)),
            "may turn it by 9.81 rad; the limit is 1.4 rad",
        ),
    ],
)
def test_drives_that_make_no_sense_are_refused(broken: FramesPlan, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        exudyn.build(broken)


def test_two_mass_refuses_drives_and_names_who_takes_them() -> None:
    with pytest.raises(ValueError, match="the drive of 'driving' needs exudyn"):
        two_mass.build(one_driven(0.0))
