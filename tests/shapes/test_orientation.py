"""How grains are turned: by seed without a preferred direction, where they are drawn, and in files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.case.bed.packing import random_orientations
from orchestrator.case.bed.sources import block_particles, initial_particles
from orchestrator.output.records.snapshots import particle_mesh, sphere_mesh
from orchestrator.ports import ParticleSnapshot
from orchestrator.ports.grains import placed_spheres, turned, turned_back
from tests.cases import BLOCK, loaded

STONES = [BLOCK, 'bed.blocks.coal.shape="stone"', "bed.blocks.coal.count=12"]


def test_quaternions_turn_vectors_as_scipy_does() -> None:
    generator = np.random.default_rng(3)
    turns, vectors = random_orientations(50, generator), generator.normal(size=(50, 3))
    wanted = Rotation.from_quat(turns[:, [1, 2, 3, 0]]).apply(vectors)
    np.testing.assert_allclose(turned(turns, vectors), wanted, atol=1e-14)
    np.testing.assert_allclose(turned_back(turns, wanted), vectors, atol=1e-14)


def test_random_orientations_prefer_no_direction() -> None:
    """Of 20 000 unit vectors the mean is 0 within 3 sigma, and the mean of their squares 1/3; the angle of a
    random rotation has the mean pi/2 + 2/pi (Miles, R. E., Biometrika 52, 1965, 636)."""
    n = 20_000
    turns = random_orientations(n, np.random.default_rng(5))
    for axis in np.eye(3):
        where = turned(turns, np.tile(axis, (n, 1)))
        np.testing.assert_allclose(where.mean(axis=0), 0.0, atol=3 / np.sqrt(3 * n))
        np.testing.assert_allclose((where**2).mean(axis=0), 1 / 3, atol=3 * np.sqrt(4 / 45 / n))
    angle = 2 * np.arccos(np.abs(turns[:, 0]))
    assert angle.mean() == pytest.approx(np.pi / 2 + 2 / np.pi, abs=3 * 0.65 / np.sqrt(n))


def test_a_block_lies_by_its_seed(tmp_path: Path) -> None:
    first, again = (block_particles(loaded(tmp_path, STONES).case, "coal").orientation for _ in range(2))
    other = block_particles(loaded(tmp_path, [*STONES, "bed.blocks.coal.seed=2"]).case, "coal").orientation
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.1
    np.testing.assert_allclose(np.linalg.norm(first, axis=1), 1.0, rtol=1e-14)
    spheres = block_particles(loaded(tmp_path, [BLOCK]).case, "coal").orientation
    np.testing.assert_array_equal(spheres, [[1.0, 0.0, 0.0, 0.0]])


def test_a_particle_is_turned_in_its_axes(tmp_path: Path) -> None:
    """A rod turned by a right angle about y lies along x: of the world, or down a deck of 30 degrees."""
    ball = 'bed.particles.ball={position_m=[0.1, 0.1, 0.1], sieve_size_m=0.01, material="coal", shape="rod", '
    for axes, along in (("world", [1.0, 0.0, 0.0]), ("deck", [np.sqrt(0.75), 0.0, -0.5])):
        given = f'{ball}axes="{axes}", rotation_rad=[0, {np.pi / 2}, 0]}}'
        case = loaded(tmp_path, [given, "screen.inclination_deg=30"]).case
        turns = initial_particles(case).orientation
        np.testing.assert_allclose(turned(turns, np.array([[0.0, 0.0, 1.0]])), [along], atol=1e-12)


def test_paraview_gets_each_sphere_with_the_grain_s_id(tmp_path: Path) -> None:
    block = block_particles(loaded(tmp_path, STONES).case, "coal")
    motion = (block.position_m, block.velocity_m_per_s, block.spin_rad_per_s)
    bed = ParticleSnapshot(np.arange(7, 19), *motion, block.grains, orientation=block.orientation)
    of, center_m, radius_m = placed_spheres(block.grains, block.position_m, block.orientation)
    mesh, bodies = sphere_mesh(bed), particle_mesh(bed)
    assert len(mesh.points) == 4 * 12
    np.testing.assert_array_equal(mesh.point_data["id"], np.repeat(np.arange(7, 19), 4))
    np.testing.assert_array_equal(mesh.points, center_m)
    np.testing.assert_array_equal(mesh.point_data["diameter_m"], 2 * radius_m)
    farthest = np.linalg.norm(center_m - block.position_m[of], axis=1) + radius_m
    bounding = np.zeros(12)
    np.maximum.at(bounding, of, farthest)
    np.testing.assert_allclose(bounding, block.grains.bounding_radius_m, rtol=1e-12)
    np.testing.assert_array_equal(bodies.point_data["orientation"], block.orientation)
