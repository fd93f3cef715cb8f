"""Particles that go through the surface: every particle solver counts them, in every step."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from orchestrator.ports import Array, HermitePath, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import GrainMaterial, ParticlesPlan
from tests.particles.contract import LIGGGHTS_ALONE, WEIGHTLESS, Run, at_rest, particles, plan, plate, table

ASKED = LIGGGHTS_ALONE

Build = Callable[[ParticlesPlan], Run]
VERY_SOFT = GrainMaterial("very soft", 1e3, 0.3)


def soft(surface: TriangleSurface, *given: Any, **changes: Any) -> ParticlesPlan:
    """Particles of 10 mm that hardly feel what they meet, without gravity."""
    usual: dict[str, Any] = {"materials": (VERY_SOFT,), "gravity_m_per_s2": WEIGHTLESS}
    return plan(surface, particles(*given), **usual | changes)


def roof(height_m: float) -> TriangleSurface:
    """The plate of 4 x 4 cells, folded upwards along y."""
    flat = plate(0.02, 4)
    lifted_m = flat.position_m.copy()
    lifted_m[:, 2] = height_m * (1.0 - np.abs(lifted_m[:, 0]) / 0.02)
    return replace(flat, position_m=lifted_m)


def with_hole(cells: int) -> TriangleSurface:
    """The plate of 40 mm without its middle cell, for an odd number of cells."""
    flat = plate(0.02, cells)
    middle_m = flat.position_m[flat.triangles].mean(axis=1)
    kept = np.abs(middle_m[:, :2]).max(axis=1) > 0.02 / cells
    return TriangleSurface(flat.position_m, flat.triangles[kept], flat.material[kept])


@pytest.mark.parametrize("place_m", [(0.0, 0.0), (0.0, 0.003), (0.0031, 0.0012)])
@pytest.mark.parametrize("height_m", [0.0, 0.004], ids=["plate", "roof"])
@pytest.mark.parametrize("side", [1.0, -1.0], ids=["down", "up"])
def test_who_goes_through_is_counted_once(
    build: Build, place_m: tuple[float, float], height_m: float, side: float
) -> None:
    """The spheres go through a point, an edge and a triangle of the surface, flat or folded, from either
    side."""
    x_m, y_m = place_m
    surface_z_m = height_m * (1.0 - abs(x_m) / 0.02)
    start_m = [x_m, y_m, surface_z_m + side * 0.008]
    run = build(soft(roof(height_m), start_m, [0.0, 0.0, -side * 3.0]))
    run.advance(2)
    assert run.solver.crossings().number == 0
    run.advance(8)
    assert np.sign(run.solver.snapshot().position_m[0, 2]) == -side
    crossings = run.solver.crossings()
    assert (crossings.number, crossings.first_id) == (1, 1)
    # it is hardly slowed down, and found within a step of 0.06 mm
    assert crossings.first_time_s == pytest.approx(0.008 / 3.0, rel=0.05)
    np.testing.assert_allclose(crossings.first_position_m, [x_m, y_m, surface_z_m], atol=1.5e-4)


def test_who_is_held_does_not_go_through(build: Build) -> None:
    """Nine spheres of 10 mm that bounce, roll over all edges and lie there are no crossings."""
    place_m = np.array([[x, y, 0.006] for x in (-0.011, 0, 0.011) for y in (-0.011, 0, 0.011)])
    given = particles(place_m, np.random.default_rng(3).normal(0.0, 0.2, (9, 3)))
    run = build(plan(roof(0.004), given))
    run.advance(100)
    assert run.solver.crossings().number == 0
    assert run.solver.overlaps().surface_m > 1e-5


def test_an_opening_lets_through(build: Build) -> None:
    """A sphere of 5 mm falls through an opening of 8 mm, another along its rim, touching it."""
    given = particles([[0.0, 0.0, 0.01], [0.0, 0.002, 0.03]], [0.0, 0.0, -1.0], diameter_m=0.005)
    run = build(plan(with_hole(5), given))
    run.advance(60)
    assert (run.solver.snapshot().position_m[:, 2] < -0.005).all()
    assert run.solver.overlaps().surface_m > 1e-6  # of the second with the rim
    assert run.solver.crossings().number == 0


def test_an_opening_that_is_too_small_is_no_surface(build: Build) -> None:
    """A soft sphere of 10 mm squeezed through an opening of 8 mm goes through no triangle: it came
    through the opening, and is known as one that does not fit through it."""
    run = build(soft(with_hole(5), [0.0, 0.0, 0.008], [0.0, 0.0, -3.0]))
    run.advance(10)
    assert run.solver.snapshot().position_m[0, 2] < -0.005
    assert run.solver.crossings().number == 0


def test_who_passes_a_free_edge_goes_through_nothing(build: Build) -> None:
    """Its centre 1 mm beside the plate, and another 1 mm on it."""
    start_m = [[0.021, 0.0, 0.008], [-0.019, 0.0, 0.008]]
    run = build(soft(plate(0.02, 4), start_m, [0.0, 0.0, -3.0]))
    run.advance(10)
    assert (run.solver.snapshot().position_m[:, 2] < -0.005).all()
    crossings = run.solver.crossings()
    assert (crossings.number, crossings.first_id) == (1, 2)


@pytest.mark.parametrize("speed_m_per_s", [450.0, 2000.0])
def test_who_jumps_over_the_surface_in_one_step_is_found(build: Build, speed_m_per_s: float) -> None:
    """Steps of 9 and 40 mm, over a radius of 5 mm and beyond all lists of neighbours."""
    start_m = [0.001, 0.002, 0.5 + 0.006 * speed_m_per_s / 450.0]
    given = particles(start_m, [0.0, 0.0, -speed_m_per_s])
    domain_m = np.array([[-1.0, -1.0, -9.0], [1.0, 1.0, 9.0]])
    lifted = plate(0.05, 2)
    lifted.position_m[:, 2] += 0.5
    run = build(plan(lifted, given, gravity_m_per_s2=WEIGHTLESS, domain_m=domain_m, sync_interval_s=2e-4))
    run.advance(1)
    assert run.solver.snapshot().position_m[0, 2] < 0.5
    assert run.solver.crossings().number == 1


def moved(surface: TriangleSurface, by_m: Array, velocity_m_per_s: Array) -> Motion:
    still = at_rest(surface)
    return Motion(still.position_m + by_m, still.velocity_m_per_s + velocity_m_per_s)


def test_a_surface_that_moves_through_a_particle(build: Build) -> None:
    """The plate rises at 3 m/s through two spheres at rest; so does, at a sync point, one that the
    coupling corrects by 20 mm."""
    up = np.array([0.0, 0.0, 1.0])
    surface = plate(0.05, 4)
    given = [[0.0, 0.0, 0.008], [0.021, 0.02, 0.008]]
    run = build(soft(surface, given))
    run.velocity_m_per_s = 3.0 * up
    run.advance(6)
    assert run.solver.crossings().number == 2
    run = build(soft(surface, given))
    end = moved(surface, 0.02 * up, 0.0 * up)
    run.solver.advance(Interval(0, 1e-3), HermitePath(end, end, 1e-3))
    assert run.solver.crossings().number == 2


def test_a_surface_that_follows_is_not_crossed(build: Build) -> None:
    """Particles at rest cross nothing of a surface that falls and turns with them."""
    surface = plate(0.05, 4)
    given = particles([[0.0, 0.0, 0.0049], [0.02, 0.013, 0.0049]], [0.4, 0.1, -2.0])
    run = build(plan(surface, given, gravity_m_per_s2=WEIGHTLESS, restitution=table(1.0)))
    run.velocity_m_per_s = np.array([0.4, 0.1, -2.0])
    run.advance(30)
    assert run.solver.crossings().number == 0


def test_crossings_are_saved(build: Build) -> None:
    run = build(soft(plate(0.02, 4), [0.001, 0.002, 0.008], [0.0, 0.0, -3.0]))
    solver = run.solver
    early = solver.save()
    run.advance(10)
    crossings, late = run.solver.crossings(), solver.save()
    run.solver.overlaps()
    solver.restore(early)
    assert run.solver.crossings().number == 0
    assert run.solver.overlaps().surface_m == 0.0
    solver.restore(late)
    assert vars(run.solver.crossings()).keys() == vars(crossings).keys()
    assert run.solver.crossings().number == crossings.number == 1
    np.testing.assert_array_equal(run.solver.crossings().first_position_m, crossings.first_position_m)
    assert run.solver.overlaps().surface_per_diameter == pytest.approx(0.5, abs=0.01)


def test_overlaps_are_the_deepest_of_all_steps(build: Build) -> None:
    """The overlaps are those of a pair that meets and of a sphere that bounces between two times at which
    is looked, when nothing touches: Hertz, 0.9745 (m^2 v^4 / (R E*^2))^(1/5), Johnson, Contact Mechanics,
    1985, section 11.4."""
    place_m = [[0.0, 0.0, 0.0052], [0.1, 0.0, 0.05], [0.1104, 0.0, 0.05]]
    velocity_m_per_s = [[0.0, 0.0, -0.5], [0.5, 0.0, 0.0], [-0.5, 0.0, 0.0]]
    given = particles(place_m, velocity_m_per_s)
    run = build(plan(plate(0.02, 3), given, restitution=table(1.0), gravity_m_per_s2=WEIGHTLESS, step_s=5e-6))
    assert run.solver.overlaps().surface_m == 0.0
    run.advance(10)
    overlaps, again = run.solver.overlaps(), run.solver.overlaps()
    mass_kg, E_Pa = 1430.0 * np.pi / 6.0 * 0.01**3, 1e7 / (2.0 * (1.0 - 0.3**2))
    on_surface_m = 0.9745 * (mass_kg**2 * 0.5**4 / (0.005 * E_Pa**2)) ** 0.2
    between_m = 0.9745 * ((mass_kg / 2) ** 2 * 1.0**4 / (0.0025 * E_Pa**2)) ** 0.2
    assert overlaps.surface_m == pytest.approx(on_surface_m, rel=2e-3)
    assert overlaps.between_m == pytest.approx(between_m, rel=2e-3)
    assert overlaps.surface_per_diameter == pytest.approx(on_surface_m / 0.01, rel=2e-3)
    assert overlaps.between_per_diameter == pytest.approx(between_m / 0.01, rel=2e-3)
    assert again.surface_m == again.between_m == 0.0
