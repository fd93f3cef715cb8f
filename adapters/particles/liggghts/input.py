"""The LIGGGHTS input of a plan: plain text that a LIGGGHTS user can read and change."""

from __future__ import annotations

import math

import numpy as np

from adapters.particles.liggghts.domain_cuts import processor_grid
from orchestrator.ports import Array
from orchestrator.ports.clock import steps_in
from orchestrator.ports.plans import AirPlan, Jkr, ParticlesPlan, Sjkr

# LIGGGHTS wants a word of confirmation outside of these moduli
SOFTEST_PA, HARDEST_PA = 5e6, 1e9
# and refuses 0.05
LEAST_RESTITUTION = 0.051
LISTING, LOOKED_AT = 50.0, 0.35
"""The cost of listing a particle's neighbours, and of each other one that is looked at for that, over what a
pair that is near but does not touch costs in a step."""
FILLED, SPEED_M_PER_S = 0.2, 1.0
"""The share of space that a thrown bed fills, and how fast its particles move against each other."""
SKINS = 0.05, 0.6
"""The least skin over the mean diameter, and the largest over the largest diameter."""
CLASS_RATIO = 3.0
"""The largest diameter of a class of sizes over that of the next finer one. Each class has its own cells, in
which neighbours are looked for."""
MOST_BINS = 1e6
"""The largest number of bins in the box at the start. LIGGGHTS sorts particles in memory by them, every
thousand steps, and clears them all; for small grains on a large machine they would be too many to count."""

INPUT = """\
# Particles on a moving, deforming surface: input for LIGGGHTS-PUBLIC 3.8.0, written by flipflow.
# flipflow reads it line by line.  Atom type = number of the material, from 1.

units           si
atom_style      granular
newton          off
communicate     single vel yes
boundary        {boundary}           # grows with the particles (m): none can be lost unseen,
                                # and no bins are kept where there are none
{confirmations}{processors}region          box block {box} units box
create_box      {types} box
neighbor        {skin} bin
neigh_modify    delay 0 binsize {bins}
atom_modify     sort 1000 {bins}

fix youngs      all property/global youngsModulus peratomtype {youngs}
fix poisson     all property/global poissonsRatio peratomtype {poisson}
fix restitution all property/global coefficientRestitution peratomtypepair {types} {restitution}
{tables}
pair_style      gran {model}
pair_coeff      * *

{gravity}# The surface: flipflow's own wall, which gives the contacts found on its triangles to the
# contact model named here.  The plane only satisfies the stock syntax and is not used (for a
# run with LIGGGHTS alone, write wall/gran and place the plane).
fix surface     all wall/gran/flipflow {model} primitive type 1 zplane 0.0
{air}fix motion      all {motion}
fix exits       all exits/flipflow  # takes particles out; where, it is told from memory
timestep        {step}
# The surface's points and the particles follow from memory, then the first force evaluation:
"""

FIRST_EVALUATION = "run             0"


def words(values: Array) -> str:
    """Return numbers as text for LIGGGHTS, exact to the last bit."""
    return " ".join(repr(float(value)) for value in np.ravel(values))


def has_sliding(plan: ParticlesPlan) -> bool:
    """Return whether a tangential spring is needed; rolling friction uses its stiffness, too."""
    return bool(np.any(plan.sliding_friction > 0)) or has_rolling(plan)


def has_rolling(plan: ParticlesPlan) -> bool:
    """Return whether a contact of the plan has rolling friction."""
    return bool(np.any(plan.rolling_friction > 0))


def has_bodies(plan: ParticlesPlan) -> bool:
    """Return whether a grain of the plan may be made of several spheres; all of them are bodies then."""
    return any(len(shape.spheres) > 1 for shape in plan.shapes)


def contact_model(plan: ParticlesPlan) -> str:
    """Return the contact model: Hertz or JKR, and the additions that the plan's coefficients require."""
    model = "model jkr" if isinstance(plan.adhesion, Jkr) else "model hertz"
    if has_sliding(plan):
        model += " tangential history"
    if isinstance(plan.adhesion, Sjkr):
        model += " cohesion sjkr"
    if has_rolling(plan):
        model += f" rolling_friction {plan.rolling}"
    return model


def ranks(plan: ParticlesPlan) -> int:
    """Return the number of processes that share the particles."""
    return 1 if plan.communicator is None else int(plan.communicator.size)


def skin_m(
    plan: ParticlesPlan,
    listing: float = LISTING,
    each_looked_at: float = LOOKED_AT,
    class_ratio: float = CLASS_RATIO,
) -> float:
    """Return the skin: the gap up to which two particles are listed as neighbours.

    With a wide one each step has more pairs to look at; with a narrow one neighbours are listed more often.
    The skin has the least cost for a thrown bed of the particles at the start or, without any, of the largest
    ones (docs/measured/cost.md compares skins).
    """
    diameter_m, largest_m = _diameters_m(plan), 2.0 * plan.largest_radius_m
    mean_m = float(np.mean(diameter_m))
    per_m3 = FILLED / (math.pi / 6.0 * np.mean(diameter_m**3))
    skins_m = np.geomspace(SKINS[0] * mean_m, SKINS[1] * largest_m, 100)
    near = 2.0 / 3.0 * math.pi * per_m3 * ((mean_m + skins_m) ** 3 - mean_m**3)
    looked_at = per_m3 * _looked_at_m3(diameter_m, largest_m, skins_m, class_ratio)
    listings_per_step = 2.0 * SPEED_M_PER_S * plan.step_s / skins_m
    cost = near + (listing + each_looked_at * looked_at) * listings_per_step
    return float(f"{skins_m[np.argmin(cost)]:.3g}")


def _looked_at_m3(diameter_m: Array, largest_m: float, skins_m: Array, class_ratio: float) -> Array:
    """Return the volume that is looked at for a particle's neighbours, for each skin; the mean of all.

    Of each class of sizes it counts with the class's share of the particles.
    """
    number = np.floor(np.log(largest_m / diameter_m) / math.log(class_ratio)).astype(int)
    looked_at_m3 = np.zeros(len(skins_m))
    for coarse in np.unique(number):
        finer = number >= coarse
        cell_m = largest_m / class_ratio ** float(coarse) + skins_m
        reach_m = (diameter_m[finer].mean() - largest_m / class_ratio ** float(coarse)) / 2.0 + cell_m
        volume_m3 = (2.0 * reach_m + cell_m) ** 2 * (2.0 * reach_m + cell_m / 4.0)
        looked_at_m3 += np.mean(number == coarse) * np.mean(finer) * volume_m3
    return looked_at_m3


def _diameters_m(plan: ParticlesPlan) -> Array:
    if len(plan.particles):
        return plan.particles.grains.sieve_size_m
    return np.array([2.0 * plan.largest_radius_m])


def cutoff_m(plan: ParticlesPlan) -> float:
    """Return the distance up to which the centres of particles are listed as neighbours."""
    return 2.0 * plan.largest_radius_m + skin_m(plan)


def smallest_box_m(plan: ParticlesPlan) -> Array:
    """Return the lowest and highest corner (2, 3) of the box that LIGGGHTS's bins cover at least.

    The box holds the surface and the particles at the start (along y the whole domain where that is
    periodic). With more than two ranks it is the domain: LIGGGHTS hands particles to a neighbouring rank
    only, so a box that shrinks at once, when a far flier leaves, must not be cut into more than two parts.
    """
    vertices_m = plan.surface.vertices_m
    on_it = np.isin(np.arange(len(vertices_m)), plan.surface.triangles)  # not probes
    places_m = np.vstack([vertices_m[on_it], plan.particles.position_m])
    if ranks(plan) > 2 or not len(places_m):
        places_m = plan.domain_m
    margin_m = 2.0 * plan.largest_radius_m
    corners_m = np.array([places_m.min(axis=0) - margin_m, places_m.max(axis=0) + margin_m])
    if plan.periodic_y:
        corners_m[:, 1] = plan.domain_m[:, 1]
    return corners_m


def input_text(plan: ParticlesPlan) -> str:
    """Return the whole input except for the last line, :data:`FIRST_EVALUATION`."""
    youngs = [material.youngs_modulus_Pa for material in plan.materials]
    return INPUT.format(
        boundary="m p m" if plan.periodic_y else "m m m",
        confirmations=_confirmations(youngs),
        processors=_processors(plan),
        box=words(smallest_box_m(plan).T.round(12)),
        types=len(youngs),
        skin=words(np.array(skin_m(plan))),
        bins=words(np.array(bin_size_m(plan))),
        youngs=words(np.array(youngs)),
        poisson=words(np.array([material.poisson_ratio for material in plan.materials])),
        restitution=words(_constant_restitution(plan)),
        tables=_tables(plan),
        model=contact_model(plan),
        gravity="" if has_bodies(plan) else _gravity(plan.gravity_m_per_s2),
        motion=f"bodies/flipflow {words(plan.gravity_m_per_s2)}" if has_bodies(plan) else "nve/sphere",
        air=_air(plan.air),
        step=words(np.array(plan.sync_interval_s / steps_in(plan.sync_interval_s, plan.step_s))),
    )


def bin_size_m(plan: ParticlesPlan) -> float:
    """Return the size of the bins in which LIGGGHTS sorts particles in memory.

    It is half of the distance up to which particles of the mean size are neighbours, or larger."""
    near_m = float(np.mean(_diameters_m(plan))) + skin_m(plan)
    box_m3 = float(np.prod(np.diff(smallest_box_m(plan), axis=0)))
    return float(f"{max(near_m / 2.0, math.cbrt(box_m3 / MOST_BINS)):.3g}")


def _processors(plan: ParticlesPlan) -> str:
    if ranks(plan) == 1:
        return ""
    grid = processor_grid(plan, smallest_box_m(plan), ranks(plan), cutoff_m(plan))
    return "processors      {} {} {}\n".format(*grid)


def _confirmations(youngs_Pa: list[float]) -> str:
    lines = ""
    if min(youngs_Pa) < SOFTEST_PA:
        lines += "soft_particles  yes\n"
    if max(youngs_Pa) > HARDEST_PA:
        lines += "hard_particles  yes\n"
    return lines


def _constant_restitution(plan: ParticlesPlan) -> Array:
    """Return the restitutions that LIGGGHTS reads; those over speed, which the bridge takes from memory, are
    raised to what it accepts."""
    table = plan.restitution.copy()
    for rebound in plan.rebounds:
        one, other = rebound.materials
        table[one, other] = table[other, one] = max(table[one, other], LEAST_RESTITUTION)
    return table


def _tables(plan: ParticlesPlan) -> str:
    """Return the lines of friction and adhesion, by pair of materials."""
    tables: list[tuple[str, str, Array]] = []
    if has_sliding(plan):
        tables.append(("sliding", "coefficientFriction", plan.sliding_friction))
    if has_rolling(plan):
        tables.append(("rolling", "coefficientRollingFriction", plan.rolling_friction))
    match plan.adhesion:
        case Jkr(work_J_per_m2=values):  # of `model jkr`, which is flipflow's own
            tables.append(("adhesion", "workOfAdhesion", values))
        case Sjkr(energy_density_J_per_m3=values):
            tables.append(("adhesion", "cohesionEnergyDensity", values))
    head = f"peratomtypepair {len(plan.materials)}"
    lines = [f"fix {fix:<11} all property/global {name} {head} {words(v)}\n" for fix, name, v in tables]
    return "".join(lines)


def _gravity(gravity_m_per_s2: Array) -> str:
    size_m_per_s2 = float(np.linalg.norm(gravity_m_per_s2))
    if size_m_per_s2 == 0:
        return ""
    direction = gravity_m_per_s2 / size_m_per_s2
    return f"fix gravity     all gravity {words(np.array(size_m_per_s2))} vector {words(direction)}\n"


def _air(air: AirPlan | None) -> str:
    """Return the line of the air's drag, which comes after all other forces."""
    if air is None:
        return ""
    return (
        f"fix air         all air/flipflow {words(np.array([air.density_kg_per_m3, air.viscosity_Pa_s]))}\n"
    )
