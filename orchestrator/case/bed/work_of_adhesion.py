"""The works of adhesion that a case gives by Bond numbers or by classes of moisture.

The Bond number Bo of a contact is the pull-off force over the weight of a grain.  JKR's pull-off force
is 3/2 pi w R*, so that  w = Bo m g / (3/2 pi R*)  for a grain of mass m; R* is the reduced radius of the
pair.  docs/theory/adhesion.md has the closed forms, the classes of moisture and their sources.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import Any

from orchestrator.case.bed.grains import grain
from orchestrator.case.bed.size_distribution import (
    classes_of_grains,
    faults,
    given_classes,
    mean_mass_kg,
    median_size_m,
    size_class,
)
from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.file.plausible import wrong_sizes
from orchestrator.case.tables.bed import SizeClass
from orchestrator.case.tables.case import WORK_OF_ADHESION, Case, Contact
from orchestrator.ports.grains import Grain
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2

WATER_N_PER_M = 0.072
"""Surface tension of clean water at 25 degrees Celsius."""
LIQUID_BRIDGE_J_PER_M2 = 8 / 3 * WATER_N_PER_M
"""Work of adhesion at which JKR's pull-off force is that of a small bridge of water that wets both bodies.

The bridge pulls with 4 pi gamma R*, for two spheres as for a sphere and a plane (Fisher, R. A., Journal
of Agricultural Science 16, 1926, 492-505), and JKR's contact with 3/2 pi w R*.
"""
MOISTURES_J_PER_M2 = {
    "dry": 0.0,
    "moist": LIQUID_BRIDGE_J_PER_M2,
    "wet": 3 * LIQUID_BRIDGE_J_PER_M2,
    "sticky": 10 * LIQUID_BRIDGE_J_PER_M2,
}
"""Work of adhesion of each class of moisture."""
UNSURE = 3.0
"""The factor, up and down, within which the work of adhesion of a class is uncertain."""
BASES = {
    "dry": ("assumption", "nothing sticks"),
    "moist": (
        "Fisher, R. A., Journal of Agricultural Science 16, 1926, 492-505",
        "theory of single bridges of water between smooth grains, an upper bound for such bridges",
    ),
    "wet": (
        "Newitt, D. M., Conway-Jones, J. M., Transactions of the Institution of Chemical Engineers 36, 1958, "
        "422-442; Mitarai, N., Nori, F., Advances in Physics 55, 2006, 1-45, doi 10.1080/00018730600626065",
        "three times moist, as the strength of moist granulates rises to the capillary state",
    ),
    "sticky": ("assumption, no single source", "ten times moist, for water with clay or fines"),
}
"""The source of each class's work of adhesion, and a note; docs/theory/adhesion.md has more."""


def resolve_works_of_adhesion(case: Case, grains: Mapping[str, Grain[float]]) -> Case:
    """Return the case with a work of adhesion in place of each Bond number and each class of moisture.

    Both stand for a pull-off force, which softened contacts then keep unless the case says otherwise.
    ``grains`` has a typical grain of each material of particles.

    A Bond number stays as it is if no particle has a material of the pair, or if later checks refuse
    the pair's materials or sizes.  Raises CaseError with every contact that gives its adhesion in two
    ways; if the case has sizes that must be mistakes, CaseError has these alone.
    """
    if not any(_ways(row) or row.bond_diameter_m is not None for row in case.contacts):
        return case
    if problems := [*_contradictions(case)] or [*wrong_sizes(case)]:
        raise CaseError(problems)
    contacts = tuple(_resolve(row, grains) for row in case.contacts)
    particles = case.particles
    if particles.softened_adhesion is None:
        particles = particles.model_copy(update={"softened_adhesion": "pull-off"})
    return case.model_copy(update={"contacts": contacts, "particles": particles})


def move_to_given_key(problem: CaseProblem, contacts: Any) -> CaseProblem:
    """Return a problem of a resolved work of adhesion at the key that gave it; any other unchanged.

    ``contacts`` is the list of contacts as the user gave it.
    """
    match problem.key:
        case ("contacts", int(number), key) if key == WORK_OF_ADHESION and number < len(contacts):
            given: Mapping[str, Any] = contacts[number]
            for way in ("bond_number", "moisture"):
                if way in given and key not in given:
                    what = f"as a work of adhesion in J/m2, {problem.what}"
                    return replace(problem, key=("contacts", number, way), what=what)
    return problem


def _ways(row: Contact) -> list[str]:
    """Return the keys, other than the work itself, by which a contact gives its work of adhesion."""
    return [key for key in ("bond_number", "moisture") if getattr(row, key) is not None]


def _contradictions(case: Case) -> Iterator[CaseProblem]:
    """Yield a problem for each contact that gives its adhesion twice, or a grain without a Bond number."""
    for number, row in enumerate(case.contacts):
        key: Key = ("contacts", number)
        ways = _ways(row)
        if WORK_OF_ADHESION in row.model_fields_set:
            ways = [WORK_OF_ADHESION, *ways]
        if len(ways) > 1:
            hint = f"give {WORK_OF_ADHESION}, bond_number or moisture, and only one of them"
            yield CaseProblem((*key, ways[1]), f"contradicts {ways[0]}", hint)
        elif row.bond_diameter_m is not None and row.bond_number is None:
            yield CaseProblem(
                (*key, "bond_diameter_m"), "has no effect without bond_number", "add that, or remove this key"
            )


def _resolve(row: Contact, grains: Mapping[str, Grain[float]]) -> Contact:
    """Return a contact with its work of adhesion; unchanged if it has a Bond number but no grain."""
    if row.moisture is None:
        work_J_per_m2 = _work_of_bond_number(row, grains)
    else:
        work_J_per_m2 = MOISTURES_J_PER_M2[row.moisture]
    if work_J_per_m2 is None:
        return row
    ways = dict.fromkeys(("bond_number", "bond_diameter_m", "moisture"))
    return row.model_copy(update={**ways, WORK_OF_ADHESION: work_J_per_m2})


def _work_of_bond_number(row: Contact, grains: Mapping[str, Grain[float]]) -> float | None:
    """Return the work of adhesion in J/m2 of a Bond number; None without one, or if the pair has no grain.

    Of two grains of different materials, the lighter one is weighed.
    """
    known = [grains[name] for name in row.between if name in grains]
    if row.bond_number is None or not known:
        return None
    if row.bond_diameter_m is not None:
        known = [each.resized(row.bond_diameter_m) for each in known]
    weight_N = STANDARD_GRAVITY_M_PER_S2 * min(each.mass_kg for each in known)
    reduced_m = 1 / sum(1 / each.contact_radius_m for each in known)
    return row.bond_number * weight_N / (1.5 * math.pi * reduced_m)


def typical_grains(described: Case, case: Case) -> dict[str, Grain[float]]:
    """Return a grain of the median sieve size by mass of each material, by name.

    Feeds and blocks are those of the case as it is ``described``; where a material has none, its grains are
    the particles with which the ``case`` really begins, of its own or taken over.  Materials that do not
    exist, and those whose sizes are not valid, are left out.
    """
    grains = {}
    for name in case.materials:
        with suppress(ValueError):  # the check of sizes reports these classes
            if sizes := _source_grains(described, name) or _first_grains(case, name):
                grains[name] = grain(case, name, _shape(described, case, name), median_size_m(sizes))
    return grains


def _shape(described: Case, case: Case, name: str) -> str:
    """Return the shape of the first of a material's grains."""
    for row in (*described.bed.sources, *case.bed.particles.values()):
        if row.material == name:
            return row.shape
    assert case.bed.carried is not None, "a material with sizes has grains"
    return str(case.bed.carried.of_material(name).shape_names[0])


def _source_grains(case: Case, name: str) -> list[SizeClass]:
    """Return the size classes of a material's feeds, weighted by their rates, else of its blocks.

    Particles too fine to be computed (``smallest_fed_m``) count, so that the result is the same at every
    level.
    """
    if any(True for row in case.bed.sources if row.material == name for _ in faults(row)):
        return []
    parts: list[tuple[list[SizeClass], float]]
    if feeds := [row for row in case.bed.feeds.values() if row.material == name]:
        parts = [(given_classes(row), row.rate_kg_per_s) for row in feeds]
    else:
        blocks = [row for row in case.bed.blocks.values() if row.material == name]
        parts = [
            (sizes := given_classes(row), row.count * mean_mass_kg(sizes, grain(case, name, row.shape)))
            for row in blocks
        ]
    return [size.times(mass, "mass_fraction") for sizes, mass in parts for size in sizes]


def _first_grains(case: Case, name: str) -> list[SizeClass]:
    """Return the sizes, by mass, of the particles of a material with which a case begins."""
    rows = [row for row in case.bed.particles.values() if row.material == name]
    own = [grain(case, name, row.shape, row.sieve_size_m) for row in rows]
    sizes = [size_class(each.sieve_size_m, each.sieve_size_m, each.mass_kg) for each in own]
    if case.bed.carried is not None and name in case.bed.carried.materials:
        k = case.particles.coarse_graining
        coarse = classes_of_grains(case.bed.carried.of_material(name))
        sizes += [row.times(1 / k, "smallest_m", "largest_m") for row in coarse]
    return sizes
