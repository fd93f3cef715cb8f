"""Grains: their shapes, and all that follows from shape, size and density."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Generic, Self, TypeVar

import numpy as np
import numpy.typing as npt

from orchestrator.ports.interface_records import Array, Indices
from orchestrator.ports.rows import Rows

Number = TypeVar("Number", float, npt.NDArray[np.float64])


@dataclass(frozen=True)
class Shape:
    """A rigid shape made of spheres, to which every grain of the shape is similar.

    Lengths are in sieve sizes: the shape passes a square opening of side 1, and no smaller one.  The origin
    is the centre of mass, and the axes are the principal ones.

    Parameters
    ----------
    name
        Its name in a case.
    about
        One line for the documentation: what it is.
    spheres
        Place and radius (x, y, z, r) of each sphere.
    volume
        The volume of all spheres together.
    inertia
        The principal moments of inertia at a density of 1.
    """

    name: str
    about: str
    spheres: tuple[tuple[float, float, float, float], ...]
    volume: float
    inertia: tuple[float, float, float]

    @property
    def bounding_radius(self) -> float:
        """The radius of the sphere about the centre of mass that just holds the shape."""
        return max(float(np.linalg.norm(place)) + radius for *place, radius in self.spheres)

    @property
    def contact_radius(self) -> float:
        """The smallest radius with which the shape touches anything."""
        return min(radius for *_, radius in self.spheres)


@dataclass(frozen=True, eq=False)
class ShapeTable(Rows):
    """The numbers of k shapes, an array (k, ...) for each, by which sizes become grains.

    The names are those of ``Shape``.  Grains of one plan have the same table, whose rows are not grains.
    """

    name: npt.NDArray[np.str_]
    volume: Array
    inertia: Array
    bounding_radius: Array
    contact_radius: Array
    spheres: Array
    """(k, most, 4): of shapes with fewer spheres than the most, the last rows are 0."""

    @staticmethod
    def of(shapes: Sequence[Shape]) -> ShapeTable:
        """Return the table of some shapes, whose numbers are their places among them."""
        names = [field.name for field in fields(ShapeTable) if field.name != "spheres"]
        numbers = {name: np.array([getattr(shape, name) for shape in shapes]) for name in names}
        spheres = np.zeros((len(shapes), max((len(shape.spheres) for shape in shapes), default=0), 4))
        for row, shape in zip(spheres, shapes, strict=True):
            row[: len(shape.spheres)] = shape.spheres
        return ShapeTable(**numbers, spheres=spheres)

    @property
    def sphere_count(self) -> Indices:
        """The number of spheres of each shape (k,)."""
        return np.asarray(np.count_nonzero(self.spheres[:, :, 3], axis=1))

    def shapes(self) -> tuple[Shape, ...]:
        """Return the shapes, without what they are about."""
        return tuple(
            Shape(
                name=str(self.name[k]),
                about="",
                spheres=tuple((x, y, z, r) for x, y, z, r in self.spheres[k, :count].tolist()),
                volume=float(self.volume[k]),
                inertia=(self.inertia[k, 0].item(), self.inertia[k, 1].item(), self.inertia[k, 2].item()),
            )
            for k, count in enumerate(self.sphere_count)
        )

    def part(self, rows: Any) -> Self:
        """Return the whole table, whatever the rows of grains."""
        return self

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the one table that all grains of a plan have; none at all may lack it."""
        return max(parts, key=lambda table: len(table.name))


@dataclass(frozen=True, eq=False)
class Grain(Rows, Generic[Number]):
    """A grain, or n of them if its fields are arrays (n,): ``Grains``.

    Parameters
    ----------
    sieve_size_m
        The side of the smallest square opening that it passes; the diameter of a sphere.
    density_kg_per_m3
        The density of its material.
    material
        The number of its material in the plan.
    shape
        The number of its shape in ``shapes``.
    shapes
        All shapes of the plan.

    Examples
    --------
    Two balls of glass, of 10 and 20 mm:

    >>> ball = Shape("ball", "a ball", ((0.0, 0.0, 0.0, 0.5),), np.pi / 6, (np.pi / 60,) * 3)
    >>> balls = Grain(1.0, 2500.0, 0, 0, ShapeTable.of([ball])).of_sizes(np.array([0.01, 0.02]))
    >>> balls.mass_kg.round(5)
    array([0.00131, 0.01047])
    >>> float(balls.part(1).bounding_radius_m)
    0.01
    """

    sieve_size_m: Number
    density_kg_per_m3: Number
    material: Any
    shape: Any
    shapes: ShapeTable

    def _of_shape(self, name: str) -> Number:
        """Return a number of the shape, or of each grain's."""
        number = getattr(self.shapes, name)[self.shape]
        told: Number = number if number.ndim else number.item()
        return told

    @property
    def volume_m3(self) -> Number:
        """The volume."""
        return self._of_shape("volume") * self.sieve_size_m**3

    @property
    def mass_kg(self) -> Number:
        """The mass."""
        return self._of_shape("volume") * self.density_kg_per_m3 * self.sieve_size_m**3

    @property
    def inertia_kg_m2(self) -> Array:
        """The principal moments of inertia, (3,) or (n, 3)."""
        scale_kg_m2 = np.asarray(self.density_kg_per_m3 * self.sieve_size_m**5)
        return np.asarray(self.shapes.inertia[self.shape] * scale_kg_m2[..., None])

    @property
    def bounding_radius_m(self) -> Number:
        """The radius of the sphere about the centre of mass that just holds the grain."""
        return self._of_shape("bounding_radius") * self.sieve_size_m

    @property
    def contact_radius_m(self) -> Number:
        """The smallest radius with which the grain touches anything."""
        return self._of_shape("contact_radius") * self.sieve_size_m

    @property
    def equivalent_diameter_m(self) -> Number:
        """The diameter of the sphere of equal volume."""
        cubed = self._of_shape("volume") * 6.0 / math.pi
        return cubed ** (1 / 3) * self.sieve_size_m  # type: ignore[no-any-return]

    @property
    def sphere_count(self) -> Any:
        """The number of spheres of the shape, or of each grain's (n,)."""
        return self.shapes.sphere_count[self.shape]

    def spheres(self) -> tuple[Indices, Array]:
        """Return all spheres of n grains, grain by grain: the row of each one's grain (m,), and their places
        from the centre of mass, in the axes of the shape, and radii, in metres (m, 4)."""
        used = self.shapes.spheres[self.shape]
        grain, number = np.nonzero(used[:, :, 3])
        return grain, np.asarray(used[grain, number] * np.asarray(self.sieve_size_m)[grain, None])

    @property
    def shape_names(self) -> npt.NDArray[np.str_]:
        """The names of the shapes (n,)."""
        return np.asarray(self.shapes.name[self.shape])

    def resized(self, sieve_size_m: Number) -> Grain[Number]:
        """Return a grain like this one, of another size."""
        return replace(self, sieve_size_m=sieve_size_m)

    def of_sizes(self, sieve_size_m: Array) -> Grains:
        """Return grains like this one, of these sizes (n,)."""
        count = len(sieve_size_m)
        density_kg_per_m3, material, shape = (
            np.full(count, own) for own in (self.density_kg_per_m3, self.material, self.shape)
        )
        return Grain(sieve_size_m.copy(), density_kg_per_m3, material, shape, self.shapes)

    def __len__(self) -> int:
        return len(self.material)


Grains = Grain[npt.NDArray[np.float64]]
"""n grains, one a row."""


def upright(count: int) -> Array:
    """Return the quaternions w, x, y, z (n, 4) of grains that stand in the axes of their shapes."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))


def turned(orientation: Array, vectors: Array) -> Array:
    """Return vectors (n, 3) in the axes of shapes as vectors of the world, by quaternions (n, 4)."""
    w, axis = orientation[:, :1], orientation[:, 1:]
    across = 2.0 * np.cross(axis, vectors)
    return np.asarray(vectors + w * across + np.cross(axis, across))


def turned_back(orientation: Array, vectors: Array) -> Array:
    """Return vectors (n, 3) of the world in the axes of the shapes: the inverse of ``turned``."""
    return turned(orientation * [1.0, -1.0, -1.0, -1.0], vectors)


def placed_spheres(grains: Grains, position_m: Array, orientation: Array) -> tuple[Indices, Array, Array]:
    """Return all spheres of n grains, grain by grain: the row of each one's grain (m,), its centre (m, 3) in
    the world, and its radius (m,), in metres."""
    grain, own_m = grains.spheres()
    return grain, position_m[grain] + turned(orientation[grain], own_m[:, :3]), own_m[:, 3]
