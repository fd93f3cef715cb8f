"""The compiled engine, which holds a plan's surface, laws and particles and takes arrays by name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from adapters.particles._liggghts import Engine
from adapters.particles.liggghts.domain_cuts import first_cuts
from adapters.particles.liggghts.input import (
    CLASS_RATIO,
    FIRST_EVALUATION,
    cutoff_m,
    has_bodies,
    has_sliding,
    input_text,
    smallest_box_m,
)
from orchestrator.ports import Array, HermitePath, Indices
from orchestrator.ports.decomposition import Grid
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import DeckPlan, GrainMaterial, Jkr, ParticleList, ParticlesPlan, Sjkr

SAME_PLACE = 1e-6  # of the period: points closer than this, one period on, are joined


def start_engine(plan: ParticlesPlan, communicator: Any, folder: Path) -> Engine:
    """Return LIGGGHTS with the plan's laws and surface, before the first particle."""
    text = input_text(plan)
    if communicator.rank == 0:
        (folder / "in.liggghts").write_text(text + FIRST_EVALUATION + "\n", encoding="utf-8")
    engine = Engine(
        communicator=communicator.py2f(),
        screen_file=str(folder / "screen.liggghts"),
        log_file=str(folder / "log.liggghts"),
        contact_distance_factor=contact_distance_factor(plan),
        class_ratio=CLASS_RATIO,
    )
    for rebound in plan.rebounds:
        one, other = rebound.materials
        engine.set_rebound(
            type=one + 1,
            other_type=other + 1,
            speed_m_per_s=floats(rebound.speed_m_per_s),
            restitution=floats(rebound.restitution),
        )
    for line in text.splitlines():
        engine.command(line)
    if communicator.size > 1:
        grid, corners_m = parts(engine), smallest_box_m(plan)
        engine.cut(first_cuts(plan, grid, corners_m, cutoff_m(plan)))
    engine.set_surface(
        position_m=floats(plan.surface.position_m),
        rigid_first=ints(plan.surface.rigid.first),
        rigid_share=floats(plan.surface.rigid.share),
        triangles=ints(plan.surface.triangles),
        type=ints(plan.surface.material + 1),
        largest_radius_m=plan.largest_radius_m,
    )
    if has_bodies(plan):
        _set_shapes(engine, plan)
    _set_laws(engine, plan)
    if plan.wear_m3_per_N_m is not None:
        engine.set_wear(floats(plan.wear_m3_per_N_m))
    if plan.predicts_load:
        engine.ask_contact_tangent()
    if plan.periodic_y:
        period_m = float(plan.domain_m[1, 1] - plan.domain_m[0, 1])
        joined = join_across(plan.surface, period_m)
        engine.repeat_surface(period_m=period_m, joined_triangles=ints(joined))
    surface = plan.surface
    engine.set_exits(
        center_m=floats([exit.center_m for exit in plan.exits]).reshape(-1, 3),
        axes=floats([exit.axes for exit in plan.exits]).reshape(-1, 3, 3),
        half_m=floats([exit.half_m for exit in plan.exits]).reshape(-1, 3),
        domain_m=floats(plan.domain_m),
        below_deck=ints([exit.product == "undersize" for exit in plan.exits]),
        deck=ints(surface.floor),
    )
    if plan.deck is not None:
        _count_contacts(engine, plan.deck, surface)
    return engine


def _count_contacts(engine: Engine, deck: DeckPlan, surface: TriangleSurface) -> None:
    engine.set_deck(
        along=floats(deck.along),
        across=floats(deck.across),
        points=ints(deck.points),
        panel=ints(deck.panel),
        station_m=floats(deck.station_m),
        open_m=floats(deck.open_m),
        reach_m=deck.reach_m,
        half_depth_m=floats(deck.half_depths_m),
        on_deck=ints(surface.on_deck),
    )


def parts(engine: Engine) -> Grid:
    """Return the numbers of the ranks' parts along x, y and z."""
    x, y, z = (len(cuts) - 1 for cuts in engine.cuts())
    return x, y, z


def create_particles(engine: Engine, new: ParticleList, first_id: int) -> None:
    """Create particles from memory, with ids in order from ``first_id``."""
    engine.create(
        position_m=floats(new.position_m),
        velocity_m_per_s=floats(new.velocity_m_per_s),
        spin_rad_per_s=floats(new.spin_rad_per_s),
        diameter_m=floats(new.grains.sieve_size_m),
        density_kg_per_m3=floats(new.grains.density_kg_per_m3),
        type=ints(new.grains.material + 1),
        first_id=first_id,
    )


def create_bodies(engine: Engine, new: ParticleList, first_id: int) -> None:
    """Create bodies from memory, with ids in order from ``first_id``."""
    engine.create_bodies(
        position_m=floats(new.position_m),
        velocity_m_per_s=floats(new.velocity_m_per_s),
        spin_rad_per_s=floats(new.spin_rad_per_s),
        size_m=floats(new.grains.sieve_size_m),
        density_kg_per_m3=floats(new.grains.density_kg_per_m3),
        type=ints(new.grains.material + 1),
        shape=ints(new.grains.shape),
        turn=floats(new.orientation),
        first_id=first_id,
    )


def _set_shapes(engine: Engine, plan: ParticlesPlan) -> None:
    """Tell the engine what bodies are made of, and how far from a centre it must look for spheres."""
    spheres = [np.array(shape.spheres) for shape in plan.shapes]
    reaches = [
        (np.linalg.norm(each[:, :3], axis=1).max() + each[:, 3].max()) / shape.bounding_radius
        for each, shape in zip(spheres, plan.shapes, strict=True)
    ]
    engine.set_shapes(
        count=ints([len(each) for each in spheres]),
        spheres=floats(np.concatenate(spheres)),
        volume=floats([shape.volume for shape in plan.shapes]),
        inertia=floats([shape.inertia for shape in plan.shapes]),
        bounding_radius=floats([shape.bounding_radius for shape in plan.shapes]),
        reach_m=max(reaches) * plan.largest_radius_m * contact_distance_factor(plan),
    )


def begin_path(engine: Engine, path: HermitePath, length_s: float, steps: int) -> None:
    """Let the surface points follow ``path`` over the next ``steps``."""
    engine.begin_path(
        start_m=floats(path.start.position_m),
        start_m_per_s=floats(path.start.velocity_m_per_s),
        end_m=floats(path.end.position_m),
        end_m_per_s=floats(path.end.velocity_m_per_s),
        length_s=length_s,
        steps=steps,
    )


def floats(values: npt.ArrayLike) -> Array:
    """Return an array of numbers in the layout that the engine takes."""
    return np.ascontiguousarray(values, dtype=np.float64)


def ints(values: npt.ArrayLike) -> npt.NDArray[np.int32]:
    """Return numbers of points or types in the layout that the engine takes."""
    return np.ascontiguousarray(values, dtype=np.int32)


def contact_distance_factor(plan: ParticlesPlan) -> float:
    """Return the factor of the contact distance up to which two parted bodies keep their contact.

    Beyond it LIGGGHTS forgets the contact (otherwise the tangential spring of a contact that forms again
    before the next neighbour list would be the old spring); a neck must snap within it.
    """
    stretch = plan.adhesion.largest_stretch if isinstance(plan.adhesion, Jkr) else 0.0
    return max(1.05, 1.0 + 1.1 * stretch)


def effective_moduli(materials: tuple[GrainMaterial, ...]) -> tuple[Array, Array]:
    """Return Hertz's E* and Mindlin's G* for every pair of materials, (k, k) each."""
    youngs = np.array([material.youngs_modulus_Pa for material in materials])
    poisson = np.array([material.poisson_ratio for material in materials])
    normal = (1.0 - poisson**2) / youngs
    shear = 2.0 * (2.0 - poisson) * (1.0 + poisson) / youngs
    return 1.0 / np.add.outer(normal, normal), 1.0 / np.add.outer(shear, shear)


def join_across(surface: TriangleSurface, period_m: float) -> Indices:
    """Return the triangles (m, 3) with periodic vertices identified.

    Vertices that are the same place one period along y further on have the number of the lower point.  Where
    bodies meet, it is that of the point's own body, so that the body goes on there; only a surface whose
    triangles do not share points is joined to any.
    """
    number = np.arange(len(surface.vertices_m))
    used = np.unique(surface.triangles)
    edges = np.concatenate([surface.triangles[:, [0, 1]], surface.triangles[:, [1, 2]]])
    linked = csr_array((np.ones(len(edges)), edges.T), shape=2 * (len(number),))
    body = connected_components(linked, directed=False)[1][used]
    for bodies_apart_m in (0.0, period_m):  # the own body's point takes the place of another's
        place_m = np.column_stack([surface.vertices_m[used], bodies_apart_m * body])
        lower = cKDTree(place_m).query(
            place_m - [0.0, period_m, 0.0, 0.0], distance_upper_bound=SAME_PLACE * period_m
        )[1]
        has_lower = lower < len(used)
        number[used[has_lower]] = used[lower[has_lower]]
    return np.asarray(number[surface.triangles])


def _set_laws(engine: Engine, plan: ParticlesPlan) -> None:
    """Give the engine the constants of the laws that the energy in contacts needs."""
    e_star_Pa, g_star_Pa = effective_moduli(plan.materials)
    adhesion, none = plan.adhesion, np.zeros((0, 0))
    engine.set_laws(
        e_star_Pa=e_star_Pa,
        g_star_Pa=g_star_Pa,
        tangential_spring=has_sliding(plan),
        work_J_per_m2=floats(adhesion.work_J_per_m2) if isinstance(adhesion, Jkr) else none,
        energy_density_J_per_m3=(
            floats(adhesion.energy_density_J_per_m3) if isinstance(adhesion, Sjkr) else none
        ),
    )
