"""The same law in two codes: the spheres in NumPy against LIGGGHTS with our surface.

They do the same sums in another order, so that they agree to rounding until chaos sets in.
"""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from orchestrator.ports import Account, Array, ParticleSnapshot
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import GrainMaterial, Jkr, ParticlesPlan, Sjkr
from tests.particles.contract import Run, particles, plan, plate, solver_adapter
from tests.particles.folds import pit
from tests.particles.liggghts_plans import make_plan
from tests.particles.liggghts_plans import spheres as spheres_at
from tests.reference import spheres

pytestmark = pytest.mark.solver

Result = tuple[Array, ParticleSnapshot, Account]


def both(given: ParticlesPlan, intervals: int, surface_m_per_s: Array) -> tuple[Result, Result]:
    """Loads, last snapshot and account of the spheres and of LIGGGHTS."""
    results = []
    for module in (spheres, solver_adapter("liggghts")):
        with closing(module.build(given)) as solver:
            run = Run(solver, given, surface_m_per_s)
            run.advance(intervals)
            results.append((np.array(run.load_N), solver.snapshot(), solver.account()))
    return results[0], results[1]


def agree(first: Result, second: Result, relative: float) -> None:
    scale_N = np.abs(second[0]).max()
    assert scale_N > 0.0
    np.testing.assert_allclose(first[0], second[0], rtol=0.0, atol=relative * scale_N)
    for name in ("position_m", "velocity_m_per_s", "spin_rad_per_s"):
        mine, theirs = getattr(first[1], name), getattr(second[1], name)
        np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=relative * np.abs(theirs).max())
    mine_J, theirs_J = first[2].received_J["surface"], second[2].received_J["surface"]
    assert mine_J == pytest.approx(theirs_J, rel=relative, abs=1e-15)


def test_eighteen_bouncing_spheres() -> None:
    """The spheres have three sizes and two materials, on a third that moves; 25 ms, before chaos sets in."""
    place_m = 0.011 * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [1, 2], indexing="ij"), -1)
    place_m = place_m.reshape(-1, 3) - np.array([0.0, 0.0, 0.0055])
    generator = np.random.default_rng(1)
    given = particles(
        place_m,
        generator.normal(0.0, 0.3, (18, 3)),
        generator.normal(0.0, 20.0, (18, 3)),
        diameter_m=np.tile([0.008, 0.009, 0.01], 6),
    )
    given.grains.material[:] = np.tile([0, 1], 9)
    surface = plate(0.05, 7)
    surface.material[:] = 2
    e = np.array([[0.5, 0.6, 0.3], [0.6, 0.8, 0.4], [0.3, 0.4, 0.9]])
    materials = (GrainMaterial("a", 1e7, 0.3), GrainMaterial("b", 3e7, 0.2), GrainMaterial("c", 6e6, 0.45))
    case = plan(
        surface,
        given,
        materials=materials,
        restitution=e,
        sliding_friction=0.7 * e,
        rolling_friction=np.zeros((3, 3)),
    )
    agree(*both(case, 25, np.array([0.3, 0.0, 0.2])), relative=1e-9)


@pytest.mark.parametrize("angle_deg", [5.0, 10.0, 20.0, 30.0, 40.0, 90.0, -10.0, -60.0])
def test_a_sphere_that_slides_over_a_fold(angle_deg: float) -> None:
    """Valleys (> 0) and ridges of two triangles each side."""
    tilt = np.radians(angle_deg) / 2.0
    x, z = 0.03 * np.cos(tilt), 0.03 * np.sin(tilt)
    corner_m = np.array([[s * x, y, abs(s) * z] for s in (-1.0, 0.0, 1.0) for y in (-0.02, 0.02)])
    triangles = np.array([[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]])
    surface = TriangleSurface(corner_m, triangles, np.zeros(4, dtype=np.int64))
    along, up = (np.array([np.cos(tilt), 0.0, -np.sin(tilt)]), np.array([np.sin(tilt), 0, np.cos(tilt)]))
    start_m = -0.008 * along + 0.00495 * up + np.array([0.0, 0.001, 0.0])
    case = plan(surface, particles(start_m, 0.4 * along, [0.0, 5.0, 1.0]))
    agree(*both(case, 40, np.zeros(3)), relative=1e-9)


@pytest.mark.parametrize("surface", [pit(0.4, 5)], ids=["pit"])
def test_a_spinning_sphere_where_several_contacts_share(surface: TriangleSurface) -> None:
    """Friction makes the tangential springs of contacts that come and go take part."""
    start_m, velocity_m_per_s = [2e-4, 1e-4, 3.6e-3], [0.05, 0.03, -0.1]
    case = make_plan(
        surface,
        spheres_at(start_m, velocity_m_per_s, spin_rad_per_s=[10.0, 30.0, 5.0]),
        restitution=0.5,
        sliding_friction=0.4,
        gravity_m_per_s2=np.array([0.0, 0.0, -9.81]),
    )
    first, second = both(case, 400, np.zeros(3))
    # an edge is in two triangles, at the same distance but for rounding; either may take the couple
    agree(*(summed(result, surface) for result in (first, second)), relative=1e-9)


def summed(result: Result, surface: TriangleSurface) -> Result:
    """Return the result with force and moment about the origin in the place of the forces on all points."""
    force_N = result[0]
    moment_N_m = np.cross(surface.position_m, force_N).sum(axis=1)
    return np.stack([force_N.sum(axis=1), moment_N_m / 0.01], axis=1), result[1], result[2]


ADHESION = {"dry": None, "sjkr": Sjkr(np.full((1, 1), 3e5)), "jkr": Jkr(np.full((1, 1), 0.05), 1e-3)}


@pytest.mark.parametrize("rolling", ["epsd2", "cdt"])
@pytest.mark.parametrize("adhesion", ADHESION)
def test_eighteen_wet_spheres(adhesion: str, rolling: str) -> None:
    """The spheres of 1 mm radius are thrown together and against a sheet: 8 ms, in which pairs stick and
    part. The turns of cdt at rest are chaotic."""
    place_m = 2.02e-3 * np.stack(np.meshgrid([-1, 0, 1], [-1, 0, 1], [0, 1], indexing="ij"), -1)
    generator = np.random.default_rng(0)
    given = particles(
        place_m.reshape(-1, 3) + np.array([1e-4, 2e-4, 1.02e-3]),
        generator.normal(0.0, 0.02, (18, 3)),
        generator.normal(0.0, 5.0, (18, 3)),
        diameter_m=np.tile([1.8e-3, 2e-3], 9),
        density_kg_per_m3=2500.0,
    )
    sheet = plate(0.006, 7)
    case = plan(
        sheet,
        given,
        materials=(GrainMaterial("wet", 1e7, 0.3),),
        restitution=np.full((1, 1), 0.6),
        sliding_friction=np.full((1, 1), 0.4),
        rolling_friction=np.full((1, 1), 0.1),
        rolling=rolling,
        adhesion=ADHESION[adhesion],
        largest_radius_m=1e-3,
        domain_m=np.array([[-0.05] * 3, [0.05] * 3]),
        step_s=5e-6,
        sync_interval_s=1e-4,
    )
    ours, theirs = both(case, 80, np.array([0.01, 0.0, 0.02]))
    # as above: an edge's couple may go to either of its triangles
    loads = (summed(result, sheet) for result in (ours, theirs))
    agree(*loads, relative=1e-9 if rolling == "epsd2" else 1e-5)
    for name, stored_J in ours[2].stored_J.items():
        assert stored_J == pytest.approx(theirs[2].stored_J[name], rel=1e-5, abs=1e-15)


@pytest.mark.parametrize("angle_deg", [10.0, 40.0, -10.0, -50.0, -70.0])
def test_a_sticky_sphere_that_slides_over_a_fold(angle_deg: float) -> None:
    """The sphere hangs on its neck below the surface: ridges (> 0) and valleys, at which it may part.  At 60
    degrees rounding decides whether a contact goes on (SAME_CONTACT)."""
    tilt = np.radians(angle_deg) / 2.0
    x, z = 0.003 * np.cos(tilt), 0.003 * np.sin(tilt)
    corner_m = np.array([[s * x, y, abs(s) * z] for s in (-1, 0, 1) for y in (-0.002, 0.002)])
    triangles = np.array([[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]])
    surface = TriangleSurface(corner_m, triangles, np.zeros(4, dtype=np.int64))
    along = np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    up = np.array([np.sin(tilt), 0.0, np.cos(tilt)])
    start_m = -0.002 * along - (1e-3 - 2e-7) * up + np.array([0.0, 1e-4, 0.0])
    given = particles(start_m, 0.4 * along, [0, 0, 0], diameter_m=2e-3, density_kg_per_m3=2500.0)
    case = plan(
        surface,
        given,
        adhesion=Jkr(np.full((1, 1), 0.05), 1e-3),
        largest_radius_m=1e-3,
        domain_m=np.array([[-0.05] * 3, [0.05] * 3]),
        step_s=5e-6,
        sync_interval_s=1e-4,
    )
    ours, theirs = both(case, 80, np.zeros(3))
    agree(ours, theirs, relative=1e-9)
    hangs = ours[0].sum(axis=(1, 2)) != 0.0
    assert hangs[:30].all()
