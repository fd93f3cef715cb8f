"""The adhesion of wet particles: the solver's law, made from the case's works of adhesion.

docs/theory/adhesion.md has the equations, sources and limits.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orchestrator.case.bed.contact_times import hertz_s, impact_speed_m_per_s, pair_modulus_Pa
from orchestrator.case.bed.grains import sieve_sizes_m, smallest_grains
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.plans import Jkr, Sjkr

STEPS_PER_CONTACT = 20  # An adhesive contact takes at least so many steps.


@dataclass(frozen=True)
class StickyContact:
    """A contact of the smallest particles of two materials that stick, or of such a particle and a surface.

    ``contact`` is the number of the case's row.  Modulus, mass and radius are the reduced quantities
    of both bodies; ``radius_m`` and ``grain_kg`` are the smaller particle's own radius and the lighter one's
    mass.
    """

    contact: int
    work_J_per_m2: float  # This is the value that the solver receives.
    reduced_Pa: float
    reduced_kg: float
    reduced_m: float
    radius_m: float
    grain_kg: float

    @property
    def pull_off_N(self) -> float:
        """The pull-off force of JKR's theory."""
        return 1.5 * math.pi * self.work_J_per_m2 * self.reduced_m

    @property
    def neck_m(self) -> float:
        """The radius of the contact area without any load."""
        cube_m3 = 4.5 * math.pi * self.work_J_per_m2 * self.reduced_m**2 / self.reduced_Pa
        return math.pow(cube_m3, 1 / 3)

    @property
    def separation_m(self) -> float:
        """The gap at which the neck snaps; its radius is then 36^(-1/3) of the radius without load."""
        return 3.0 * self.neck_m**2 / (math.pow(36.0, 2 / 3) * self.reduced_m)

    @property
    def half_period_s(self) -> float:
        """Half the period of a small oscillation about the state without load.

        The stiffness in this state is 0.3 * 6^(2/3) * (pull-off force) / (gap at separation).
        """
        stiffness_N_per_m = 0.3 * math.pow(6.0, 2 / 3) * self.pull_off_N / self.separation_m
        return math.pi * math.sqrt(self.reduced_kg / stiffness_N_per_m)


def adhesion_law(case: Case) -> str:
    """Return the name of the case's adhesion law, "jkr" or "sjkr"; "none" where nothing sticks."""
    sticks = any(contact.work_of_adhesion_J_per_m2 for contact in case.contacts)
    return (case.particles.adhesion or "jkr") if sticks else "none"


def sticky_contacts(case: Case) -> Iterator[StickyContact]:
    """Yield the contacts of all pairs that can meet and stick; none without a law of adhesion."""
    if adhesion_law(case) == "none":
        return
    for number, contact in enumerate(case.contacts):
        if contact.work_of_adhesion_J_per_m2 > 0:
            for one, two in _bodies(case, contact.between):
                yield _sticky_contact(case, number, one, two)


Body = tuple[float, float]
"""Radius in m and mass in kg of a body; a surface has infinite ones."""


def _bodies(case: Case, between: tuple[str, str]) -> Iterator[tuple[Body, Body]]:
    """Yield the two smallest particles of these materials, then each such particle with a surface."""
    grains = {name: (each.contact_radius_m, each.mass_kg) for name, each in smallest_grains(case).items()}
    one, two = between
    if one in grains and two in grains:
        yield grains[one], grains[two]
    for grain, surface in {(one, two), (two, one)}:
        if grain in grains and surface in surface_materials(case):
            yield grains[grain], (math.inf, math.inf)


def surface_materials(case: Case) -> set[str]:
    """Return the materials of all panels and surfaces that particles can touch."""
    panels = {panel.material for panel in case.screen.panels.values()}
    return panels | {surface.material for surface in case.screen.surfaces.values()}


def _sticky_contact(case: Case, number: int, one: Body, two: Body) -> StickyContact:
    """Return the contact of two bodies whose materials have the row ``number`` of ``contacts``."""
    contact = case.contacts[number]
    return StickyContact(
        contact=number,
        work_J_per_m2=softened_work_J_per_m2(case, number),
        reduced_Pa=pair_modulus_Pa(case, contact.between),
        reduced_kg=1 / (1 / one[1] + 1 / two[1]),
        reduced_m=1 / (1 / one[0] + 1 / two[0]),
        radius_m=min(one[0], two[0]),
        grain_kg=min(one[1], two[1]),
    )


def softened_work_J_per_m2(case: Case, number: int) -> float:
    """Return the work of adhesion for contacts that may be softer than the case's materials.

    "sticking", the default, keeps the speed below which particles stick.  The energy that a neck takes is
    proportional to (w^5 R^4 / E*^2)^(1/3), and so w must be proportional to E*^0.4 (Haervig, J.,
    Kleinhans, U., Wieland, C., Spliethoff, H., Jensen, A. L., Sorensen, K. and Condra, T. J., Powder
    Technology 319, 2017, 472-482).  "pull-off" keeps the pull-off force and therefore w, because the
    pull-off force does not depend on E*.
    """
    contact = case.contacts[number]
    if case.particles.softened_adhesion == "pull-off":
        return contact.work_of_adhesion_J_per_m2
    own_Pa = pair_modulus_Pa(case, contact.between, is_softened=False)
    ratio = pair_modulus_Pa(case, contact.between) / own_Pa
    return contact.work_of_adhesion_J_per_m2 * math.pow(ratio, 0.4)


@dataclass(frozen=True)
class PullOff:
    """The pull-off force of the smallest real particles of a pair of materials, over a particle's weight.

    The case's work of adhesion, or Bond number, has ``asked`` for it; contacts that are softened or have the
    law "sjkr" pull as in the ``run``.
    """

    contact: int
    between: tuple[str, str]
    size_m: float
    asked: float
    run: float

    @property
    def in_words(self) -> str:
        """What the run has, and what was asked for if that is something else."""
        one, two = self.between
        asked = "" if math.isclose(self.asked, self.run, rel_tol=0.005) else f", {self.asked:.3g} asked for"
        grain = f"a grain of {1e3 * self.size_m:.3g} mm"
        return f"pull-off force of {one} and {two}: {self.run:.3g} times the weight of {grain}{asked}"


def pull_offs(case: Case) -> list[PullOff]:
    """Return the pull-off force of each contact that sticks, of two particles and of one on a surface."""
    k = case.particles.coarse_graining
    found = []
    for pair in sticky_contacts(case):
        row = case.contacts[pair.contact]
        # of coarse particles, k times as large and as sticky, a weight is the k-th part of the real ones'
        weight_N = pair.grain_kg * STANDARD_GRAVITY_M_PER_S2 / k
        run_N = pair.pull_off_N
        if adhesion_law(case) == "sjkr":
            density_J_per_m3 = _energy_density_J_per_m3(case, pair.contact, pair.work_J_per_m2)
            run_N = 2 / 3 * math.pi**3 * density_J_per_m3**3 * pair.reduced_m**2 / pair.reduced_Pa**2
        asked_N = pair.pull_off_N * row.work_of_adhesion_J_per_m2 / pair.work_J_per_m2
        size_m = 2 * pair.radius_m / k
        found.append(PullOff(pair.contact, row.between, size_m, asked_N / weight_N, run_N / weight_N))
    return found


def planned_adhesion(case: Case, numbers: dict[str, int]) -> Jkr | Sjkr | None:
    """Return the adhesion law with its strengths; None if nothing sticks.

    ``numbers`` are the materials' numbers, by name.
    """
    law = adhesion_law(case)
    if law == "none":
        return None
    strength: Array = np.zeros((len(numbers), len(numbers)))
    for number, contact in enumerate(case.contacts):
        if set(contact.between) <= set(numbers):
            one, two = (numbers[name] for name in contact.between)
            value = softened_work_J_per_m2(case, number)
            if law == "sjkr":
                value = _energy_density_J_per_m3(case, number, value)
            strength[one, two] = strength[two, one] = value
    if law == "sjkr":
        return Sjkr(strength)
    stretch = (pair.separation_m / pair.radius_m for pair in sticky_contacts(case))
    return Jkr(strength, max(stretch, default=0.0))


def sjkr_diameter_m(case: Case) -> float:
    """Return the diameter for which sjkr has the pull-off force of JKR's theory.

    The case gives it, or it is the geometric mean of the smallest and the largest size.
    """
    if case.particles.sjkr_diameter_m is not None:
        return case.particles.sjkr_diameter_m
    smallest_m, largest_m = sieve_sizes_m(case)
    return math.sqrt(smallest_m * largest_m)


def _energy_density_J_per_m3(case: Case, number: int, work_J_per_m2: float) -> float:
    """Return k of ``sjkr``, for which a particle of its diameter has JKR's pull-off force.

    Hertz's force less  2 pi k R* overlap  pulls with  2/3 pi^3 k^3 R*^2 / E*^2  at most; JKR's force
    pulls with  3/2 pi w R*  at most.
    """
    between = case.contacts[number].between
    radius_m = sjkr_diameter_m(case) / 2
    if not surface_materials(case) & set(between):
        radius_m /= 2  # This is the reduced radius of two equal particles.
    reduced_Pa = pair_modulus_Pa(case, between)
    return math.pow(9 * work_J_per_m2 * reduced_Pa**2 / (4 * math.pi**2 * radius_m), 1 / 3)


def adhesive_step_s(case: Case) -> float:
    """Return the longest step for JKR contacts; infinite without any.

    The step is 1/20 of the shortest impact (see ``impact_speed_m_per_s``), or of half an oscillation
    on the neck if that is shorter.
    """
    times_s = [math.inf]
    if adhesion_law(case) == "jkr":
        for pair in sticky_contacts(case):
            impact_s = hertz_s(pair.reduced_kg, pair.reduced_m, pair.reduced_Pa, impact_speed_m_per_s(case))
            times_s += [impact_s, pair.half_period_s]
    return min(times_s) / STEPS_PER_CONTACT
