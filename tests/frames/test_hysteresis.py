"""Friction and Maxwell elements: their law alone, and bushings with them between driven plates."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from adapters.frames import two_mass
from adapters.frames.common.hysteresis import Hysteresis
from orchestrator.case import solvers
from orchestrator.case.file.bushing_curve import Elements, harmonic_stiffness
from orchestrator.ports import Array, Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import Hysteretic
from orchestrator.ports.plans import DrivePlan, FramesPlan, HysteresisPlan
from tests.frames.machines import GRAVITY, body, bushing

FRICTION = ((40e3, 5e-4), (30e3, 3e-3))
MAXWELL = ((20e3, 0.01),)
SPEED_rad_per_s, RUN_UP_s = 78.5, 0.08
CYCLE_s = 2 * np.pi / SPEED_rad_per_s


def law(elastic_N_per_m: float = 150e3, maxwell: tuple[tuple[float, float], ...] = MAXWELL) -> HysteresisPlan:
    friction, branches = (np.array(rows).reshape(-1, 2).T for rows in (FRICTION, maxwell))
    return HysteresisPlan(0, elastic_N_per_m, *friction, *branches)


def plate(amplitude_m: float = 0.0, maxwell: tuple[tuple[float, float], ...] = MAXWELL) -> FramesPlan:
    """A plate on one bushing with elements along x, driven along x."""
    curved = replace(
        bushing(("ground", "plate"), np.zeros(3), (200e3, 1e6, 1e6), 0.0), hysteresis=(law(150e3, maxwell),)
    )
    none, along = np.zeros(3), np.array([amplitude_m, 0.0, 0.0])
    return FramesPlan(
        bodies=(body("plate"),),
        bushings=(curved,),
        exciters=(),
        drives=(DrivePlan("plate", none, SPEED_rad_per_s, along, none, none, none, RUN_UP_s),),
        gravity_m_per_s2=GRAVITY,
        points_m=np.zeros((1, 3)),
        carrier=("plate",),
        reaction_N=np.zeros((1, 3)),
        drawn_at_rest=False,
        step_s=0.0,
        sync_interval_s=CYCLE_s / 200,
    )


def moved(path_m: Array, elements: Hysteresis, step_s: float) -> tuple[Array, float, float]:
    """The forces of elements along x after each step of a path, their work and their loss."""
    force_N, work_J, lost_J = [0.0], 0.0, 0.0
    for step_m in np.diff(path_m):
        step = np.array([[step_m, 0.0, 0.0]])
        work_J += float(elements.mean_N(step, step_s)[0, 0] * step_m)
        gone_J = elements.accept(step, step_s)
        assert gone_J >= -1e-15
        lost_J += gone_J
        force_N.append(float(elements.force_N[0, 0]))
    return np.array(force_N), work_J, lost_J


def test_the_backbone_and_masings_rule() -> None:
    """Each friction element is, from rest, a spring up to its slip: sum k min(x, s). Back from a turning
    point the path is the backbone at twice the scale (Masing)."""
    path_m = np.concatenate([np.linspace(0, 4e-3, 401), np.linspace(4e-3, -4e-3, 801)[1:]])
    force_N, _, _ = moved(path_m, Hysteresis(plate(maxwell=())), 1e-3)

    def backbone_N(x_m: Array) -> Array:
        return np.asarray(sum(k * np.minimum(x_m, s) for k, s in FRICTION))

    assert force_N[:401] == pytest.approx(backbone_N(path_m[:401]), abs=1e-9)
    back_m = 4e-3 - path_m[400:]
    assert force_N[400:] == pytest.approx(force_N[400] - 2 * backbone_N(back_m / 2), abs=1e-9)


def test_energy_closes_on_any_path_and_no_step_creates_any() -> None:
    path_m = np.append(0.0, np.random.default_rng(1).normal(0, 2e-3, 400))
    elements = Hysteresis(plate())
    _, work_J, lost_J = moved(path_m, elements, 2e-3)
    assert lost_J > 0
    assert elements.stored_J() + lost_J == pytest.approx(work_J, rel=1e-12)


@pytest.mark.parametrize("solver", ["planar", pytest.param("exudyn", marks=pytest.mark.solver)])
@pytest.mark.parametrize("amplitude_m", [3e-4, 1e-3, 6e-3])
def test_a_driven_plate_loses_the_area_of_the_loop(solver: str, amplitude_m: float) -> None:
    """Per cycle pi k'' A^2, in the ledger and around the loop of recorded forces, and the amplitude of the
    force in phase is k' A: within 1 %, which 200 intervals a cycle leave.  The plate and its drive give
    the ground what the elements pull."""
    frames = solvers.adapter("frames", solver).build(plate(amplitude_m))
    assert isinstance(frames, Hysteretic)
    cycles, lost_J, rows = 4, [], []
    for index in range(200 * cycles):
        motion = frames.advance(Interval(index, CYCLE_s / 200), Load.zero(1))
        lost_J.append(frames.account().lost_J["bushing_damping"])
        element_N = frames.element_forces_N()
        assert element_N is not None
        rows.append((motion.position_m[0, 0], motion.velocity_m_per_s[0, 0], element_N[0, 0]))
    place_m, velocity_m_per_s, element_N = np.array(rows[-200:]).T
    force_N = 150e3 * place_m + element_N
    storage, loss = harmonic_stiffness(
        Elements(150e3, FRICTION, MAXWELL), np.array([amplitude_m]), np.array([1 / CYCLE_s])
    )
    area_J = np.pi * loss[0] * amplitude_m**2
    assert lost_J[-1] - lost_J[-201] == pytest.approx(area_J, rel=0.01)
    assert np.sum(force_N * velocity_m_per_s) * CYCLE_s / 200 == pytest.approx(area_J, rel=0.01)
    in_phase_N = 2 * np.mean(force_N * place_m) / amplitude_m
    assert in_phase_N == pytest.approx(storage[0] * amplitude_m, rel=0.01)


def test_the_stiffness_falls_with_the_amplitude() -> None:
    """The backbone of dynamic stiffness: all elements hold at 0.1 mm, both sliders slip at 50 mm, where their
    forces are lost in the spring's."""
    amplitude_m = np.array([1e-4, 1e-3, 5e-2])
    storage, loss = harmonic_stiffness(Elements(150e3, FRICTION, ()), amplitude_m, np.full(3, 12.5))
    assert storage[0] == pytest.approx(220e3)
    assert loss[0] == 0
    assert 150e3 < storage[2] < 155e3 < storage[1] < 220e3


def test_two_mass_refuses_elements() -> None:
    with pytest.raises(ValueError, match="exudyn"):
        two_mass.build(replace(plate(), drives=()))
