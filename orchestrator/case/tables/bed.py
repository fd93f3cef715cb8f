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
    """A shape of the case's own."""

    spheres: Annotated[tuple[Sphere, ...], Len(0, MOST_SPHERES)]
    """[x, y, z, r] of each sphere, in any unit and axes; they hang together, and the sieve size scales
    them (how-to/add-a-shape.md)."""


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
    """A class of evenly spread sieve sizes; or ``curve``."""

    MASS_POWER: ClassVar[int] = 4
    """The mass below a size is a straight line over this power of it; numbers are spread evenly."""

    smallest_m: Positive
    """Smallest sieve size."""
    largest_m: Positive
    """Largest sieve size."""
    mass_fraction: Positive
    """Share of the mass; all add up to 1."""


class PassingPoint(Table):
    """A point of the cumulative sizes, from fine to coarse, straight between points; ``curve.file =
    "lab.csv"`` takes a sieve analysis (how-to/use-a-sieve-analysis.md)."""

    sieve_size_m: Positive
    """Sieve size."""
    passing: Share
    """Share of the mass that is finer."""


class Particle(Table):
    """One particle at t = 0."""

    position_m: Vector
    """Its centre."""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """Its velocity."""
    spin_rad_per_s: Vector = (0.0, 0.0, 0.0)
    """Its angular velocity."""
    sieve_size_m: Positive
    """Smallest square opening that it passes; a sphere's diameter."""
    material: str
    """Its material."""
    rotation_rad: Vector = (0.0, 0.0, 0.0)
    """Turn from the axes of its shape (z of the smallest, x of the largest moment of inertia), as a
    vector."""
    shape: ShapeName = "sphere"
    """One of these or of ``[bed.shapes]``."""
    axes: Literal["deck", "world"] = "world"
    """Axes of position, velocity, spin and rotation."""


class Filling(Table):
    """The common part of blocks and feeds: particles that appear in a box."""

    material: str
    """Their material."""
    shape: ShapeName = "sphere"
    """One of these or of ``[bed.shapes]``."""
    box_m: Box
    """Lowest and highest corner of the box in which they appear."""
    sizes: tuple[SizeClass, ...] = ()
    """Size classes."""
    curve: tuple[PassingPoint, ...] = ()
    """Cumulative size distribution, from fine to coarse."""
    smallest_fed_m: Positive | None = None
    """Smallest sieve size that is computed."""
    finer: Literal["leave-out", "next-class"] = "leave-out"
    """Mass finer than that, or not computed of a sample: left out, from a feed's rate, too, or in the
    finest class computed whole."""
    velocity_m_per_s: Vector = (0.0, 0.0, 0.0)
    """Velocity with which they appear; a feed's must carry them out of the box."""
    seed: Whole = 1
    """Seed of the random numbers."""


class Block(Filling):
    """A block of particles that lie in a box at t = 0 without touching."""

    count: Particles
    """Number of particles."""
    axes: Literal["deck", "world"] = "deck"
    """Axes of box and velocity."""


class Feed(Filling):
    """A feed of particles through a box."""

    rate_kg_per_s: Positive
    """Mass rate."""
    sampled_below_m: Positive | None = None
    """Of finer particles only some are computed, each for others of its size in the separation;
    ``finer`` says where the others' mass goes."""
    sampled_as_m: Positive | None = None
    """Of sampled particles of diameter d, one in (``sampled_as_m`` / d)^3 is computed; by default
    ``sampled_below_m``."""
    axes: Literal["deck", "world"] = "world"
    """Axes of box and velocity."""
    start_s: NotNegative = 0.0
    """Start."""
    stop_s: Positive | None = None
    """Stop; by default the end of the run."""


class Bed(Table):
    """All particles, with ids from 1 through particles, blocks and feeds; ``from_run`` or ``table``
    replace the first two."""

    particles: dict[Name, Particle] = Field(default_factory=dict)
    """Single particles by name."""
    blocks: dict[Name, Block] = Field(default_factory=dict)
    """Blocks by name."""
    feeds: dict[Name, Feed] = Field(default_factory=dict)
    """Feeds by name."""
    shapes: dict[Name, OwnShape] = Field(default_factory=dict)
    """Shapes of the case's own, by name."""
    shape_divisions: Annotated[int, Strict(), Ge(1), Le(MOST_SPHERES)] = 1
    """Parts of the way between touching spheres of a shape: smoother and dearer (docs/theory/clumps.md)."""
    from_run: OneLine | None = None
    """Folder of a run, also of another machine, whose particles this case begins with; one that failed
    needs ``from_time_s``."""
    from_time_s: NotNegative | None = None
    """Its nearest state is taken, by default the last; checkpoints are exact."""
    table: OneLine | None = None
    """Table of particles in world axes: text, Parquet, VTK, of LIGGGHTS, LAMMPS or YADE
    ([columns](how-to/reuse-a-bed.md))."""
    columns: dict[OneLine, OneLine] = Field(default_factory=dict)
    """What unclear columns are: "size" = "diameter / mm", "ignore"."""
    decimal: Literal["", ".", ","] = ""
    """Decimal mark, if unclear."""
    material: OneLine | dict[OneLine, OneLine] | None = None
    """Material of the ``table``, or of each of its types: 1 = "coal"."""
    velocities: Literal["keep", "zero"] = "keep"
    """Motion of these particles: as it was, or at rest."""
    outside: Literal["refuse", "leave-out"] = "refuse"
    """Those outside of ``domain_m``."""
    push_out: Switch = False
    """Whether those in surfaces or too deep in each other are moved apart, or refused."""

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
