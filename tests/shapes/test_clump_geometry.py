"""Volume, centre, inertia and sieve size of clumps, against closed forms and samples."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.case import solvers
from orchestrator.ports import clumps
from orchestrator.ports.clumps import clump, divided, divided_spheres, moments, sieve_size
from tests.reference import dumbbell

Array = npt.NDArray[np.float64]
TURN = Rotation.from_euler("xyz", [0.3, -0.7, 1.1]).as_matrix()


def placed(spheres: list[tuple[float, ...]], turn: Array = TURN) -> Array:
    """The spheres, turned and moved away from the origin."""
    given = np.array(spheres, dtype=float)
    given[:, :3] = given[:, :3] @ turn.T + [0.3, -5.0, 2.0]
    return given


def test_a_clump_of_one_sphere_is_the_sphere() -> None:
    made, sphere = clump("sphere", "", [(3.0, -1.0, 2.0, 0.7)]), solvers.shape("sphere")
    assert (made.spheres, made.volume, made.inertia) == (sphere.spheres, sphere.volume, sphere.inertia)


def test_two_spheres_that_touch_are_the_dumbbell() -> None:
    made = clump("dumbbell", "", placed([(0.0, 0.0, -2.0, 2.0), (0.0, 0.0, 2.0, 2.0)], np.eye(3)))
    toy = dumbbell.ADAPTER
    np.testing.assert_allclose(made.spheres, toy.spheres, atol=1e-11)
    assert made.volume == pytest.approx(toy.volume, rel=1e-8)
    np.testing.assert_allclose(made.inertia, toy.inertia, rtol=1e-8)


@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["upright", "tilted"])
def test_two_unequal_spheres_have_a_lens_in_common(turn: Array) -> None:
    """Two caps cut off by the plane in which they meet; their moments are integrals along the axis."""
    radius, other, apart = 1.0, 0.8, 1.1
    plane = (apart**2 + radius**2 - other**2) / (2 * apart)

    def along(power: int, squared: int) -> float:
        """The integral of z^power (radius of the disc)^(2 squared) over both parts of the axis."""
        z = np.polynomial.Polynomial([0.0, 1.0])
        left = (z**power * (radius**2 - z**2) ** squared).integ()
        right = (z**power * (other**2 - (z - apart) ** 2) ** squared).integ()
        return float(left(plane) - left(-radius) + right(apart + other) - right(plane))

    lens = (
        math.pi
        * (radius + other - apart) ** 2
        * (apart**2 + 2 * apart * (radius + other) - 3 * (radius - other) ** 2)
        / (12 * apart)
    )
    volume = 4 / 3 * math.pi * (radius**3 + other**3) - lens
    assert math.pi * along(0, 1) == pytest.approx(volume, rel=1e-14)  # the two closed forms agree
    centre = math.pi * along(1, 1) / volume
    stretch, width = math.pi * along(2, 1) - volume * centre**2, math.pi / 4 * along(0, 2)

    got, at, second = moments(placed([(0, 0, 0, radius), (0, 0, apart, other)], turn))
    assert got == pytest.approx(volume, rel=1e-8)
    np.testing.assert_allclose(at, turn @ [0, 0, centre] + [0.3, -5.0, 2.0], atol=1e-8)
    np.testing.assert_allclose(turn.T @ second @ turn, np.diag([width, width, stretch]), atol=1e-7)


def test_a_row_of_many_spheres_is_nearly_a_capsule() -> None:
    """A cylinder of radius r and length L between two half spheres; the gaps between n spheres close as
    1/n^2."""
    r, length = 1.0, 2.0
    cylinder, ball = math.pi * r**2 * length, 4 / 3 * math.pi * r**3
    volume = cylinder + ball
    along = cylinder * r**2 / 2 + ball * 2 * r**2 / 5
    # half a ball about its own centre of mass, 3/8 r from the flat side, moved out
    half = 2 * ball / 2 * ((2 / 5 - 9 / 64) * r**2 + (length / 2 + 3 * r / 8) ** 2)
    across = cylinder * (r**2 / 4 + length**2 / 12) + half
    short = []
    for n in (9, 17):
        got, centre, second = moments(np.array([(0, 0, z, r) for z in np.linspace(-1, 1, n)]))
        np.testing.assert_allclose(centre, 0.0, atol=1e-12)
        inertia = np.trace(second) - np.diag(second)
        short.append([1 - got / volume, *(1 - inertia / [across, across, along])])
    np.testing.assert_allclose(np.divide(*short), 4.0, rtol=0.05)
    assert np.abs(short[1]).max() < 3e-3


def test_the_moments_have_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Half the points change nothing above 1e-5: far below the 0.1 % that are wanted."""
    spheres = np.array(solvers.shape("stone").spheres)
    fine = moments(spheres)
    monkeypatch.setattr(clumps, "NODES", clumps.NODES // 2)
    coarse = moments(spheres)
    assert coarse[0] == pytest.approx(fine[0], rel=1e-5)
    np.testing.assert_allclose(coarse[2], fine[2], atol=1e-5 * np.trace(fine[2]))


@pytest.mark.parametrize("name", ["rod", "stone", "flake"])
def test_a_template_has_the_moments_of_random_points(name: str) -> None:
    """A million points in its box: 0.1 % of volume and moments are three standard errors."""
    shape = solvers.shape(name)
    spheres = np.array(shape.spheres)
    low, high = (spheres[:, :3] - spheres[:, 3:]).min(axis=0), (spheres[:, :3] + spheres[:, 3:]).max(axis=0)
    rng = np.random.default_rng(3)
    points = low + (high - low) * (rng.permuted(np.tile(np.arange(10**6)[:, None], 3), axis=0) + 0.5) / 10**6
    inside = np.zeros(len(points), dtype=bool)
    for *place, radius in spheres:
        inside |= ((points - place) ** 2).sum(axis=1) < radius**2
    box = float(np.prod(high - low))
    assert inside.mean() * box == pytest.approx(shape.volume, rel=3e-3)
    held = points[inside]
    np.testing.assert_allclose(held.mean(axis=0), 0.0, atol=3e-3)
    second = held.T @ held / len(held)
    inertia = np.trace(second) * np.eye(3) - second
    np.testing.assert_allclose(inertia, np.diag(shape.inertia) / shape.volume, atol=3e-3 * np.trace(second))


@pytest.mark.parametrize(
    ("spheres", "size"),
    [
        ([(0, 0, 0, 1), (0, 0, 1.5, 0.6)], 2.0),  # the thicker of a row on end
        ([(0, 0, k, 0.5) for k in range(4)], 1.0),
        # three that touch: seen in their plane, a row as long as the triangle is high, in the diagonal
        ([(0, 0, 0, 0.5), (1, 0, 0, 0.5), (0.5, math.sqrt(3) / 2, 0, 0.5)], 1 + math.sqrt(3 / 8)),
        # four in a square: a row as long as its side, in the diagonal
        ([(x, y, 0, 0.5) for x in (0, 1) for y in (0, 1)], 1 + math.sqrt(0.5)),
        # eight at the corners of a cube: no shadow of a cube is narrower than its side
        ([(x, y, z, 0.2) for x in (0, 1) for y in (0, 1) for z in (0, 1)], 1.4),
    ],
    ids=["two", "row", "three", "four", "cube"],
)
def test_the_sieve_size_is_the_closed_one(spheres: list[tuple[float, ...]], size: float) -> None:
    assert sieve_size(placed(spheres)) == pytest.approx(size, rel=1e-7)


@pytest.mark.parametrize("seed", range(4))
def test_no_attitude_of_many_passes_a_smaller_opening(seed: int) -> None:
    """Brute force over 2e5 attitudes comes near the size from above, and never below it."""
    rng = np.random.default_rng(seed)
    spheres = np.column_stack([rng.uniform(-1, 1, (5, 3)), rng.uniform(0.3, 0.6, 5)])
    turns = Rotation.random(200_000, random_state=seed).as_matrix()[:, :2]
    heights = turns @ spheres[:, :3].T
    low, high = (heights - spheres[:, 3]).min(axis=2), (heights + spheres[:, 3]).max(axis=2)
    tried = float((high - low).max(axis=1).min())
    size = sieve_size(spheres)
    assert tried * (1 - 0.02) < size <= tried


@pytest.mark.parametrize("name", ["rod", "stone", "flake"])
def test_a_template_is_of_size_one_and_stands_in_its_own_axes(name: str) -> None:
    shape = solvers.shape(name)
    assert sieve_size(np.array(shape.spheres)) == pytest.approx(1.0, rel=1e-9)
    again = clump(name, shape.about, placed([*shape.spheres]))
    assert again.volume == pytest.approx(shape.volume, rel=1e-7)
    np.testing.assert_allclose(again.inertia, shape.inertia, rtol=1e-7)


@pytest.mark.parametrize(
    ("spheres", "why"),
    [
        ([], "one sphere at least"),
        ([(0, 0, 0)], "four numbers"),
        ([(0, 0, math.nan, 1)], "finite"),
        ([(0, 0, 0, 0)], "positive"),
        ([(0, 0, 0, 1), (0, 0, 1, 1), (0, 0, 4, 1)], r"that at \(0, 0, 4\) of radius 1"),
    ],
)
def test_what_makes_no_grain_is_refused(spheres: list[tuple[float, ...]], why: str) -> None:
    with pytest.raises(ValueError, match=why):
        clump("bad", "", spheres)


def test_a_divided_rod_comes_to_a_capsule() -> None:
    """A cylinder of one diameter between two half spheres; what dents leave out goes with their length
    squared."""
    rod, capsule = solvers.shape("rod"), math.pi / 4 + math.pi / 6
    missing = []
    for parts in (1, 2, 4):
        finer = divided(rod, parts)
        assert len(finer.spheres) == 2 * parts + 1
        assert {row[3] for row in finer.spheres} == {0.5}
        missing.append(capsule - finer.volume)
    np.testing.assert_allclose(np.log2(np.divide(missing[:-1], missing[1:])), 2.0, atol=0.1)


@pytest.mark.parametrize("name", ["rod", "stone", "flake"])
def test_a_divided_shape_has_the_same_outline(name: str) -> None:
    """Its width along any direction, and so its sieve size, is that of the shape's own spheres."""
    own = np.array(solvers.shape(name).spheres)
    finer = np.array(divided_spheres(solvers.shape(name).spheres, 3))
    assert len(finer) > len(own)
    up = np.random.default_rng(1).normal(size=(1000, 3))
    up /= np.linalg.norm(up, axis=1)[:, None]
    reaches = [np.max(up @ each[:, :3].T + each[:, 3], axis=1) for each in (own, finer)]
    np.testing.assert_allclose(reaches[1], reaches[0], rtol=1e-12)
