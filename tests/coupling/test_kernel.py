"""The coupling's compiled functions against NumPy, SciPy and numerical integration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array, random

from orchestrator.coupling import _kernel
from orchestrator.ports import Array, HermitePath, Load, Motion

POINTS, COUNTED, LENGTH_S, LEAST_M = 40, 25, 2e-3, 1e-4
GENERATOR = np.random.default_rng(7)


def field() -> Array:
    """Vectors at all points."""
    return GENERATOR.normal(size=(POINTS, 3))


def forces() -> Array:
    """Forces, which most points do not have."""
    return field() * (GENERATOR.random(POINTS) < 0.3)[:, None]


def test_a_matrix_gives_the_products_of_scipy_to_the_bit() -> None:
    H = csr_array(random(60, POINTS, density=0.1, random_state=3))
    matrix = _kernel.PointMatrix(H.indptr, H.indices, H.data, POINTS)
    values, forces_N = field(), GENERATOR.normal(size=(60, 3)) * (GENERATOR.random(60) < 0.3)[:, None]
    np.testing.assert_array_equal(matrix.times(values), H @ values)
    np.testing.assert_array_equal(matrix.transposed_times(forces_N), csr_array(H.T) @ forces_N)


def test_matrices_that_are_none_and_values_of_another_shape_are_refused() -> None:
    entries = np.ones(2)
    with pytest.raises(ValueError, match="columns: no column has the number 4"):
        _kernel.PointMatrix(np.array([0, 2]), np.array([0, 4]), entries, 4)
    with pytest.raises(ValueError, match="starts, columns, entries"):
        _kernel.PointMatrix(np.array([0, 1]), np.array([0, 3]), entries, 4)
    with pytest.raises(ValueError, match="starts: not ascending"):
        _kernel.PointMatrix(np.array([0, 2, 1, 2]), np.array([0, 3]), entries, 4)
    matrix = _kernel.PointMatrix(np.array([0, 2]), np.array([0, 3]), entries, 4)
    with pytest.raises(ValueError, match=r"values: shape \(4, 3\) wanted"):
        matrix.times(np.ones((3, 4)))
    with pytest.raises(ValueError, match=r"values: shape \(1, 3\) wanted"):
        matrix.transposed_times(np.ones((4, 3)))


def test_what_a_load_hands_over_is_its_integral_along_the_path() -> None:
    start, end, force_N = Motion(field(), field()), Motion(field(), field()), forces()
    sums = np.ones(7)
    _kernel.add_handed_over(sums, Load(force_N), start, end, LENGTH_S)
    impulse_N_s, moment_N_m_s, size_N_s = np.split(sums - 1.0, [3, 6])
    path = HermitePath(start, end, LENGTH_S)
    nodes, weights = np.polynomial.legendre.leggauss(2)  # exact for cubic paths
    places_m = (path.position_m((1 + node) / 2) for node in nodes)
    integral_N_m_s = sum(
        w / 2 * LENGTH_S * np.cross(at_m, force_N).sum(axis=0)
        for w, at_m in zip(weights, places_m, strict=True)
    )
    np.testing.assert_allclose(moment_N_m_s, integral_N_m_s, rtol=1e-12)
    np.testing.assert_allclose(impulse_N_s, LENGTH_S * force_N.sum(axis=0), rtol=1e-12)
    assert size_N_s == pytest.approx(LENGTH_S * np.abs(force_N).sum(), rel=1e-12)
    with pytest.raises(ValueError, match="sums: 7 numbers wanted"):
        _kernel.add_handed_over(np.zeros(6), Load(force_N), start, end, LENGTH_S)


def through_J(force_N: Array, moved_m: Array) -> float:
    """The absolute work along each axis at each point."""
    return float((np.abs(force_N) * (np.abs(moved_m) + LEAST_M)).sum())


def contacts() -> dict[str, Any]:
    """The arguments of ``contact_works``, with other loads on the panel than those of the particles."""
    loads = {"load_N": forces(), "panel_load_N": forces()}
    older = {"load_before_N": forces()[:COUNTED], "load_twice_before_N": forces()[:COUNTED]}
    places = {name: field() for name in ("before_m", "after_m", "path_start_m", "path_end_m")}
    return loads | older | places | {"path_before_m": field()[:COUNTED], "least_m": LEAST_M}


def test_works_of_contacts_are_those_of_the_formula() -> None:
    given = contacts()
    load_N, moved_m = given["load_N"], given["after_m"] - given["before_m"]
    some = slice(COUNTED)
    jump_m = given["path_start_m"][some] - given["path_before_m"]
    jumped_N = (2 * load_N[some] + 5 * given["load_before_N"] - given["load_twice_before_N"]) / 6
    way_m = (given["path_end_m"] - given["path_start_m"])[some]
    created_J = (given["panel_load_N"][some] * moved_m[some]).sum()
    created_J -= (load_N[some] * way_m).sum() + (jumped_N * jump_m).sum()
    expected = (
        (load_N * moved_m).sum(),
        np.abs(load_N).sum(),
        created_J,
        through_J(load_N[some], moved_m[some]),
    )
    assert _kernel.contact_works(**given) == pytest.approx(expected, rel=1e-12)


def clamps() -> dict[str, Any]:
    """The arguments of ``clamp_works``, with another load on the frames than the panels' reaction."""
    places = {name: field() for name in ("reaction_N", "frames_load_N", "before_m", "after_m")}
    return places | {"missed_m": field()[:COUNTED], "missed_before_m": field()[:COUNTED], "least_m": LEAST_M}


def test_works_of_clamps_are_those_of_the_formula() -> None:
    given = clamps()
    reaction_N, moved_m = given["reaction_N"], given["after_m"] - given["before_m"]
    some = slice(COUNTED)
    created_J = ((given["frames_load_N"] - reaction_N)[some] * moved_m[some]).sum()
    created_J += (reaction_N[some] * (given["missed_m"] - given["missed_before_m"])).sum()
    expected = (
        (reaction_N * moved_m).sum(),
        np.abs(reaction_N).sum(),
        created_J,
        through_J(reaction_N[some], moved_m[some]),
    )
    assert _kernel.clamp_works(**given) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(
    ("works", "given"), [(_kernel.contact_works, contacts()), (_kernel.clamp_works, clamps())]
)
def test_an_array_of_another_shape_is_refused_by_its_name(works: Any, given: dict[str, Any]) -> None:
    sizing = ("path_before_m", "missed_m")
    for name in given.keys() - {"least_m", "load_N", "reaction_N", *sizing}:
        with pytest.raises(ValueError, match=rf"^{name}: shape \(\d+, 3\) wanted"):
            works(**given | {name: given[name][:-1]})
    for name in given.keys() & set(sizing):
        with pytest.raises(ValueError, match=f"^{name}: more points than"):
            works(**given | {name: np.ones((POINTS + 1, 3))})
