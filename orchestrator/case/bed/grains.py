"""The grains of a case: their shapes and materials, and how small and large they are."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.bed.size_distribution import classes
from orchestrator.case.tables.case import Case
from orchestrator.ports.clumps import clump, divided
from orchestrator.ports.grains import Grain, Shape, ShapeTable


def material_numbers(case: Case) -> dict[str, int]:
    """Return the number of each material of particles, panels and surfaces, in the case's order."""
    bed, screen = case.bed, case.screen
    rows = (bed.particles, bed.blocks, bed.feeds, screen.panels, screen.surfaces)
    used = {row.material for table in rows for row in table.values()}
    used.update(bed.carried.materials if bed.carried is not None else ())
    return {name: number for number, name in enumerate(name for name in case.materials if name in used)}


def shapes(case: Case) -> tuple[Shape, ...]:
    """Return the shapes of all particles of a case, in alphabetical order, which is that of their numbers."""
    bed = case.bed
    names = {row.shape for row in (*bed.particles.values(), *bed.sources)}
    names.update(bed.carried.grains.shapes.name.tolist() if bed.carried is not None else ())
    return tuple(shape(case, name) for name in sorted(names))


def shape(case: Case, name: str) -> Shape:
    """Return a shape by its name: the case's own, one of flipflow and its packages, or that with which
    particles were taken over, which is not divided again."""
    carried = case.bed.carried
    if name in case.bed.shapes:
        own = _own_shape(name, case.bed.shapes[name].spheres)
    elif name not in solvers.names("shapes") and carried is not None:
        return next(each for each in carried.grains.shapes.shapes() if each.name == name)
    else:
        own = solvers.shape(name)
    return _divided(own, case.bed.shape_divisions)


@cache
def _divided(own: Shape, parts: int) -> Shape:
    return divided(own, parts)


@cache
def _own_shape(name: str, spheres: tuple[tuple[float, float, float, float], ...]) -> Shape:
    return clump(name, "a shape of the case", spheres)


def grain(case: Case, material: str, shape_name: str, sieve_size_m: float = 1.0) -> Grain[float]:
    """Return a grain, from the names of its material and shape; its numbers are those of no plan."""
    density_kg_per_m3 = case.materials[material].density_kg_per_m3
    return Grain(sieve_size_m, density_kg_per_m3, 0, 0, ShapeTable.of([shape(case, shape_name)]))


def planned(case: Case, material: str, shape_name: str) -> Grain[float]:
    """Return a grain of size 1 with the numbers of its material and shape in the case's plan."""
    names = [each.name for each in shapes(case)]
    numbers = {"material": material_numbers(case)[material], "shape": names.index(shape_name)}
    return replace(grain(case, material, shape_name), **numbers, shapes=ShapeTable.of(shapes(case)))


def grains_by_material(case: Case) -> dict[str, list[Grain[float]]]:
    """Return single particles, and the smallest and the largest of each source and of carried particles of
    one kind, by the names of their materials."""
    found: dict[str, list[Grain[float]]] = {}

    def add(material: str, shape_name: str, *sizes_m: float) -> None:
        if material not in case.materials:
            return  # which is a problem of its own
        one = grain(case, material, shape_name)
        found.setdefault(material, []).extend(map(one.resized, sizes_m))

    for row in case.bed.particles.values():
        add(row.material, row.shape, row.sieve_size_m)
    for source in case.bed.sources:
        rows = classes(source)
        limits_m = min(row.smallest_m for row in rows), max(row.largest_m for row in rows)
        add(source.material, source.shape, *limits_m)
    if (carried := case.bed.carried) is not None:
        own = carried.grains
        for number, kind in np.unique(np.column_stack([own.material, own.shape]), axis=0):
            sizes_m = own.sieve_size_m[(own.material == number) & (own.shape == kind)]
            limits_m = float(sizes_m.min()), float(sizes_m.max())
            add(carried.materials[number], str(own.shapes.name[kind]), *limits_m)
    return found


def smallest_grains(case: Case) -> dict[str, Grain[float]]:
    """Return the grain of the smallest contact radius of each material that has particles, by its name."""
    found = grains_by_material(case)
    return {name: min(grains, key=lambda each: each.contact_radius_m) for name, grains in found.items()}


def largest_grains(case: Case) -> dict[str, Grain[float]]:
    """Return the grain of the largest bounding radius of each material that has particles, by its name."""
    found = grains_by_material(case)
    return {name: max(grains, key=lambda each: each.bounding_radius_m) for name, grains in found.items()}


def sieve_sizes_m(case: Case) -> tuple[float, float]:
    """Return the smallest and the largest sieve size of all particles that the case has or feeds."""
    sizes_m = [each.sieve_size_m for grains in grains_by_material(case).values() for each in grains]
    return min(sizes_m), max(sizes_m)


def largest_length_m(case: Case) -> float:
    """Return twice the largest bounding radius of all particles that the case has or feeds."""
    return 2.0 * max(each.bounding_radius_m for each in largest_grains(case).values())
