"""The checks of the bed: materials, contacts, adhesion, sizes of particles, feeds, exits and slices."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import combinations, combinations_with_replacement, pairwise, product
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from orchestrator.case import solvers
from orchestrator.case.bed.adhesion import adhesion_law, pull_offs, sticky_contacts, surface_materials
from orchestrator.case.bed.feed import RateFeed, are_apart
from orchestrator.case.bed.grains import grain, grains_by_material, largest_length_m, shapes, smallest_grains
from orchestrator.case.bed.size_distribution import (
    classes,
    counts,
    faults,
    finer_share,
    mean_cube_m3,
    mean_mass_kg,
    sample_of,
    shares,
)
from orchestrator.case.bed.sources import batch_s, initial_particles, inlets
from orchestrator.case.deck.panels import single_panels, to_world, walls
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.file.layers import LARGEST_BYTES, Layers
from orchestrator.case.file.slice import ENOUGH_DIAMETERS, bounds_m, is_beside, period_m, share
from orchestrator.case.materials.library import no_grains, rolling_friction_of, slug
from orchestrator.case.tables.bed import SizeClass
from orchestrator.case.tables.case import Case, Contact, has_particles
from orchestrator.case.tables.deck import Apertures
from orchestrator.ports import Array
from orchestrator.ports.particle_records import largest_overlap
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.preflight.checks.names import rows
from orchestrator.preflight.scene.contacts import compute_softness, rolling_on_deck
from orchestrator.preflight.scene.scene import Scene, scene

STIFFEST_PA = 1e13  # beyond it units are wrong, which is said of the constants
SOURCES, RATE = ("bed.blocks", "bed.feeds"), "rate_kg_per_s"
LOWEST_FIRST = "give the lowest corner, then the highest"


def written_size(case: Case) -> Iterator[CaseProblem]:
    """Check that a run can read its own case again, which is written with all defaults."""
    text = tomli_w.dumps(case.original.model_dump(mode="json", exclude_none=True))
    if (size := len(text.encode())) > LARGEST_BYTES:
        what = f"has {size} bytes with all defaults, and a file may have {LARGEST_BYTES}"
        yield CaseProblem(
            (), what, "write many particles into a file of their own: bed.table", kind="out-of-range"
        )


def complete_materials(case: Case) -> Iterator[CaseProblem]:
    """Check that panels have a material law, other materials elastic constants, and no surface a shape."""
    for name, panel in case.screen.panels.items():
        material = case.materials.get(panel.material)
        if material is not None and material.hyperelastic is None:
            key: Key = ("materials", panel.material, "hyperelastic")
            yield CaseProblem(key, f"missing: panel {name} is made of it", kind="missing")
    surfaces = surface_materials(case) - _grains(case)
    for key, material in rows(case, "materials"):
        if material.shape is not None and key[-1] in surfaces:
            yield CaseProblem((*key, "shape"), "a surface is made of it, and only grains have a shape")
        if material.hyperelastic is None:
            for field in ("youngs_modulus_Pa", "poisson_ratio"):
                if getattr(material, field) is None:
                    yield CaseProblem((*key, field), "missing", kind="missing")
        elif (shear_Pa := 2 * (material.hyperelastic.c10_Pa + material.hyperelastic.c01_Pa)) == 0:
            what = "C10 and C01 are both zero: no stiffness"
            yield CaseProblem((*key, "hyperelastic", "c10_Pa"), what, kind="out-of-range")
        elif 3 * material.hyperelastic.bulk_modulus_Pa < 2 * shear_Pa < STIFFEST_PA:
            what = f"is below two thirds of the shear modulus, {shear_Pa:.3g} Pa: Poisson's ratio is negative"
            yield CaseProblem((*key, "hyperelastic", "bulk_modulus_Pa"), what, kind="out-of-range")


def _grains(case: Case) -> set[str]:
    carried = case.bed.carried.materials if case.bed.carried is not None else ()
    return {row.material for row in (*case.bed.particles.values(), *case.bed.sources)} | {*carried}


def growing_impacts(case: Case) -> Iterator[CaseProblem]:
    """Check that a restitution over speed has points, and that they go from slow to fast impacts."""
    for key, contact in rows(case, "contacts"):
        if not contact.restitutions:
            hint = "give a number, or points of impact_m_per_s and restitution"
            yield CaseProblem((*key, "restitution"), "has no points", hint, kind="missing")
        for number, (slower, point) in enumerate(pairwise(contact.rebound), start=1):
            if point.impact_m_per_s <= slower.impact_m_per_s:
                at: Key = (*key, "restitution", number, "impact_m_per_s")
                what = f"{point.impact_m_per_s:g} comes after {slower.impact_m_per_s:g}"
                yield CaseProblem(at, what, "give points from slow to fast impacts, each speed once")
                break


def complete_contacts(case: Case) -> Iterator[CaseProblem]:
    """Check that every pair of materials that can meet has one contact.

    Check as well that specific wear is given only for contacts of particles with surfaces.  Materials that do
    not exist are the matter of another check.
    """
    given: set[frozenset[str]] = set()
    grains, surfaces = _grains(case), surface_materials(case)
    for key, contact in rows(case, "contacts"):
        one, two = contact.between
        if frozenset(contact.between) in given:
            yield CaseProblem((*key, "between"), f"{one} and {two} are given twice")
        given.add(frozenset(contact.between))
        meets = (one in grains and two in surfaces) or (two in grains and one in surfaces)
        if contact.specific_wear_m3_per_N_m and not meets:
            what = f"particles of {one} or {two} never meet a panel or surface of the other"
            hint = "it belongs to the contact of a particle's material with a surface's"
            yield CaseProblem((*key, "specific_wear_m3_per_N_m"), what, hint)
    pairs = [
        *combinations_with_replacement(sorted(grains), 2),
        *product(sorted(grains), sorted(surfaces - grains)),
    ]
    for one, two in pairs:
        if frozenset((one, two)) not in given and {one, two} <= case.materials.keys():
            hint = f'give [[contacts]] with between = ["{one}", "{two}"]'
            if (name := no_grains(one)) is not None:
                hint = f"{name} is not a grain of the library; {hint}"
            yield CaseProblem(
                ("contacts",), f"{one} and {two} can meet but have no contact", hint, kind="missing"
            )


def boxes_and_sizes(case: Case) -> Iterator[CaseProblem]:
    """Check that corners of boxes and limits of sizes are in order, and that mass fractions add up to 1."""
    boxes: list[tuple[Key, tuple[tuple[float, ...], tuple[float, ...]]]] = [(("domain_m",), case.domain_m)]
    boxes += [((*key, "box_m"), bulk.box_m) for key, bulk in rows(case, "bulk")]
    for key, source in (row for path in SOURCES for row in rows(case, path)):
        boxes.append(((*key, "box_m"), source.box_m))
        for number, size in enumerate(source.sizes):
            if size.smallest_m > size.largest_m:
                what = f"is larger than largest_m = {size.largest_m:g}"
                yield CaseProblem((*key, "sizes", number, "smallest_m"), what, kind="out-of-range")
        for field, what, hint in faults(source):
            yield CaseProblem((*key, field), what, hint)
        total = sum(size.mass_fraction for size in source.sizes)
        if source.sizes and abs(total - 1) > 1e-6:
            yield CaseProblem(
                (*key, "sizes"), f"the mass fractions add up to {total:g}, not to 1", kind="out-of-range"
            )
    for key, (low, high) in boxes:
        if not all(a < b for a, b in zip(low, high, strict=True)):
            what = f"{list(low)} is not below {list(high)} in every direction"
            yield CaseProblem(key, what, LOWEST_FIRST, kind="out-of-range")


def fines(case: Case, fate: str) -> Iterator[str]:
    """Yield lines with numbers for each source whose mass that is not computed has this fate, "leave-out" or
    "next-class"."""
    done = {"leave-out": "left out", "next-class": "made of the next class"}[fate]
    for key, source in (row for path in SOURCES for row in rows(case, path)):
        if source.finer != fate:
            continue
        if source.smallest_fed_m is not None and (finer := finer_share(source)) > 0:
            yield (
                f"{key[-1]}: the {finer:.1%} of the mass finer than smallest_fed_m = "
                f"{source.smallest_fed_m:g} m is {done}"
            )
        if (sample := sample_of(source)) is not None:
            rest = sample.share - sample.computed
            yield (
                f"{key[-1]}: {sample.in_words}; the others ({rest:.1%} of the mass, "
                f"{rest * source.rate_kg_per_s:.3g} kg/s) are {done}"
            )


def reduced_feeds(given: Mapping[str, Any], layers: Layers) -> Iterator[str]:
    """Yield a warning for each feed that the level reduces below that of ``given``, the case's own tables."""
    feeds = layers.merged.get("bed", {}).get("feeds", {})
    for name, case_kg_per_s in rates_above_the_level(given, layers).items():
        kg_per_s, by = feeds[name][RATE], layers.source(("bed", "feeds", name, RATE))
        yield (
            f"{name}: {by} feeds {kg_per_s / case_kg_per_s:.0%} of the case's throughput, "
            f"{3.6 * kg_per_s:.3g} of {3.6 * case_kg_per_s:.3g} t/h: a thinner bed moves faster and "
            "separates differently"
        )


def rates_above_the_level(given: Mapping[str, Any], layers: Layers) -> dict[str, float]:
    """Return the rate in kg/s of each feed, in the case's own tables ``given``, that its level reduces."""
    rates = {name: feed.get(RATE) for name, feed in given.get("bed", {}).get("feeds", {}).items()}
    return {
        name: case_kg_per_s
        for name, feed in layers.merged.get("bed", {}).get("feeds", {}).items()
        if (case_kg_per_s := rates.get(name))
        and feed.get(RATE)
        and feed[RATE] < case_kg_per_s
        and Path(layers.source(("bed", "feeds", name, RATE))).parent.name == "levels"
    }


def fitting_bed(case: Case) -> Iterator[CaseProblem]:
    """Check that particles taken over have materials and the coarse graining of the case."""
    if (carried := case.bed.carried) is not None:
        key: Key = ("bed", "from_run" if case.bed.from_run is not None else "table")
        yield from (CaseProblem(key, what, hint) for what, hint in carried.unfit)


NARROW, ENOUGH_GRAINS = 0.75, 50


def narrow_beds(case: Case) -> Iterator[str]:
    """Yield a warning for carried particles that lie on a part of the width only, as those of a slice do."""
    carried, panels = case.bed.carried, single_panels(case)
    if carried is None or len(carried) < ENOUGH_GRAINS or not panels:
        return
    width_m = case.slice.width_m if case.slice is not None else panels[0].rectangle.width_m
    extent_m = float(np.ptp(carried.position_m[:, 1]) + carried.grains.equivalent_diameter_m.mean())
    if extent_m < NARROW * width_m:
        yield (
            f"the bed from {carried.source} lies on {1e3 * extent_m:.4g} of {1e3 * width_m:.4g} mm of the "
            "width, like that of a slice: it loads only a strip of the deck"
        )


SAME_DENSITY = 1e-6  # relative


def other_densities(case: Case) -> Iterator[str]:
    """Yield a warning for each material whose particles had another density in the run before."""
    carried = case.bed.carried
    for name in carried.materials if carried is not None else ():
        assert carried is not None
        before = float(carried.of_material(name).density_kg_per_m3.mean())
        now = case.materials[name].density_kg_per_m3
        if abs(before - now) > SAME_DENSITY * now:  # never true for a table, which has none
            yield (
                f"the particles of {name} from {carried.source} had {before:g} kg/m3 there, and have {now:g} "
                "kg/m3 here: their masses and momenta change"
            )


def clumps(case: Case) -> Iterator[CaseProblem]:
    """Check that the particles' solver can take shapes of several spheres, if there are any."""
    solver = case.particles.adapter
    made_of_several = [shape.name for shape in shapes(case) if len(shape.spheres) > 1]
    if solver is None or solver.clumps or not made_of_several:
        return
    others = solvers.names_able_to("particles", lambda able: able.clumps)
    hint = f"take particles.solver = {others}" if others else "take spheres"
    for key, row in (row for path in ("bed.particles", *SOURCES) for row in rows(case, path)):
        if row.shape in made_of_several:
            what = f'{case.particles.solver} takes no grains of several spheres, such as "{row.shape}"'
            yield CaseProblem((*key, "shape"), what, hint)


FULLEST = 0.38  # largest share of a box that spheres at random places can fill (bed/packing.py)


def crowded_boxes(case: Case) -> Iterator[CaseProblem]:
    """Check that the boxes of sources are wide enough for the largest particles.

    Check as well, before any particle is placed, that a block's box could hold its particles if all
    had the smallest size.
    """
    for key, source in (row for path in SOURCES for row in rows(case, path)):
        sides_m = [b - a for a, b in zip(*source.box_m, strict=True)]
        length = 2 * grain(case, source.material, source.shape).bounding_radius_m  # over the sieve size
        largest_m = length * max(size.largest_m for size in classes(source))
        if largest_m > min(sides_m):
            what = f"particles of {largest_m:g} m do not fit in {min(sides_m):.4g} m"
            yield CaseProblem((*key, "box_m"), what, "enlarge the box", kind="out-of-range")
        if key[1] == "blocks":
            smallest_m = length * min(size.smallest_m for size in classes(source))
            filled = source.count * math.pi / 6 * smallest_m**3 / math.prod(sides_m)
            if filled > FULLEST:
                what = f"{source.count} particles have at least {filled:.3g} times the volume of the box"
                hint = f"random packing reaches {FULLEST:g} of it; enlarge the box or lower count"
                yield CaseProblem((*key, "count"), what, hint, kind="out-of-range")


WIDEST_NECK = 0.5  # over the smaller radius; JKR's theory takes spheres for paraboloids
OTHER_PULL = 1.5  # factor by which a pull-off force may differ from what the case asks for
STRONGEST_PULL = 1e6  # over the weight of the smallest particle


def works_of_adhesion(case: Case) -> Iterator[CaseProblem]:
    """Check that a law of adhesion has a work of adhesion, and that keys of ``sjkr`` come with that law."""
    asked = case.particles.adhesion
    if asked not in (None, "none") and not any(row.work_of_adhesion_J_per_m2 for row in case.contacts):
        what = f'"{asked}" is asked for, but every work of adhesion is zero'
        hint = 'give contacts a work_of_adhesion_J_per_m2 or a bond_number, or take "none"'
        yield CaseProblem(("particles", "adhesion"), what, hint)
    if case.particles.sjkr_diameter_m is not None and adhesion_law(case) != "sjkr":
        what = 'has no effect without particles.adhesion = "sjkr"'
        yield CaseProblem(("particles", "sjkr_diameter_m"), what, "add that, or remove this key")


def adhesive_contacts(case: Case) -> Iterator[CaseProblem]:
    """Check that works of adhesion are plausible for the particles' size and stiffness.

    Check as well that no surface shares a material with particles under ``sjkr``, whose strength for a
    pair of materials depends on the curvature.
    """
    for pair in sticky_contacts(case):
        key: Key = ("contacts", pair.contact, "work_of_adhesion_J_per_m2")
        who = f"the smallest particles ({2e3 * pair.radius_m:.3g} mm)"
        neck = pair.neck_m / pair.radius_m
        if neck > WIDEST_NECK:
            what = f"at the contacts of {who} the neck would be {neck:.2g} of the radius"
            hint = f"the law holds up to {WIDEST_NECK:g}: give less work of adhesion, or stiffer contacts"
            yield CaseProblem(key, what, hint, kind="out-of-range")
        pull = pair.pull_off_N / (pair.reduced_kg * STANDARD_GRAVITY_M_PER_S2)
        if pull > STRONGEST_PULL:
            what = f"{who} would stick with {pull:.2g} times their weight"
            yield CaseProblem(
                key, what, "is the unit right? Surface energies are often given in mJ/m2", kind="out-of-range"
            )
    shared = surface_materials(case) & set(smallest_grains(case))
    for name in sorted(shared) if adhesion_law(case) == "sjkr" else ():
        what = f"particles and surfaces are both made of {name}; sjkr cannot tell them apart"
        hint = "give the surface a material of its own with the same values"
        yield CaseProblem(("materials", name), what, hint)


def doubtful_run(case: Case) -> Iterator[str]:
    """Yield a warning if the bed is taken from a run that cannot be trusted."""
    if case.bed.carried is not None and case.bed.carried.doubt:
        yield f"bed.from_run: {case.bed.carried.doubt}; its bed is taken as it is"


def other_adhesion(case: Case) -> Iterator[str]:
    """Yield a warning for each pair whose pull-off force in the run is far from what the case asks for."""
    for pair in pull_offs(case):
        if not 1 / OTHER_PULL <= pair.run / pair.asked <= OTHER_PULL:
            law = adhesion_law(case)
            help_ = 'give particles.sjkr_diameter_m, or take particles.adhesion = "jkr"'
            if law == "jkr":
                help_ = 'particles.softened_adhesion = "pull-off" keeps what was asked for'
            yield f"contacts.{pair.contact}: {pair.in_words}; {help_}"


def soft_contacts(case: Case) -> Iterator[str]:
    """Yield a warning if particles are expected to overlap more than contact laws allow."""
    if not has_particles(case):
        return
    soft = compute_softness(scene(case))
    limit = largest_overlap(soft.softened)
    if soft.overlap > limit:
        why = soft.in_words(limit)
        help_ = "; raise particles.largest_youngs_modulus_Pa" if soft.softened else ""
        yield (
            f"particles are expected to sink into what they meet by {soft.overlap:.2g} of a "
            f"radius ({why}): beyond {limit:g} no contact law holds, at 1 they go through panels{help_}"
        )


OTHER_MASS = 0.02  # of a block: a smaller change is not told
OTHER_SHARE = 0.05  # of the mass of a block or a feed: a smaller share of other sizes is not told


def rounded_counts(case: Case) -> Iterator[str]:
    """Yield a warning for each block whose mass or sizes change because its particles are few.

    They are whole numbers of each size class, of coarse particles, and of those in a slice.
    """
    part = share(case.whole_machine) / case.particles.coarse_graining**3
    for name, row in case.bed.blocks.items():
        exact = case.original.bed.blocks[name].count * part
        change = row.count / exact - 1
        if abs(change) > OTHER_MASS:
            yield (
                f"bed.blocks.{name}: {exact:.3g} of its particles would have its mass here, and {row.count} "
                f"are computed: its mass changes by {100 * change:+.2g} %"
            )
        sizes = classes(row)
        wanted = shares(sizes)
        cube_m3 = mean_cube_m3(sizes)
        given = counts(sizes, row.count) * cube_m3 / (counts(sizes, row.count) @ cube_m3)
        other = np.round(np.abs(given - wanted), 6)
        if other.sum() / 2 > OTHER_SHARE:
            worst = max(range(len(sizes)), key=lambda number: (other[number], cube_m3[number]))
            number = wanted / cube_m3
            yield (
                f"bed.blocks.{name}: {row.count} particles cannot have its sizes: {100 * given[worst]:.3g} % "
                f"of their mass is of {_range_mm([sizes[worst]])} instead of {100 * wanted[worst]:.3g} %; "
                f"one in {number.sum() / number[worst]:.3g} particles would be of that size"
            )


def _range_mm(sizes: Sequence[SizeClass]) -> str:
    smallest_m, largest_m = min(row.smallest_m for row in sizes), max(row.largest_m for row in sizes)
    return f"{1e3 * smallest_m:.3g} to {1e3 * largest_m:.3g} mm"


SLACK_M = 1e-9  # allowance for rounding in rotated boxes


def feeds(case: Case) -> Iterator[CaseProblem]:
    """Check that feeds start and stop within the run, and that their boxes are in the domain and separate.

    Check as well that each box has room for its rate.
    """
    low, high = np.array(case.domain_m)
    by_name = inlets(case)
    for name, inlet in by_name.items():
        key: Key = ("bed", "feeds", name)
        if inlet.start_s >= case.duration_s:
            what = f"{inlet.start_s:g} s is not before the end, duration_s = {case.duration_s:g} s"
            yield CaseProblem((*key, "start_s"), what, kind="out-of-range")
        if inlet.stop_s <= inlet.start_s:
            what = f"{inlet.stop_s:g} s is not after start_s = {inlet.start_s:g} s"
            yield CaseProblem((*key, "stop_s"), what, kind="out-of-range")
        if (inlet.corners_m < low - SLACK_M).any() or (inlet.corners_m > high + SLACK_M).any():
            yield CaseProblem((*key, "box_m"), "is not inside domain_m", kind="misplaced")
        if inlet.rate_kg_per_s > inlet.largest_rate_kg_per_s:
            what = f"{inlet.rate_kg_per_s:g} kg/s do not fit through the box"
            largest = f"at most {inlet.largest_rate_kg_per_s:.3g} kg/s do"
            hint = f"{largest}; enlarge the box, or raise velocity_m_per_s"
            yield CaseProblem((*key, "rate_kg_per_s"), what, hint, kind="out-of-range")
    for (one, first), (two, second) in combinations(by_name.items(), 2):
        if not are_apart(first, second):
            yield CaseProblem(
                ("bed", "feeds", two, "box_m"), f'overlaps the box of feed "{one}"', kind="misplaced"
            )


ENOUGH = 0.8  # share of the mass due by the end that must come
ROUNDED = 0.01  # allowed change of the time between batches by rounding, as a share of that time


def endless_rolling(scene: Scene) -> Iterator[str]:
    """Yield a warning if only hits, and no rolling friction, hold back the spheres of a thin layer.

    They may run ever faster down the deck, which grains with edges do not, and their results then depend on
    how long it is.
    """
    rolling = rolling_on_deck(scene)
    if rolling is None or not rolling.is_endless:
        return
    name = rolling.between[0]
    if all(one.sphere_count > 1 for one in grains_by_material(scene.case)[name]):
        return
    shape = scene.case.materials[name].shape
    hint = f"give materials.{name} a shape, and leave out rolling_friction"
    if shape is not None:
        hint = f"compare the speeds on the panels, and try the range of the shape {shape}"
    which = "lone spheres" if adhesion_law(scene.case) == "none" else "lone spheres that do not stick"
    yield (
        f"{which} may never reach a steady speed: {rolling.in_words}; velocity and efficiency may then "
        f"depend on the length of the deck; {hint}"
    )


def shape_twice(case: Case) -> Iterator[str]:
    """Yield a warning if rolling friction, which stands for the shape of spheres, acts on clumps, too."""
    if case.particles.rolling == "none" or not has_particles(case):
        return
    all_grains = grains_by_material(case)
    clumps = [name for name, grains in all_grains.items() if any(one.sphere_count > 1 for one in grains)]
    largest = max((row for row in case.contacts if {*clumps} & {*row.between}), key=_rolling, default=None)
    if largest is None or not largest.rolling_friction:
        return
    spheres = any(one.sphere_count == 1 for grains in all_grains.values() for one in grains)
    hint = "give their contacts rolling_friction = 0" if spheres else 'take particles.rolling = "none"'
    yield (
        f"grains of {' and '.join(clumps)} are clumps of several spheres, and contacts of "
        f"{' with '.join(largest.between)} have a rolling friction of {largest.rolling_friction:g}, which "
        f"stands for edges that spheres lack: shape counts twice; {hint}"
    )


def sticky_clumps(case: Case) -> Iterator[str]:
    """Yield a warning if clumps stick, each of whose spheres does by itself."""
    if not has_particles(case) or adhesion_law(case) == "none":
        return
    most = max(one.sphere_count for grains in grains_by_material(case).values() for one in grains)
    if most > 1:
        yield (
            "each sphere of a clump sticks by itself: a grain that lies on several of its spheres, of up to "
            f"{most} here, is pulled off by the sum of their forces, which have the spheres' radii"
        )


def _rolling(row: Contact) -> float:
    return row.rolling_friction


def idle_shapes(case: Case, given: Mapping[str, Any]) -> Iterator[str]:
    """Yield a warning for each shape in the tables ``given`` from which no contact takes its friction."""
    shaped = [name for name, row in given.get("materials", {}).items() if row.get("shape") is not None]
    for name in (name if name in case.materials else slug(name) for name in shaped):
        rows = [row for row in case.contacts if name in row.between]
        by_shape = (rolling_friction_of(*(case.materials[end].shape for end in row.between)) for row in rows)
        own = [row.rolling_friction for row in rows]
        if rows and all(one != other for one, other in zip(own, by_shape, strict=True)):
            frictions = ", ".join(f"{friction:g}" for friction in dict.fromkeys(own))
            yield (
                f"materials.{name}.shape = {case.materials[name].shape} changes nothing: all contacts of "
                f"{name} give a rolling_friction of their own ({frictions}); leave it out there"
            )


def feeds_that_hardly_feed(case: Case) -> Iterator[str]:
    """Yield warnings about feeds that bring nothing, or clearly less than is due by the end, or nothing of
    their coarsest sizes.

    Particles come in batches, and the last batch may be long before the end.  Yield a warning as well
    if the time between batches is no whole number of sync intervals.
    """
    for name, inlet in inlets(case).items():
        batches = math.ceil(case.duration_s / inlet.batch_s - 1e-9)
        last_s = (batches - 1) * inlet.batch_s
        comes_kg, due_kg = inlet.due_kg(last_s), inlet.due_kg(case.duration_s)
        when = f"its batches come every {inlet.batch_s:g} s, the last at t = {last_s:g} s"
        first_due_kg = RateFeed(inlet).next_due_kg
        late = np.flatnonzero(first_due_kg > comes_kg)
        absent = float(shares(inlet.sizes)[late].sum())
        if len(late) == len(first_due_kg):
            yield (
                f'feed "{name}" feeds nothing in {case.duration_s:g} s: {when}, when '
                f"{comes_kg:.3g} kg are due, and its first particle comes when {first_due_kg.min():.3g} kg "
                "are; a longer run, a higher rate_kg_per_s, an earlier start_s or a shorter "
                "particles.feed_interval_s helps"
            )
        elif comes_kg < ENOUGH * due_kg:
            yield (
                f'feed "{name}" feeds {comes_kg:.3g} of the {due_kg:.3g} kg that are due in '
                f"{case.duration_s:g} s: {when}; shorten particles.feed_interval_s"
            )
        elif absent > OTHER_SHARE:
            rows = [inlet.sizes[number] for number in late]
            yield (
                f'feed "{name}" brings no particle of {_range_mm(rows)} in {case.duration_s:g} s, which are '
                f"{100 * absent:.2g} % of its mass: the first is due when {first_due_kg[late].min():.3g} kg "
                f"have come, and {comes_kg:.3g} kg come"
            )
    wanted_s, taken_s = case.particles.feed_interval_s, batch_s(case)
    if case.bed.feeds and wanted_s > 0 and abs(taken_s - wanted_s) > ROUNDED * wanted_s:
        yield (
            f"particles.feed_interval_s = {wanted_s:g} s is rounded to {taken_s:g} s, a whole number "
            f"of sync intervals of {case.coupling.sync_interval_s:g} s"
        )


MORE_FED = 1.1  # The sizes of fed particles are drawn, so that their number is only known to some per cent.


def probes_without_particle(case: Case) -> Iterator[str]:
    """Yield a warning for each probe on a particle that neither the start nor the feeds bring."""
    probed = {name: row.particle for name, row in case.probes.items() if row.particle is not None}
    if not probed:
        return
    there = has_particles(case)
    start = len(initial_particles(case)) if there else 0
    feeds = inlets(case).values() if there else ()
    due = (f.due_kg(case.duration_s) / mean_mass_kg(f.sizes, f.grain) for f in feeds)
    fed = math.ceil(sum(due))
    for name, particle in probed.items():
        if particle > start + MORE_FED * fed:
            fed_too = f" and some {fed} are fed" if fed else ""
            yield (
                f'probe "{name}" records nothing: it is on particle {particle}, but the bed has {start} at '
                f"t = 0{fed_too}; give a lower number"
            )


SAME_PLACE_M = 1e-6  # neighbouring exits may share a face
THICKNESS = 0.55  # of the largest diameter: at the latest after half of it, a particle is looked for in exits


def exits(case: Case) -> Iterator[CaseProblem]:
    """Check that exits are boxes that particles can reach and do not miss, apart from each other and from
    all panels."""
    boxes_m = {name: np.array(row.box_m) for name, row in case.screen.exits.items()}
    for name, box_m in boxes_m.items():
        key: Key = ("screen", "exits", name, "box_m")
        if not (box_m[0] < box_m[1]).all():
            yield CaseProblem(key, "is empty", LOWEST_FIRST, kind="out-of-range")
            return
        corners_m = to_world(case, np.array(list(product(*box_m.T))))
        low, high = np.array(case.domain_m)
        if ((corners_m < low).all(axis=0) | (corners_m > high).all(axis=0)).any():
            yield CaseProblem(key, "is outside domain_m: no particle gets there", kind="misplaced")
        least_m = THICKNESS * largest_length_m(case) if has_particles(case) else 0.0
        if (thin_m := float(np.ptp(box_m, axis=0).min())) < least_m:
            what = f"is only {thin_m:g} m thick: fast particles may cross it without being taken out"
            yield CaseProblem(key, what, f"make it {least_m:.3g} m thick or more", kind="out-of-range")
        for panel in single_panels(case):  # straight between its clamps, in deck axes
            r = panel.rectangle
            ends_m = r.mounted(np.array(list(product((0.0, r.length_m), (0.0, r.width_m)))))
            in_deck_m = ends_m @ to_world(case, np.eye(3)).T
            if _overlap(box_m, np.array([in_deck_m.min(axis=0), in_deck_m.max(axis=0)])):
                yield CaseProblem(key, f"panel {panel.name} reaches into it", kind="misplaced")
    for (one, first_m), (two, second_m) in combinations(boxes_m.items(), 2):
        if _overlap(first_m, second_m):
            yield CaseProblem(("screen", "exits", two, "box_m"), f'overlaps exit "{one}"', kind="misplaced")


def _overlap(one_m: Array, two_m: Array) -> bool:
    low, high = one_m[0] + SAME_PLACE_M, one_m[1] - SAME_PLACE_M
    return bool((low <= two_m[1]).all() and (two_m[0] <= high).all())


MORE_OPENINGS = 0.06  # per width in a slice than in the whole machine
FEWEST_DIAMETERS = 3.0  # in a narrower slice, a particle could meet itself, or a neighbour twice
ROUNDING = 1e-9  # three times 0.012 is more than 0.036


def narrow_slice(case: Case) -> Iterator[CaseProblem]:
    """Check that periodic sides are so far apart that no two particles touch each other on both sides."""
    if case.slice is None or case.slice.sides == "walls" or not has_particles(case):
        return
    least_m = FEWEST_DIAMETERS * largest_length_m(case)
    if case.slice.width_m < least_m * (1.0 - ROUNDING):
        what = f"{case.slice.width_m:g} m is less than {FEWEST_DIAMETERS:g} largest diameters"
        hint = f"take {least_m:.3g} m or more"
        openings = (panel.apertures for panel in case.screen.panels.values())
        if len(pitches_m := {each.pitch_across_m for each in openings if isinstance(each, Apertures)}) == 1:
            pitches = math.ceil(least_m / min(pitches_m) - ROUNDING)
            hint = f"take {pitches * min(pitches_m):g} m, which is {pitches} pitches of the openings, or more"
        yield CaseProblem(("slice", "width_m"), what, hint, kind="out-of-range")


def doubtful_slice(case: Case, folder: Path) -> Iterator[str]:
    """Yield warnings about a slice that large particles may bridge, about one with more openings in its width
    than the whole machine, about exits beside periodic sides, and about open sides.

    The sides are open if no triangle stands along a side of the panels or beyond it.
    """
    if case.slice is None or not has_particles(case):
        return
    width_m, length_m = case.slice.width_m, largest_length_m(case)
    if width_m < ENOUGH_DIAMETERS * length_m:
        yield (
            f"slice.width_m = {width_m:g} m is {width_m / length_m:.2g} of the largest "
            f"diameters, less than {ENOUGH_DIAMETERS:g}: large particles may bridge it"
        )
    for name, panel in case.whole_machine.screen.panels.items():
        closed_m = 2 * openings.margin_across_m if isinstance(openings := panel.apertures, Apertures) else 0.0
        more = panel.width_m / (panel.width_m - closed_m) - 1
        if more > MORE_OPENINGS:
            yield (
                f"the slice has openings from side to side, and the whole panel {name} has margins: results "
                f"of the whole width count {100 * more:.2g} % more openings than there are"
            )
            break
    low, high = y_m = bounds_m(case.whole_machine)
    for name, exit_ in case.screen.exits.items():
        if period_m(case) and is_beside(exit_.box_m, y_m):
            yield (
                f'no particle gets to exit "{name}": box_m does not reach into the slice from y = {low:g} to '
                f"{high:g} m"
            )
    if case.slice.sides != "walls":
        return
    panels = case.screen.panels.values()
    sides_m = [p.corner_m[1] + share * p.across[1] * p.width_m for p in panels for share in (0, 1)]
    across_m = [wall.position_m[wall.triangles][:, :, 1] for wall in walls(case, folder)]
    left = any((y_m <= min(sides_m) + 1e-6).all(axis=1).any() for y_m in across_m)
    right = any((y_m >= max(sides_m) - 1e-6).all(axis=1).any() for y_m in across_m)
    if not (left or right):
        yield 'slice.sides = "walls", but no surface stands along the sides: particles can fall off'
