"""The sheet's membrane and bending energies, one at a time."""

from __future__ import annotations

import numpy as np
import pytest

from tests.panel.elastic_plans import C01_PA, C10_PA, plan

pytestmark = pytest.mark.solver


@pytest.fixture(scope="module")
def strip():
    from adapters.panel.finite_element.sheet_forms import sheet

    given = plan(cells=(4, 2))
    structure, _, _ = sheet(given)
    return given, structure


def stretched(structure, along: float, across: float):
    return structure.material_m * np.array([along, across, 1.0])


@pytest.mark.parametrize(
    ("stretch", "stress_MPa"), [(1.025, 0.50230), (1.05, 0.96267), (1.10, 1.77561), (1.5, 5.41852)]
)
def test_uniaxial_stress(strip, stretch, stress_MPa):
    """Incompressible Mooney-Rivlin, nominal stress P = 2 (l - 1/l^2)(C10 + C01/l) (R. S. Rivlin,
    Phil. Trans. R. Soc. A 241 (1948) 379-397).  Rounding against the formula, and the table's
    five digits."""
    given, structure = strip
    force = structure.force_N(stretched(structure, stretch, stretch**-0.5))
    end = structure.material_m[:, 0] > 0.5 * given.rectangle.length_m
    stress = force[end, 0].sum() / (given.rectangle.width_m * given.thickness_m)
    exact = 2 * (stretch - stretch**-2) * (C10_PA + C01_PA / stretch)
    assert stress == pytest.approx(exact, rel=1e-10)
    assert stress * 1e-6 == pytest.approx(stress_MPa, abs=6e-6)
    side = structure.material_m[:, 1] > 0.9 * given.rectangle.width_m
    assert abs(force[side, 1].sum()) < 1e-9 * abs(force[end, 0].sum())


def test_rigid_motion_needs_no_force(strip):
    """Energy and force vanish for any rotation and shift: rounding against a force of 1 N that
    1e-6 of stretch would need."""
    _, structure = strip
    turn = rotation(0.9, np.array([0.6, -0.48, 0.64]))
    force = structure.force_N(structure.material_m @ turn.T + np.array([3.0, 1.0, -2.0]))
    assert np.abs(force).max() < 1e-8
    assert abs(structure.stored_J()["membrane"]) < 1e-12


def test_force_turns_with_the_panel(strip):
    """f(R x) = R f(x) for a bent and stretched shape, to rounding."""
    _, structure = strip
    turn = rotation(-1.3, np.array([0.0, 0.8, 0.6]))
    s = structure.material_m[:, 0]
    bent = stretched(structure, 1.02, 0.99)
    bent[:, 2] = 0.02 * np.sin(9.0 * s)
    force, turned = structure.force_N(bent), structure.force_N(bent @ turn.T)
    np.testing.assert_allclose(turned, force @ turn.T, atol=1e-9 * np.abs(force).max())


@pytest.mark.parametrize(("width_m", "cells"), [(0.8, (22, 8)), (0.02, (3, 8)), (0.33, (8, 8))])
def test_bending_is_zero_only_for_affine_positions(width_m, cells):
    """Three zero eigenvalues (1, s, y), none below: the interior penalty is large enough for
    cells of any shape."""
    from adapters.panel.finite_element.sheet_forms import sheet

    structure, _, _ = sheet(plan(width_m=width_m, cells=cells))
    matrix = structure.bending.matrix.toarray()
    np.testing.assert_allclose(matrix, matrix.T, atol=1e-9 * np.abs(matrix).max())
    eigenvalues = np.linalg.eigvalsh(matrix)
    assert np.abs(eigenvalues[:3]).max() < 1e-13 * eigenvalues[-1]
    assert eigenvalues[3] > 1e-10 * eigenvalues[-1]
    affine = structure.material_m @ np.diag([1.0, 1.0, 0.0])
    assert np.abs(matrix @ affine).max() < 1e-12 * np.abs(matrix).max()


def test_bending_energy_of_a_cylinder(strip):
    """A sheet rolled to the curvature k without strain stores  D k^2 / 2  per area, D = E t^3 / 9
    (plate, nu = 1/2).  Interpolating the circle with three cells per radian costs 1 %."""
    given, structure = strip
    curvature = 4.0
    s, y = structure.material_m[:, 0], structure.material_m[:, 1]
    rolled = np.column_stack((np.sin(curvature * s), curvature * y, 1 - np.cos(curvature * s)))
    structure.rest(rolled / curvature)
    area = (given.rectangle.length_m + 2 * given.rectangle.clamp_m) * given.rectangle.width_m
    plate_N_m = given.material.youngs_modulus_Pa * given.thickness_m**3 / 9
    exact = 0.5 * plate_N_m * curvature**2 * area
    assert structure.stored_J()["bending"] == pytest.approx(exact, rel=0.01)


def test_mass_is_that_of_the_sheet(strip):
    given, structure = strip
    area = (given.rectangle.length_m + 2 * given.rectangle.clamp_m) * given.rectangle.width_m
    exact = given.material.density_kg_per_m3 * given.thickness_m * area
    assert structure.mass_kg.sum() == pytest.approx(exact, rel=1e-12)
    assert structure.mass_kg.min() > 0.0


def rotation(angle_rad: float, axis: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(angle_rad * axis).as_matrix()
