"""Rayleigh time and duration of a Hertz contact against answers found in other ways."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from orchestrator.case.bed.contact_times import (
    contact_moduli,
    hertz_s,
    rayleigh_s,
    reduced_modulus_Pa,
    shortest_rayleigh_s,
)
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.case import Hyperelastic, Material
from tests.cases import loaded


@pytest.mark.parametrize("nu", [0.0, 0.2, 0.3, 0.4, 0.49])
def test_the_rayleigh_time_is_half_a_circumference_at_the_rayleigh_wave_speed(nu: float) -> None:
    """The wave speed from Rayleigh's equation, with x = (c / c_shear)^2 and
    k = (1 - 2 nu) / (2 - 2 nu):  x^3 - 8 x^2 + (24 - 16 k) x - 16 (1 - k) = 0
    (Timoshenko and Goodier, Theory of Elasticity, 3rd ed. 1970).  The fit of the formula
    is good to 0.5 %."""
    k = (1 - 2 * nu) / (2 - 2 * nu)
    x = brentq(lambda x: x**3 - 8 * x**2 + (24 - 16 * k) * x - 16 * (1 - k), 0.1, 0.9999)
    radius, density, youngs = 1.5e-3, 1430.0, 9.9e8
    speed = math.sqrt(x * youngs / (2 * (1 + nu)) / density)
    expected = math.pi * radius / speed
    assert rayleigh_s(radius, density, youngs, nu) == pytest.approx(expected, rel=5e-3)


def test_the_duration_of_an_impact_is_that_of_the_integrated_motion() -> None:
    """m u'' = -4/3 E* sqrt(R) u^1.5 from u = 0 until it comes back; the prefactor 2.87 of the
    formula has three digits."""
    mass, radius, modulus, speed = 1e-3, 5e-3, 1e7, 2.0
    stiffness = 4 / 3 * modulus * math.sqrt(radius)

    def parted(_: float, state: list[float]) -> float:
        return state[0]

    parted.terminal, parted.direction = True, -1
    motion = solve_ivp(
        lambda _, state: [state[1], -stiffness * max(state[0], 0.0) ** 1.5 / mass],
        (0.0, 1.0),
        [0.0, speed],
        events=parted,
        rtol=1e-9,
        atol=1e-12,
    )
    assert hertz_s(mass, radius, modulus, speed) == pytest.approx(motion.t_events[0][-1], rel=3e-3)


def test_a_hyperelastic_material_touches_with_its_small_strain_moduli() -> None:
    """K = 2 GPa and mu = 7 MPa: nearly incompressible, E = 3 mu (1 - mu / (3 K) ...)."""
    law = Hyperelastic(c10_Pa=0.7e6, c01_Pa=2.8e6, bulk_modulus_Pa=2e9)
    youngs, poisson = contact_moduli(Material(density_kg_per_m3=1150.0, hyperelastic=law), None)
    assert youngs == pytest.approx(21e6, rel=2e-3)
    assert poisson == pytest.approx(0.49825, abs=1e-5)
    assert youngs / (3 * (1 - 2 * poisson)) == pytest.approx(2e9)
    assert youngs / (2 * (1 + poisson)) == pytest.approx(7e6)


def test_softening_caps_the_modulus_and_lengthens_the_step(tmp_path: Path) -> None:
    hard = loaded(tmp_path, ["materials.coal.youngs_modulus_Pa=1e9"]).case
    cap = "particles.largest_youngs_modulus_Pa=1e7"
    soft = loaded(tmp_path, ["materials.coal.youngs_modulus_Pa=1e9", cap]).case
    assert shortest_rayleigh_s(soft) == pytest.approx(10 * shortest_rayleigh_s(hard))
    assert particle_step_s(hard) == pytest.approx(0.2 * shortest_rayleigh_s(hard))


def test_the_reduced_modulus_of_two_alike_is_half_the_plane_strain_modulus() -> None:
    assert reduced_modulus_Pa((1e7, 0.3), (1e7, 0.3)) == pytest.approx(0.5e7 / (1 - 0.09))
