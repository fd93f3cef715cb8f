"""exudyn with driven bodies among free ones, against closed forms and other integrators."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adapters.frames import exudyn, prescribed, two_mass
from adapters.frames.common.drive import driving
from orchestrator.ports import Array, Load
from orchestrator.ports.clock import Interval, intervals
from orchestrator.ports.plans import DrivePlan, FramesPlan
from tests.frames.contract import both_driven, compared, defect_J, drive, loads, one_driven
from tests.frames.driven_base import (
    NONE,
    DAMPING_N_s_per_m,
    MASS_kg,
    SPEED_rad_per_s,
    STIFFNESS_N_per_m,
    carried_along_m,
    isotropic,
    on_a_base,
    rocked,
    shaken,
)
from tests.frames.machines import GRAVITY, body, exciter

pytestmark = pytest.mark.solver
TURN_rad = np.array([0.1, 0.35, -0.15])


def carried(drive: DrivePlan, points_m: Array, time_s: float) -> tuple[Array, Array]:
    """Position and velocity of points that a driven body carries."""
    return driving(drive, time_s).carried(points_m - drive.center_m)


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
    base = replace(shaken(np.array([1e-3, 0.0, 0.0])), speed_rad_per_s=speed)
    steps = round(1.1 / step_s)
    found_m = end_of(on_a_base(base, isotropic(NONE, bodies), step_s), steps)[0]
    turned = 1e-3 * np.exp(0.06j * steps)
    for of_mass, within in ((2 / step_s * np.tan(0.03), 1e-6), (speed, 1.5e-3)):
        dynamic = STIFFNESS_N_per_m + 1j * of_mass * DAMPING_N_s_per_m - MASS_kg * of_mass**2
        ratio = (STIFFNESS_N_per_m + 1j * speed * DAMPING_N_s_per_m) / dynamic
        assert found_m[0] == pytest.approx((ratio * turned).imag, abs=within * abs(ratio) * 1e-3)
    assert found_m[1:] == pytest.approx(np.zeros(2), abs=1e-15)


@pytest.mark.parametrize(
    ("bodies", "stiffness_N_per_m"),
    [
        (("base", "mass"), np.array([2e5, 5e4, 1e5])),  # the axes turn with the base
        (("mass", "base"), np.full(3, 1e5)),
    ],
)
def test_a_rocking_body_carries_a_free_one_along_in_second_order(
    bodies: tuple[str, str], stiffness_N_per_m: Array
) -> None:
    """Halving the step quarters the error.  Its size at h = 0.25 ms: the phase w t (w h)^2 / 12
    = 2e-4 at the highest natural frequency of 100 rad/s, of a motion of 0.5 m."""
    expected_m = carried_along_m(rocked(1.0, TURN_rad, bodies, stiffness_N_per_m), 0.2)
    errors = [
        np.abs(end_of(rocked(0.2 / steps, TURN_rad, bodies, stiffness_N_per_m), steps)[0] - expected_m).max()
        for steps in (200, 400, 800)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)
    assert errors[2] < 1e-4


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
    """Bushings do not, nor 50 kN on its points: places and velocities are the drive's own."""
    plan = one_driven(0.0)
    frames = exudyn.build(plan)
    for index, force_N in enumerate(100 * loads(300)):
        interval = Interval(index, plan.sync_interval_s)
        motion = frames.advance(interval, Load(force_N))
        place_m, speed_m_per_s = carried(plan.drives[0], plan.points_m[:2], interval.end_s)
        assert motion.position_m[:2] == pytest.approx(place_m, abs=1e-14)
        assert motion.velocity_m_per_s[:2] == pytest.approx(speed_m_per_s, abs=1e-12)


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
    place_m, speed_m_per_s = (value[0] for value in carried(alone, np.zeros((1, 3)), 0.31))
    spin_rad_per_s = 0.02 * 78.5 * np.cos(78.5 * 0.31 + alone.rotation_phase_rad[1])
    inertia_kg_m2 = plan.bodies[0].inertia_kg_m2[1, 1]
    energy_J = 764 * speed_m_per_s @ speed_m_per_s / 2 + inertia_kg_m2 * spin_rad_per_s**2 / 2
    energy_J -= 764 * GRAVITY @ place_m + np.sum(force_N * (motion.position_m - plan.points_m))
    account = frames.account()
    assert account.supplied_J["drive"] == pytest.approx(energy_J, rel=1e-11)
    assert account.momentum_kg_m_per_s == pytest.approx(764 * speed_m_per_s, rel=1e-12)
    given_N_s = 764 * speed_m_per_s - 0.31 * force_N.sum(axis=0)
    assert account.outside_impulse_N_s == pytest.approx(given_N_s, rel=1e-11)


def test_the_drive_feeds_what_the_bushing_loses() -> None:
    """A cycle's work in the steady state is pi c w |X - Y|^2 (the loop of a viscous damper). At 256 steps a
    cycle the mass oscillates as at w (1 + 5e-5), which changes m w^2 by 1e-4, X - Y = m w^2 / (k + i w c -
    m w^2) by 2.0e-4 and its square by 3.9e-4."""
    step_s = 2 * np.pi / SPEED_rad_per_s / 256
    base = shaken(np.array([0.0, 0.0, 2e-3]))
    frames = exudyn.build(on_a_base(base, isotropic(NONE), step_s))
    books = [frames.account()]
    for index in range(256 * 9):
        frames.advance(Interval(index, step_s), Load.zero(1))
        if index + 1 in (256 * 8, 256 * 9):
            books.append(frames.account())
    start, before, after = books
    pull = STIFFNESS_N_per_m + 1j * SPEED_rad_per_s * DAMPING_N_s_per_m
    stretch_m = 2e-3 * abs(pull / (pull - MASS_kg * SPEED_rad_per_s**2) - 1)
    cycle_J = np.pi * DAMPING_N_s_per_m * SPEED_rad_per_s * stretch_m**2
    supplied_J = after.supplied_J["drive"] - before.supplied_J["drive"]
    lost_J = after.lost_J["bushing_damping"] - before.lost_J["bushing_damping"]
    assert supplied_J == pytest.approx(cycle_J, rel=4.5e-4)
    assert lost_J == pytest.approx(cycle_J, rel=4.5e-4)
    assert defect_J(start, after) == pytest.approx(0.0, abs=1e-12 * after.supplied_J["drive"])


@pytest.mark.parametrize(
    ("broken", "named"),
    [
        (replace(one_driven(0.0), drives=(drive("ground"),)), "ground"),
        (replace(one_driven(0.0), drives=(drive("drivne"),)), "drivne"),
        (replace(one_driven(0.0), drives=(drive("driving"),) * 2), "driving.*driving"),
        (replace(one_driven(0.0), exciters=(exciter(),)), r"\['driving'\]"),
        (
            replace(one_driven(0.0), drives=(replace(drive("driving"), rotation_rad=GRAVITY),)),
            r"'driving'.*\b9\.81\b.*\b1\.4\b",
        ),
    ],
)
def test_drives_that_make_no_sense_are_refused(broken: FramesPlan, named: str) -> None:
    with pytest.raises(ValueError, match=named):
        exudyn.build(broken)


def test_two_mass_refuses_drives_and_names_who_takes_them() -> None:
    with pytest.raises(ValueError, match=r"'driving'.*exudyn"):
        two_mass.build(one_driven(0.0))
