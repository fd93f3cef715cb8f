"""Steady motion of frames against closed forms and against the adapters' own equations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from orchestrator.ports import linear_frames
from orchestrator.ports.plans import DrivePlan
from orchestrator.preflight.scene.shaking import PanelSpring, solve_shakings
from tests.frames.machines import bushing, exciter, steady_amplitudes_m, two_bodies

ENDS_M = np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0]])
ALONG = np.array([1.0, 0.0, 0.0])
PAIR = ("driving", "driven")


@pytest.mark.parametrize("speed", [40.0, 78.5, 105.0])
def test_two_masses_move_as_the_closed_form_says(speed: float) -> None:
    plan = two_bodies((exciter(speed),))
    (motion,) = solve_shakings(plan)
    wanted = steady_amplitudes_m(plan, speed)
    for row, name in zip(wanted, PAIR, strict=True):
        assert motion.amplitude_m[name] == pytest.approx(row, rel=1e-10, abs=1e-15)


def test_a_panel_is_a_spring_along_itself_and_half_its_mass_at_each_end() -> None:
    plan = two_bodies((exciter(),))
    spring = PanelSpring(PAIR, ENDS_M, ALONG, 0.9e6, 10.0)
    (motion,) = solve_shakings(plan, [spring])
    heavier = tuple(replace(body, mass_kg=body.mass_kg + 5.0) for body in plan.bodies)
    stiffer = (*plan.bushings, bushing(PAIR, np.zeros(3), (0.9e6, 0.0, 0.0), 0.0))
    wanted = steady_amplitudes_m(replace(plan, bodies=heavier, bushings=stiffer), 78.5)
    assert motion.amplitude_m["driven"] == pytest.approx(wanted[1], rel=1e-10, abs=1e-15)


def test_without_damping_the_masses_have_their_textbook_amplitudes() -> None:
    """a2 / a1 = ks / (ks - M2 w^2) and (M1 - Kg / w^2) a1 + M2 a2 = -u (docs/theory/machine.md)."""
    (motion,) = solve_shakings(two_bodies((exciter(),), loss_factor=0.3), loss_factor=0.0)
    driving, driven = (1j * motion.amplitude_m[name][0] for name in PAIR)  # real: force is -i u w^2 along x
    stiffness = 2.37e6 + 4.0
    assert driven / driving == pytest.approx(stiffness / (stiffness - 287 * 78.5**2), rel=1e-9)
    assert (764 - 0.9e6 / 78.5**2) * driving + 287 * driven == pytest.approx(-3.5, rel=1e-9)


def test_a_loss_factor_takes_the_place_of_the_bushings_damping() -> None:
    """The machine's own damping at 78.5 rad/s is that of a loss factor of 0.1."""
    plan = two_bodies((exciter(),), loss_factor=0.1)
    own, other = solve_shakings(plan)[0], solve_shakings(plan, loss_factor=0.1)[0]
    assert own.amplitude_m["driven"] == pytest.approx(other.amplitude_m["driven"], rel=1e-9)


def test_rotations_solve_the_adapters_linearised_machine() -> None:
    """Six freedoms, an exciter off the centre: K, C, M of ports/linear_frames.py."""
    plan = two_bodies((exciter(position_m=np.array([0.3, 0.05, 0.226])),))
    machine = linear_frames.linearise(plan, linear_frames.SPACE)
    force_N = 3.5 * 78.5**2 * np.array([-1j, 0.0, 1.0])  # start up, turning from z to x
    load = np.zeros(12, dtype=complex)
    load[:6] = linear_frames.displacement(plan.bodies[0], plan.exciters[0].position_m).T @ force_N
    dynamic = machine.stiffness + 78.5j * machine.damping - 78.5**2 * machine.mass
    wanted = np.linalg.solve(dynamic, load)
    (motion,) = solve_shakings(plan, freedoms=6)
    for number, name in enumerate(PAIR):
        start = 6 * number
        assert motion.amplitude_m[name] == pytest.approx(wanted[start : start + 3], rel=1e-9)
        assert motion.angle_rad[name] == pytest.approx(wanted[start + 3 : start + 6], rel=1e-9)
    assert abs(motion.angle_rad["driving"]).max() > 1e-4


def test_a_driven_frame_moves_a_free_one_through_its_bushings() -> None:
    """One mass shaken by its base, without damping: X = k / (k - m w^2) times the base's; the
    drive is  amplitude sin(w t + phase)."""
    plan = two_bodies(loss_factor=0.0)
    still, size_m = np.zeros(3), np.array([2e-3, 0.0, 0.0])
    drive = DrivePlan("driving", still, 60.0, size_m, np.full(3, 0.4), still, still, 0.0)
    (motion,) = solve_shakings(replace(plan, drives=(drive,)))
    base_m = 2e-3 * np.exp(1j * (0.4 - np.pi / 2))
    stiffness = 2.37e6 + 4.0
    wanted = base_m * stiffness / (stiffness - 287 * 60.0**2)
    assert motion.amplitude_m["driving"][0] == pytest.approx(base_m, rel=1e-12)
    assert motion.amplitude_m["driven"][0] == pytest.approx(wanted, rel=1e-9)


def test_nothing_shakes_without_exciters_and_drives() -> None:
    assert solve_shakings(two_bodies()) == ()


def test_an_undamped_machine_at_its_own_frequency_moves_far() -> None:
    """A mass of 1 kg on 100 N/m at 10 rad/s: the equations have no solution without any loss."""
    whole = two_bodies((exciter(10.0),))
    body = replace(whole.bodies[0], mass_kg=1.0)
    spring = replace(bushing(("ground", body.name), np.zeros(3), (100.0,) * 3), damping_N_s_per_m=np.zeros(3))
    (motion,) = solve_shakings(
        replace(
            whole,
            bodies=(body,),
            bushings=(spring,),
            carrier=(),
            points_m=np.zeros((0, 3)),
            reaction_N=np.zeros((0, 3)),
        )
    )
    assert 1e6 < np.abs(motion.amplitude_m[body.name]).max() < np.inf
