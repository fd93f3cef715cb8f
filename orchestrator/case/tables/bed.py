"""The table ``[bed]``: single particles, blocks of particles, and feeds."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from typing import Annotated, Any, ClassVar, Literal, Self

from annotated_types import Ge, Le, Len
from pydantic import Field, PrivateAttr, Strict, ValidationError, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError

from orchestrator.case import solvers
from orchestrator.case.file.errors import REFUSED
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.case.tables.quantities import (
    Box,
    Name,
    NotNegative,
    Number,
    OneLine,
    Particles,
    Positive,
    Share,
    Switch,
    Table,
    Vector,
    Whole,
)
from orchestrator.ports.clumps import clump, divided_spheres

ShapeName = Annotated[str, solvers.ShapeNames()]
MOST_SPHERES = 64
Sphere = tuple[Number, Number, Number, Positive]


class OwnShape(Table):
    """A shape of grains of the case's own, which particles, blocks and feeds name as their ``shape``."""

    spheres: Annotated[tuple[Sphere, ...], Len(0, MOST_SPHERES)]
    """Place and radius of each sphere, [x, y, z, r], in any unit of length and any axes.  They overlap or
    touch, so that all hang together, and what they have in common counts once.  The grain's size scales the
    shape, whose sieve size, centre of mass and moments of inertia are computed
    (how-to/add-a-shape.md)."""


@cache
def _why_no_grain(spheres: tuple[Sphere, ...]) -> str:
    """Return why spheres make no grain; empty if they do."""
    try:
        clump("", "", spheres)
    except ValueError as error:
        return str(error)
    return ""


def _wrong(error: PydanticCustomError, value: Any, *key: str) -> InitErrorDetails:
    return InitErrorDetails(type=error, loc=key, input=value)


class SizeClass(Table):
    """A class of particles whose sieve sizes are spread evenly between two limits."""

    MASS_POWER: ClassVar[int] = 4
    """The mass below a size is a straight line over this power of it; numbers are spread evenly."""

    smallest_m: Positive
    """Smallest sieve size: the side of the smallest square opening that a particle passes, which is the
    diameter of a sphere."""
    largest_m: Positive
    """Largest sieve size."""
    mass_fraction: Positive
    """Share of the mass; the shares of all classes add up to 1."""


class PassingPoint(Table):
    """A point of a cumulative size distribution."""

    sieve_size_m: Positive
    """Sieve size."""
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
    sieve_size_m: Positive
    """Its sieve size: the side of the smallest square opening that it passes, which is the diameter of a
    sphere."""
    material: str
    """Its material, which also gives its density."""
    rotation_rad: Vector = (0.0, 0.0, 0.0)
    """How it is turned at t = 0 from the axes of its shape: a vector along the axis of the turn, as long
    as its angle.  The principal axis of the largest moment of inertia is x, that of the smallest one z."""
    shape: ShapeName = "sphere"
    """Its shape: of what spheres it is made.  A name of this list or of
    ``[bed.shapes]``."""
    axes: Literal["deck", "world"] = "world"
    """Axes in which position, velocity, spin and rotation are given."""


class Filling(Table):
    """The common part of blocks and feeds: particles that appear in a box."""

    material: str
    """Their material."""
    shape: ShapeName = "sphere"
    """Their shape: of what spheres each is made.  A name of this list or of
    ``[bed.shapes]``."""
    box_m: Box
    """Lowest and highest corner of the box in which they appear."""
    sizes: tuple[SizeClass, ...] = ()
    """Size classes.  Give either these or ``curve``."""
    curve: tuple[PassingPoint, ...] = ()
    """Cumulative size distribution, from fine to coarse, straight between its points.  Give either
    this or ``sizes``.  ``curve.file = "lab.csv"`` takes it from a sieve analysis in the case's folder
    (how-to/use-a-sieve-analysis.md)."""
    smallest_fed_m: Positive | None = None
    """Smallest sieve size that is computed; finer particles would be too many."""
    finer: Literal["leave-out", "next-class"] = "leave-out"
    """Treatment of the mass finer than ``smallest_fed_m``, and of a feed's that a sample does not
    compute.  leave-out: it is left out, which reduces a feed's rate.  next-class: the finest class of which
    all particles are computed takes it over."""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """Velocity with which they appear; the velocity of a feed must carry them out of the box."""
    seed: Whole = 1
    """Seed of the random numbers: the same seed gives the same particles."""


class Block(Filling):
    """A block of particles that lie in a box at t = 0 without touching each other."""

    count: Particles
    """Number of particles."""
    axes: Literal["deck", "world"] = "deck"
    """Axes in which box and velocity are given."""


class Feed(Filling):
    """A feed of particles through a box."""

    rate_kg_per_s: Positive
    """Mass rate of the feed."""
    sampled_below_m: Positive | None = None
    """Finer particles are sampled: only some of them are computed, each of which stands for others of its
    size in all shares of the separation.  What becomes of the others' mass, ``finer`` says."""
    sampled_as_m: Positive | None = None
    """Of the sampled particles, so few are computed as if all of them had this diameter: of those of
    diameter d, one in (``sampled_as_m`` / d)^3.  By default, it is ``sampled_below_m``."""
    axes: Literal["deck", "world"] = "world"
    """Axes in which box and velocity are given."""
    start_s: NotNegative = 0.0
    """Time at which the feed starts."""
    stop_s: Positive | None = None
    """Time at which the feed stops.  By default, it stops at the end of the run."""


class Bed(Table):
    """All particles.  Their ids start from 1, in the order particles, blocks, feeds.  With ``from_run`` or
    ``table``, the particles taken over replace single particles and blocks, while feeds stay."""

    particles: dict[Name, Particle] = Field(default_factory=dict)
    """Single particles by name."""
    blocks: dict[Name, Block] = Field(default_factory=dict)
    """Blocks by name."""
    feeds: dict[Name, Feed] = Field(default_factory=dict)
    """Feeds by name."""
    shapes: dict[Name, OwnShape] = Field(default_factory=dict)
    """Shapes of the case's own, by name."""
    shape_divisions: Annotated[int, Strict(), Ge(1), Le(MOST_SPHERES)] = 1
    """Number of parts into which spheres divide the way between each two touching spheres of a shape.  1
    takes a shape's spheres as they are; more make its dents finer, at the same outline and sieve size.  The
    cost goes with the number of spheres, of which a shape has 64 at most (docs/theory/clumps.md)."""
    from_run: OneLine | None = None
    """Folder of a run whose particles this case begins with, from the case's folder or from the working
    directory.  It may be a run of another level, mesh or machine; that of a run that failed needs a
    ``from_time_s``."""
    from_time_s: NotNegative | None = None
    """With ``from_run``: time of the state; the nearest recorded state is taken.  By default, it is the
    last one.  States of checkpoints are exact, others are those of the ParaView files."""
    table: OneLine | None = None
    """Table of particles, from the case's folder or from the working directory: CSV or another text, Parquet,
    ParaView's .vtu, .vtp or .vtk, a dump or data file of LIGGGHTS or LAMMPS, or an export of YADE
    (how-to/come-from-another-program.md).  Its own names of columns are x_m, y_m, z_m, sieve_size_m and
    material; and, if given, vx_m_per_s, vy_m_per_s, vz_m_per_s, wx_rad_per_s, wy_rad_per_s, wz_rad_per_s.
    All are in world axes."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """What columns of ``table`` are, where their names leave it open: "size" = "diameter / mm"; "ignore"
    leaves one out."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark of ``table``, where it leaves it open."""
    material: OneLine | dict[OneLine, OneLine] | None = None
    """Material of all particles of a ``table`` that names none; or the material of each of its types, such as
    1 = "coal"."""
    velocities: Literal["keep", "zero"] = "keep"
    """Velocities and spins of the particles taken over.  keep: as they were.  zero: all at rest."""
    outside: Literal["refuse", "leave-out"] = "refuse"
    """Particles taken over that are outside of ``domain_m``."""
    push_out: Switch = False
    """true: particles taken over that lie in surfaces or too deep in each other are moved apart before
    the start.  false: they are refused."""

    _carried: CarriedBed | None = PrivateAttr(default=None)

    @model_validator(mode="after")
    def _known_shapes(self) -> Self:
        if wrong := [*self._wrong_shapes()]:
            raise ValidationError.from_exception_data("Bed", wrong)
        return self

    def _wrong_shapes(self) -> Iterator[InitErrorDetails]:
        known = solvers.names("shapes")
        for name, own in self.shapes.items():
            if name in known:
                why = f'the name "{name}" is that of a shape of flipflow: take another one'
                yield _wrong(PydanticCustomError(REFUSED, why), name, "shapes", name)
            elif why := _why_no_grain(own.spheres):
                no_grain = PydanticCustomError(REFUSED, why)
                yield _wrong(no_grain, own.spheres, "shapes", name, "spheres")
        named: dict[str, Mapping[str, Particle | Filling]]
        named = {"particles": self.particles, "blocks": self.blocks, "feeds": self.feeds}
        allowed = (*known, *self.shapes)
        for kind, rows in named.items():
            for name, row in rows.items():
                if row.shape not in allowed:
                    *most, last = map(repr, allowed)
                    names = f"{', '.join(most)} or {last}"
                    unknown = PydanticCustomError("literal_error", names)
                    yield _wrong(unknown, row.shape, kind, name, "shape")
                elif (count := self._sphere_count(row.shape)) > MOST_SPHERES:
                    why = f'shape "{row.shape}" has {count} spheres then, more than {MOST_SPHERES}'
                    many = PydanticCustomError(REFUSED, why)
                    yield _wrong(many, self.shape_divisions, "shape_divisions")
                    return

    def _sphere_count(self, name: str) -> int:
        """Return the number of spheres of a shape, divided."""
        if self.shape_divisions == 1:
            return 0  # which has been checked
        own = self.shapes[name].spheres if name in self.shapes else solvers.shape(name).spheres
        return len(divided_spheres(own, self.shape_divisions))

    @property
    def is_carried(self) -> bool:
        """True if the particles at t = 0 come from a run or from a table."""
        return self.from_run is not None or self.table is not None

    @property
    def carried(self) -> CarriedBed | None:
        """The particles that were taken over, once they have been read (case/bed/carry.py)."""
        return self._carried

    def with_carried(self, carried: CarriedBed) -> Bed:
        """Return a copy that begins with the ``carried`` particles instead of those that it describes."""
        bed = self.model_copy(update={"particles": {}, "blocks": {}})
        bed._carried = carried
        return bed

    @property
    def has_material(self) -> bool:
        """True if there is more than single particles: blocks, feeds, or particles that were taken over."""
        return bool(self.sources or self.carried)

    @property
    def sources(self) -> tuple[Block | Feed, ...]:
        """All blocks, then all feeds."""
        return (*self.blocks.values(), *self.feeds.values())
