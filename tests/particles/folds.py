"""A sphere held at chosen places next to a surface, for both particle codes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from orchestrator.ports import Array, Motion
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import ParticlesPlan
from tests.particles.contract import solver_adapter
from tests.particles.liggghts_plans import make_plan, sheet, spheres
from tests.reference.spheres.contacts import Neighbours
from tests.reference.spheres.forces import compute_forces
from tests.reference.spheres.laws import Laws
from tests.reference.spheres.spheres import Spheres

RADIUS_M = 2.5e-3
RIDGE, VALLEY = 1, -1
KINDS = pytest.mark.parametrize("kind", [RIDGE, VALLEY], ids=["ridge", "valley"])


@dataclass(frozen=True)
class Held:
    """Force on the sphere and all of that on the surface, (n, 3), and energy (n,), at n places."""

    force_N: Array
    load_N: Array
    elastic_J: Array


def fold(angle_deg: float, kind: int, half_m: float = 0.02) -> TriangleSurface:
    """Facets of 5 x 8 mm on two half planes that meet in x = 0, the normals turn by the angle."""
    slope = kind * np.tan(np.radians(angle_deg) / 2)
    x_m, y_m = np.arange(-half_m, half_m + 1e-6, 5e-3), 8e-3 * np.arange(-3, 4)
    return sheet(lambda x, y: -slope * np.abs(x), x_m, y_m)


def furrows() -> TriangleSurface:
    """Sharp ridges, 1.2 mm apart in the middle and diverging along y."""
    x = 0.6e-3 * np.arange(-6, 7)
    surface = sheet(lambda x, y: 1e-3 * np.cos(np.pi * x / 0.6e-3), x, 2e-3 * np.arange(-3, 4))
    surface.position_m[:, 0] = (surface.position_m[:, 0] + 0.6e-3) * (1.0 + 60.0 * surface.position_m[:, 1])
    return surface


def pit(slope: float, sides: int) -> TriangleSurface:
    """Sides of equal slope around a corner at the origin."""
    turn = 2 * np.pi * np.arange(sides) / sides
    rim_m = 0.02 * np.stack([np.cos(turn), np.sin(turn), slope * np.cos(np.pi / sides) + 0 * turn])
    corners = [[0, 1 + k, 1 + (k + 1) % sides] for k in range(sides)]
    material = np.ones(sides, dtype=np.int64)
    return TriangleSurface(np.vstack([np.zeros(3), rim_m.T]), np.array(corners), material)


def single_N(overlap_m: float) -> float:
    """Hertz for a single contact of the sphere with ``make_plan``'s surface."""
    plan = make_plan(fold(0.0, RIDGE), spheres([0.0, 0.0, 0.05]))
    hertz = Laws.of(plan).normal.youngs_modulus_Pa
    return float(4 / 3 * hertz[0, 1] * np.sqrt(RADIUS_M) * overlap_m**1.5)


def held(code: str, surface: TriangleSurface, place_m: Array) -> Held:
    """Elastic, without friction, every place on its own."""
    solver_adapter(code)
    if code == "liggghts":
        return _in_liggghts(make_plan(surface, spheres([0.0, 0.0, 0.05])), place_m)
    return _in_spheres(make_plan(surface, spheres(place_m)))


def _in_spheres(plan: ParticlesPlan) -> Held:
    some, surface_m = Spheres.of(plan.particles, 1), plan.surface.position_m
    none = np.zeros(0, dtype=np.int64)  # the spheres do not know each other
    near = replace(Neighbours.of(some, plan.surface, surface_m), i=none, j=none)
    still = Motion(surface_m, np.zeros_like(surface_m))
    now = compute_forces(Laws.of(plan), plan.surface, some, still, near, None, 0.0)
    contacts, acting, given_N = now.contacts, now.acting, np.zeros((len(some), 3))
    # the barycentric weights hand on all of a contact's force
    shares = contacts.barycentric.sum(axis=1)[:, None] * (acting.force_N + acting.turning_N)
    np.subtract.at(given_N, contacts.first, shares)
    elastic_J = np.bincount(contacts.first, acting.elastic_J, len(some))
    np.testing.assert_allclose(now.on_points_N.sum(axis=0), given_N.sum(axis=0), atol=1e-9)
    return Held(now.force_N, given_N, elastic_J)


def _in_liggghts(plan: ParticlesPlan, place_m: Array) -> Held:
    from mpi4py import MPI

    from adapters.particles.liggghts.engine import create_particles, start_engine
    from adapters.particles.liggghts.input import FIRST_EVALUATION

    forces_N, loads_N, energies_J = [], [], []
    with TemporaryDirectory() as folder:
        engine = start_engine(plan, MPI.COMM_SELF, Path(folder))
        create_particles(engine, plan.particles, 1)
        engine.command(FIRST_EVALUATION)
        for place in place_m:
            engine.particles()["x"][0] = place
            engine.prepare()
            forces_N.append(engine.particles()["f"][0].copy())
            loads_N.append(engine.force_N().sum(axis=0))
            energies_J.append(engine.surface_energy_J()["elastic_J"])
    return Held(np.array(forces_N), np.array(loads_N), np.array(energies_J))
