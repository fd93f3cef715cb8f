"""``[bed]``: the particles, by themselves, in blocks or fed at a rate."""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from orchestrator.case.tables.quantities import (
    Box,
    Name,
    NotNegative,
    Particles,
    Positive,
    Share,
    Table,
    Vector,
    Whole,
)


class SizeClass(Table):
    """Spheres with diameters spread evenly between two limits."""

    smallest_m: Positive
    """Smallest diameter."""
    largest_m: Positive
    """Largest diameter."""
    mass_fraction: Positive
    """Share of the mass; the shares of all classes add up to 1."""


class PassingPoint(Table):
    """A point of a cumulative size distribution."""

    diameter_m: Positive
    """Diameter."""
    passing: Share
    """Share of the mass that is finer."""


class Particle(Table):
    """One particle."""

    position_m: Vector
    """Its centre at t = 0."""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """Its velocity at t = 0."""
    spin_rad_per_s: Vector = (0.0, 0.0, 0.0)
    """Its angular velocity at t = 0."""
    diameter_m: Positive
    """Its diameter."""
    material: str
    """Its material, which also gives its density."""
    axes: Literal["deck", "world"] = "world"
    """Axes in which position, velocity and spin are given."""


class Filling(Table):
    """Particles that appear in a box, as blocks and feeds have them."""

    material: str
    """Their material."""
    box_m: Box
    """Lowest and highest corner of the box in which they appear."""
    sizes: tuple[SizeClass, ...] = ()
    """Size classes; or ``curve``."""
    curve: tuple[PassingPoint, ...] = ()
    """Cumulative size distribution, from fine to coarse, straight between its points."""
    smallest_fed_m: Positive | None = None
    """Particles finer than this are too many to compute: none of them is made."""
    finer: Literal["leave-out", "next-class"] = "leave-out"
    """What becomes of the mass finer than ``smallest_fed_m``: it is left out (a feed's rate is less
    by it), or made of the finest class that remains."""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """Velocity with which they appear; a feed's must carry them out of the box."""
    seed: Whole = 1
    """Seed of the random numbers: the same seed gives the same particles."""


class Block(Filling):
    """Particles that fill a box at t = 0 without touching each other."""

    count: Particles
    """How many particles."""
    axes: Literal["deck", "world"] = "deck"
    """Axes in which box and velocity are given."""


class Feed(Filling):
    """Particles fed at a rate through a box."""

    rate_kg_per_s: Positive
    """Mass fed per time."""
    axes: Literal["deck", "world"] = "world"
    """Axes in which box and velocity are given."""
    start_s: NotNegative = 0.0
    """When the feed starts."""
    stop_s: Positive | None = None
    """When it stops; without it, at the end of the run."""


class Bed(Table):
    """All particles; ids are given in the order particles, blocks, feeds, from 1."""

    particles: dict[Name, Particle] = Field(default_factory=dict)
    """Single particles by name."""
    blocks: dict[Name, Block] = Field(default_factory=dict)
    """Blocks by name."""
    feeds: dict[Name, Feed] = Field(default_factory=dict)
    """Feeds by name."""

    @property
    def sources(self) -> tuple[Block | Feed, ...]:
        """Blocks, then feeds."""
        return (*self.blocks.values(), *self.feeds.values())
