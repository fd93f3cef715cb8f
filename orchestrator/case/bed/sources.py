"""The particles at t = 0 and the feed that the table ``[bed]`` describes, in world axes."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from orchestrator.case.bed.feed import Feeds, Inlet
from orchestrator.case.bed.grains import material_numbers, planned, shapes
from orchestrator.case.bed.packing import place_block
from orchestrator.case.bed.size_distribution import classes, share_left_out
from orchestrator.case.deck.panels import axes, to_world
from orchestrator.case.tables.bed import Particle
from orchestrator.case.tables.carried_bed import MOTION, CarriedBed
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.ports.grains import Grain, ShapeTable, upright
from orchestrator.ports.plans import ParticleList


class NoRoom(Exception):
    """An error for a block whose box is too small for its particles; ``block`` is the block's name."""

    def __init__(self, block: str, why: str) -> None:
        super().__init__(why)
        self.block = block


def initial_particles(case: Case) -> ParticleList:
    """Return the single particles, then the blocks' particles, or else the carried ones.  Raises NoRoom."""
    blocks = [block_particles(case, name) for name in case.bed.blocks]
    carried = [] if case.bed.carried is None else [_carried_particles(case, case.bed.carried)]
    return ParticleList.joined([single_particles(case), *blocks, *carried])


def _carried_particles(case: Case, carried: CarriedBed) -> ParticleList:
    """Return the particles taken over, with the densities of the case's materials and the case's numbers."""
    own, table, numbers = carried.grains, ShapeTable.of(shapes(case)), material_numbers(case)
    density_kg_per_m3 = np.array([case.materials[name].density_kg_per_m3 for name in carried.materials])
    material = np.array([numbers[name] for name in carried.materials])
    shape = np.array([table.name.tolist().index(name) for name in own.shapes.name])
    grains = Grain(
        own.sieve_size_m, density_kg_per_m3[own.material], material[own.material], shape[own.shape], table
    )
    motion = (carried.position_m, carried.velocity_m_per_s, carried.spin_rad_per_s)
    return ParticleList(*motion, grains, carried.orientation)


def single_particles(case: Case) -> ParticleList:
    """Return the single particles of the case, in world axes."""
    rows = tuple(case.bed.particles.values())
    table, numbers = ShapeTable.of(shapes(case)), material_numbers(case)
    grains = Grain(
        np.array([row.sieve_size_m for row in rows], dtype=float),
        np.array([case.materials[row.material].density_kg_per_m3 for row in rows], dtype=float),
        np.array([numbers[row.material] for row in rows], dtype=np.int64),
        np.array([table.name.tolist().index(row.shape) for row in rows], dtype=np.int64),
        table,
    )
    position_m, velocity_m_per_s, spin_rad_per_s = (_in_world(case, rows, name) for name in MOTION)
    return ParticleList(position_m, velocity_m_per_s, spin_rad_per_s, grains, _orientation(case, rows))


def _orientation(case: Case, rows: tuple[Particle, ...]) -> Array:
    """Return how each particle is turned in the world, (n, 4)."""
    from scipy.spatial.transform import Rotation

    if not rows:
        return upright(0)
    deck = np.array([axes(case) if row.axes == "deck" else np.eye(3) for row in rows])
    own = Rotation.from_rotvec([row.rotation_rad for row in rows])
    return np.asarray((Rotation.from_matrix(deck) * own).as_quat()[:, [3, 0, 1, 2]])


def _in_world(case: Case, rows: tuple[Particle, ...], name: str) -> Array:
    """Return a vector of each particle, such as its position, in world axes, (n, 3)."""
    given = [getattr(row, name) for row in rows]
    in_deck = np.array([row.axes == "deck" for row in rows], dtype=bool)
    vectors = np.array(given, dtype=float).reshape(-1, 3)
    return np.where(in_deck[:, None], to_world(case, vectors), vectors)


def block_particles(case: Case, name: str) -> ParticleList:
    """Return the particles of the block ``name``, in world axes.  Raises NoRoom."""
    row = case.bed.blocks[name]
    try:
        particles = place_block(row, planned(case, row.material, row.shape))
    except ValueError as error:
        raise NoRoom(name, str(error)) from None
    if row.axes == "world":
        return particles
    return replace(
        particles,
        position_m=to_world(case, particles.position_m),
        velocity_m_per_s=to_world(case, particles.velocity_m_per_s),
    )


def inlets(case: Case) -> dict[str, Inlet]:
    """Return the inlets of all feeds, by the feeds' names."""
    return {
        name: Inlet(
            name=name,
            sizes=classes(feed),
            rate_kg_per_s=feed.rate_kg_per_s * (1.0 - share_left_out(feed)),
            box_m=np.array(feed.box_m),
            velocity_m_per_s=np.array(feed.velocity_m_per_s),
            grain=planned(case, feed.material, feed.shape),
            start_s=feed.start_s,
            stop_s=math.inf if feed.stop_s is None else feed.stop_s,
            seed=feed.seed,
            axes=axes(case) if feed.axes == "deck" else np.eye(3),
            batch_s=batch_s(case),
        )
        for name, feed in case.bed.feeds.items()
    }


def batch_s(case: Case) -> float:
    """Return the time between two batches of fed particles: a whole number of sync intervals."""
    interval_s = case.coupling.sync_interval_s
    return interval_s * max(1, round(case.particles.feed_interval_s / interval_s))


def combine_feeds(case: Case, first: ParticleList) -> Feeds | None:
    """Return all feeds as one feed, which also records the ``first`` particles; None without feeds."""
    if not case.bed.feeds:
        return None
    every = round(batch_s(case) / case.coupling.sync_interval_s)
    return Feeds(list(inlets(case).values()), every, first)
