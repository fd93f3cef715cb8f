"""Materials, their contacts, adhesion, and the sizes of particles."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations_with_replacement

from orchestrator.case.bed.adhesion import adhesion_law, sticky_contacts, surface_materials
from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.bed.size_distribution import Source, classes, faults, finer_share
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.particle_records import LARGEST_CARRIED_OVERLAP
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2, sphere_volume_m3
from orchestrator.preflight.scene.contacts import compute_softness
from orchestrator.preflight.scene.scene import scene


def complete_materials(case: Case) -> Iterator[CaseProblem]:
    """A law for panels; elastic constants for what particles touch."""
    for name, panel in case.screen.panels.items():
        material = case.materials.get(panel.material)
        if material is not None and material.hyperelastic is None:
            key: Key = ("materials", panel.material, "hyperelastic")
            yield CaseProblem(key, f"missing: panel {name} is made of it")
    for name, material in case.materials.items():
        if material.hyperelastic is None:
            for field in ("youngs_modulus_Pa", "poisson_ratio"):
                if getattr(material, field) is None:
                    yield CaseProblem(("materials", name, field), "missing")
        elif material.hyperelastic.c10_Pa + material.hyperelastic.c01_Pa == 0:
            key = ("materials", name, "hyperelastic", "c10_Pa")
            yield CaseProblem(key, "C10 and C01 are both zero: no stiffness")


def complete_contacts(case: Case) -> Iterator[CaseProblem]:
    """Every pair that can meet, once."""
    given: set[frozenset[str]] = set()
    for number, contact in enumerate(case.contacts):
        pair = frozenset(contact.between)
        if pair in given:
            named = " and ".join(contact.between)
            yield CaseProblem(("contacts", number, "between"), f"{named} are given twice")
        given.add(pair)
    bed = case.bed
    grains = {row.material for row in (*bed.particles.values(), *bed.sources)}
    others = {panel.material for panel in case.screen.panels.values()}
    others |= {surface.material for surface in case.screen.surfaces.values()}
    pairs = list(combinations_with_replacement(sorted(grains), 2))
    pairs += [(grain, other) for grain in sorted(grains) for other in sorted(others - grains)]
    for one, two in pairs:
        if frozenset((one, two)) not in given:
            hint = f'give [[contacts]] with between = ["{one}", "{two}"]'
            yield CaseProblem(("contacts",), f"{one} and {two} can meet but have no contact", hint)


def worn_surfaces(case: Case) -> Iterator[CaseProblem]:
    """Specific wear needs a surface that is worn, and particles that do it."""
    bed, screen = case.bed, case.screen
    grains = {row.material for row in (*bed.particles.values(), *bed.sources)}
    surfaces = {panel.material for panel in screen.panels.values()}
    surfaces |= {surface.material for surface in screen.surfaces.values()}
    for number, contact in enumerate(case.contacts):
        one, two = contact.between
        meets = (one in grains and two in surfaces) or (two in grains and one in surfaces)
        if contact.specific_wear_m3_per_N_m and not meets:
            what = f"particles of {one} or {two} never meet a panel or surface of the other"
            hint = "it belongs to the contact of a particle's material with a surface's"
            yield CaseProblem(("contacts", number, "specific_wear_m3_per_N_m"), what, hint)


def boxes_and_sizes(case: Case) -> Iterator[CaseProblem]:
    """Corners in order, sizes in order, shares that add up to 1."""
    boxes: list[tuple[Key, tuple[tuple[float, ...], tuple[float, ...]]]] = [(("domain_m",), case.domain_m)]
    for kind, rows in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds)):
        for name, row in rows.items():
            key: Key = ("bed", kind, name)
            boxes.append(((*key, "box_m"), row.box_m))
            for number, size in enumerate(row.sizes):
                if size.smallest_m > size.largest_m:
                    what = f"is larger than largest_m = {size.largest_m:g}"
                    yield CaseProblem((*key, "sizes", number, "smallest_m"), what)
            for field, what, hint in faults(row):
                yield CaseProblem((*key, field), what, hint)
            total = sum(size.mass_fraction for size in row.sizes)
            if row.sizes and abs(total - 1) > 1e-6:
                yield CaseProblem((*key, "sizes"), f"the mass fractions add up to {total:g}, not to 1")
    for key, (low, high) in boxes:
        if not all(a < b for a, b in zip(low, high, strict=True)):
            hint = "give the lowest corner, then the highest"
            yield CaseProblem(key, f"{list(low)} is not below {list(high)} in every direction", hint)


def fines(case: Case) -> Iterator[str]:
    """A warning with numbers for each source that does without its fines."""
    sources: list[tuple[str, Source]] = [*case.bed.blocks.items(), *case.bed.feeds.items()]
    for name, source in sources:
        if source.smallest_fed_m is not None and (finer := finer_share(source)) > 0:
            fate = {"leave-out": "left out", "next-class": "made of the next class"}[source.finer]
            yield (
                f"{name}: {finer:.1%} of the mass is finer than smallest_fed_m = "
                f"{source.smallest_fed_m:g} m and {fate}"
            )


def larger_than_the_box(case: Case) -> Iterator[CaseProblem]:
    """Sources whose largest particles stick out of their box."""
    for kind, rows in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds)):
        for name, row in rows.items():
            largest_m = max(size.largest_m for size in classes(row))
            side_m = min(b - a for a, b in zip(*row.box_m, strict=True))
            if largest_m > side_m:
                what = f"particles of {largest_m:g} m do not fit in {side_m:.4g} m"
                yield CaseProblem(("bed", kind, name, "box_m"), what, "enlarge the box")


FULLEST = 0.38  # share of a box that spheres at random places can fill (bed/packing.py)


def crowded_blocks(case: Case) -> Iterator[CaseProblem]:
    """Boxes that could not hold their particles even if all had the smallest size: found here
    before anybody tries to place them."""
    for name, block in case.bed.blocks.items():
        smallest_m = min(size.smallest_m for size in classes(block))
        least_m3 = block.count * sphere_volume_m3(smallest_m)
        box_m3 = math.prod(b - a for a, b in zip(*block.box_m, strict=True))
        if least_m3 > FULLEST * box_m3:
            what = f"{block.count} particles fill {least_m3 / box_m3:.3g} times the box or more"
            hint = f"random places end at {FULLEST:g}; enlarge the box"
            yield CaseProblem(("bed", "blocks", name, "count"), what, hint)


WIDEST_NECK = 0.5  # of the smaller radius; JKR's paraboloids have no flanks
STRONGEST_PULL = 1e6  # weights of the smallest particle


def works_of_adhesion(case: Case) -> Iterator[CaseProblem]:
    """A law that is asked for needs work, and each law its own keys."""
    asked = case.particles.adhesion not in (None, "none")
    if asked and not any(contact.work_of_adhesion_J_per_m2 for contact in case.contacts):
        what = f'"{case.particles.adhesion}" is asked for, but every work of adhesion is zero'
        hint = 'give contacts a work_of_adhesion_J_per_m2, or take "none"'
        yield CaseProblem(("particles", "adhesion"), what, hint)
    if case.particles.sjkr_diameter_m is not None and adhesion_law(case) != "sjkr":
        key: Key = ("particles", "sjkr_diameter_m")
        yield CaseProblem(key, 'has no meaning without particles.adhesion = "sjkr"')


def adhesive_contacts(case: Case) -> Iterator[CaseProblem]:
    """Works that are absurd for the particles' size and stiffness."""
    for pair in sticky_contacts(case):
        key: Key = ("contacts", pair.contact, "work_of_adhesion_J_per_m2")
        who = f"the smallest particles ({2e3 * pair.radius_m:.3g} mm)"
        neck = pair.neck_m / pair.radius_m
        if neck > WIDEST_NECK:
            what = f"{who} would stick with a neck as wide as {neck:.2g} of their radius"
            hint = f"up to {WIDEST_NECK:g} the law holds: less work, or stiffer contacts"
            yield CaseProblem(key, what, hint)
        pull = pair.pull_off_N / (pair.reduced_kg * STANDARD_GRAVITY_M_PER_S2)
        if pull > STRONGEST_PULL:
            what = f"{who} would stick with {pull:.2g} times their weight"
            yield CaseProblem(key, what, "is the unit right? Surface energies are given in mJ/m2, too")


def sjkr_materials(case: Case) -> Iterator[CaseProblem]:
    """``sjkr`` has one strength per pair of materials, which depends on the curvature."""
    if adhesion_law(case) != "sjkr":
        return
    for name in sorted(surface_materials(case) & set(smallest_diameters_m(case))):
        what = f"particles and surfaces are both made of {name}; sjkr cannot tell them apart"
        hint = "give the surface a material of its own with the same values"
        yield CaseProblem(("materials", name), what, hint)


def too_soft(case: Case) -> Iterator[str]:
    """Warns of contacts in which particles are expected to sink deeper than contact laws hold."""
    if not has_particles(case):
        return
    found = compute_softness(scene(case))
    if found.overlap > LARGEST_CARRIED_OVERLAP:
        said = found.in_words(LARGEST_CARRIED_OVERLAP)
        yield (
            f"particles are expected to sink into what they meet by {found.overlap:.2g} of a "
            f"radius ({said}): beyond {LARGEST_CARRIED_OVERLAP:g} no contact law holds, at 1 they "
            "go through panels; raise particles.largest_youngs_modulus_Pa"
        )
