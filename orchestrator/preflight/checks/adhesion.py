"""Adhesion: a law and works that fit together, and contacts small enough for the law."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.bed.adhesion import adhesion_law, sticky_contacts, surface_materials
from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.tables.case import Case
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2

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
