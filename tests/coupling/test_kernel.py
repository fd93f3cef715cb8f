"""The coupling's compiled functions against NumPy, SciPy and numerical integration."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array, random

from orchestrator.coupling import _kernel
from orchestrator.ports import Array, HermitePath, InterfaceData, Load, Motion, PanelState

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
    with pytest.raises(ValueError, match=r"^columns:"):
        _kernel.PointMatrix(np.array([0, 2]), np.array([0, 4]), entries, 4)
    with pytest.raises(ValueError, match=r"^starts,"):
        _kernel.PointMatrix(np.array([0, 1]), np.array([0, 3]), entries, 4)
    with pytest.raises(ValueError, match=r"^starts:"):
        _kernel.PointMatrix(np.array([0, 2, 1, 2]), np.array([0, 3]), entries, 4)
    matrix = _kernel.PointMatrix(np.array([0, 2]), np.array([0, 3]), entries, 4)
    with pytest.raises(ValueError, match=r"^values:"):
        matrix.times(np.ones((3, 4)))
    with pytest.raises(ValueError, match=r"^values:"):
        matrix.transposed_times(np.ones((4, 3)))


def offsets() -> tuple[Array, Array, Array, _kernel.NormalOffsets]:
    """Slopes along and across (30, points) and offsets in m of 30 points, of which every third has none, and
    the compiled object."""
    along, across = (csr_array(random(30, POINTS, density=0.2, random_state=seed)) for seed in (5, 6))
    offset_m = GENERATOR.normal(size=30) * (np.arange(30) % 3 > 0)
    compiled = [_kernel.PointMatrix(m.indptr, m.indices, m.data, POINTS) for m in (along, across)]
    return along.toarray(), across.toarray(), offset_m, _kernel.NormalOffsets(*compiled, offset_m)


def test_an_offset_goes_along_the_normal_and_turns_with_it() -> None:
    """The offset agrees with NumPy, and its rate with a difference quotient of the places (1e-6)."""
    along, across, offset_m, compiled = offsets()
    own_m, own_m_per_s = field(), field()

    def offsets_m(at_m: Array) -> Array:
        area = np.cross(along @ at_m, across @ at_m)
        return offset_m[:, None] * area / np.linalg.norm(area, axis=1)[:, None]

    position_m, velocity_m_per_s = np.ones((2, 30, 3))
    compiled.add_motion(own_m, own_m_per_s, position_m, velocity_m_per_s)
    np.testing.assert_allclose(position_m - 1.0, offsets_m(own_m), atol=1e-13)
    step_s = 1e-6
    ends_m = (offsets_m(own_m + sign * step_s * own_m_per_s) for sign in (1.0, -1.0))
    quotient_m_per_s = np.subtract(*ends_m) / (2 * step_s)
    largest = np.abs(quotient_m_per_s).max()
    np.testing.assert_allclose(velocity_m_per_s - 1.0, quotient_m_per_s, atol=1e-6 * largest)


def test_the_couples_of_loads_beside_a_surface_do_their_work() -> None:
    """The couples do their work on any motion of the own points; forces at points without an offset have no
    couple."""
    _, _, offset_m, compiled = offsets()
    own_m, own_m_per_s, force_N = field(), field(), GENERATOR.normal(size=(30, 3))
    _, rate_m_per_s = both = np.zeros((2, 30, 3))
    compiled.add_motion(own_m, own_m_per_s, *both)
    couples_N = np.zeros((POINTS, 3))
    compiled.add_load(own_m, force_N, couples_N)
    size_W = np.abs(couples_N * own_m_per_s).sum()
    assert np.vdot(couples_N, own_m_per_s) == pytest.approx(
        np.vdot(force_N, rate_m_per_s), abs=1e-13 * size_W
    )
    without_N = np.zeros((POINTS, 3))
    compiled.add_load(own_m, force_N * (offset_m == 0.0)[:, None], without_N)
    assert not without_N.any()


def test_offsets_of_another_number_of_points_are_refused() -> None:
    single = _kernel.PointMatrix(np.array([0, 2]), np.array([0, 3]), np.ones(2), 4)
    double = _kernel.PointMatrix(np.array([0, 1, 2]), np.array([0, 3]), np.ones(2), 4)
    for matrices, points in (((single, double), 1), ((single, single), 2)):
        with pytest.raises(ValueError, match=r"^along,"):
            _kernel.NormalOffsets(*matrices, np.ones(points))
    good = _kernel.NormalOffsets(single, single, np.ones(1))
    with pytest.raises(ValueError, match=r"^position_m:"):
        good.add_motion(np.ones((4, 3)), np.ones((4, 3)), np.ones((2, 3)), np.ones((1, 3)))
    with pytest.raises(ValueError, match=r"^own_force_N:"):
        good.add_load(np.ones((4, 3)), np.ones((1, 3)), np.ones((1, 3)))


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


def at_points(points: int) -> tuple[Motion, Load]:
    """A motion of that many points, and loads that most of them do not have."""
    position_m, velocity_m_per_s = GENERATOR.normal(size=(2, points, 3))
    force_N = GENERATOR.normal(size=(points, 3)) * (GENERATOR.random(points) < 0.3)[:, None]
    return Motion(position_m, velocity_m_per_s), Load(force_N)


def interval_data() -> InterfaceData:
    """An interval in which no two loads and no two places are equal."""
    (start, load), (end, panel_load), (surface, _) = (at_points(POINTS) for _ in range(3))
    (target, reaction), (clamps, frames_load) = (at_points(POINTS) for _ in range(2))
    state = PanelState(surface, reaction)
    particles = HermitePath(start, end, LENGTH_S), load
    return InterfaceData(LENGTH_S, (frames_load, clamps), (target, panel_load, state), particles)


INTERVALS = [interval_data() for _ in range(3)]
SLOW = {"counted": COUNTED, "slow_m_per_s": LEAST_M / LENGTH_S}
CONTACTS = {name: field() for name in ("before_m", "path_before_m", "load_before_N", "load_twice_before_N")}
CLAMPS = {name: field() for name in ("before_m", "target_before_m")}


def test_works_of_contacts_are_those_of_the_formula() -> None:
    """Each interval begins where the one before it has ended."""
    some, expected = slice(COUNTED), []
    before_m, left_m = CONTACTS["before_m"], CONTACTS["path_before_m"]
    first_N, second_N = CONTACTS["load_before_N"], CONTACTS["load_twice_before_N"]
    for data in INTERVALS:
        assert data.particles is not None
        path, load_N = data.particles[0], data.particles[1].force_N
        start_m, end_m = path.start.position_m, path.end.position_m
        moved_m = data.panel[2].surface.position_m - before_m
        jumped_N = (2 * load_N + 5 * first_N - second_N) / 6
        created_J = (
            data.panel[1].force_N * moved_m - load_N * (end_m - start_m) - jumped_N * (start_m - left_m)
        )
        expected.append(
            (
                (load_N * moved_m).sum(),
                np.abs(load_N).sum(),
                created_J[some].sum(),
                through_J(load_N[some], moved_m[some]),
            )
        )
        before_m, left_m, first_N, second_N = data.panel[2].surface.position_m, end_m, load_N, first_N
    np.testing.assert_allclose(_kernel.contact_works(INTERVALS, **CONTACTS, **SLOW), expected, rtol=1e-11)


def test_works_of_clamps_are_those_of_the_formula() -> None:
    some, expected = slice(COUNTED), []
    before_m, target_before_m = CLAMPS["before_m"], CLAMPS["target_before_m"]
    for data in INTERVALS:
        (frames_load, clamps), (target, _, state) = data.frames, data.panel
        reaction_N, moved_m = state.reaction.force_N, clamps.position_m - before_m
        missed_m, missed_before_m = clamps.position_m - target.position_m, before_m - target_before_m
        created_J = (frames_load.force_N - reaction_N) * moved_m + reaction_N * (missed_m - missed_before_m)
        expected.append(
            (
                (reaction_N * moved_m).sum(),
                np.abs(reaction_N).sum(),
                created_J[some].sum(),
                through_J(reaction_N[some], moved_m[some]),
            )
        )
        before_m, target_before_m = clamps.position_m, target.position_m
    np.testing.assert_allclose(_kernel.clamp_works(INTERVALS, **CLAMPS, **SLOW), expected, rtol=1e-11)


def test_sizes_and_second_differences_of_values() -> None:
    values = [field() for _ in range(5)]
    expected = [
        (np.square(v).sum(), np.abs(d).max())
        for v, d in zip(values[2:], np.diff(values, 2, axis=0), strict=True)
    ]
    np.testing.assert_allclose(_kernel.sizes_and_changes(values), expected, rtol=1e-12)
    with pytest.raises(ValueError, match=r"^values:"):
        _kernel.sizes_and_changes([*values[:2], values[2][:-1], values[3]])


@pytest.mark.parametrize(
    ("works", "given"), [(_kernel.contact_works, CONTACTS), (_kernel.clamp_works, CLAMPS)]
)
def test_an_array_of_another_shape_is_refused_by_its_name(works: Any, given: dict[str, Any]) -> None:
    for name in given.keys() - {"before_m"}:
        with pytest.raises(ValueError, match=f"^{name}:"):
            works(INTERVALS, **given | {name: given[name][:-1]}, **SLOW)
    with pytest.raises(ValueError, match=r"^force_N:"):
        works(INTERVALS, **{name: each[:-1] for name, each in given.items()}, **SLOW)
    with pytest.raises(ValueError, match=r"^counted:"):
        works(INTERVALS, **given, **SLOW | {"counted": len(given["before_m"]) + 1})
