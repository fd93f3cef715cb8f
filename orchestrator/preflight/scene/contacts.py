"""Contacts of particles in a scene: effects that are contact laws, overlaps, and friction on the deck."""

from __future__ import annotations

import math
from dataclasses import dataclass

from orchestrator.case.bed.adhesion import surface_materials
from orchestrator.case.bed.contact_times import (
    contact_moduli,
    hertz_overlap_m,
    reduced_modulus_Pa,
    smallest_diameters_m,
)
from orchestrator.case.tables.case import Case, Contact, has_particles
from orchestrator.ports.physics import sphere_mass_kg
from orchestrator.preflight.scene.effect import Effect, Judge, Overlay
from orchestrator.preflight.scene.observed import ObservedField
from orchestrator.preflight.scene.scene import Scene


def contact_law_effect(
    judge: Judge,
    *,
    coefficient: str,
    law: str,
    laws: tuple[str, ...],
    without: str,
    key: str,
    checked_by: ObservedField | None = None,
) -> Effect:
    """An effect of the particles that a case describes by a ``coefficient`` of its contacts above
    zero, and whose ``law``, a key of the particles, is one of ``laws`` or "none": ``without`` says
    what that means."""

    def described(case: Case) -> bool:
        return has_particles(case) and any(getattr(row, coefficient) for row in case.contacts)

    def left_out(case: Case) -> str:
        off = getattr(case.particles, law) == "none" and described(case)
        return f"particles.{law} none: {without}" if off else ""

    def undescribed(case: Case) -> Overlay:
        return {"contacts": {str(n): {coefficient: 0.0} for n in range(len(case.contacts))}}

    return Effect(
        part="particles",
        judge=judge,
        described=described,
        left_out=left_out,
        undescribed=undescribed,
        overlay=lambda case: {"particles": {law: "none"}},
        laws={name: {"particles": {law: name}} for name in laws},
        key=key,
        checked_by=checked_by,
        saves=True,
        about=("particles",),
    )


STEP_COST = "the particles' step goes with 1/sqrt(stiffness)"


@dataclass(frozen=True)
class Softness:
    """Overlap of an impact over the radius, with the stiffness in use, and what it goes with."""

    overlap: float
    where: str
    cap_Pa: float | None
    softened: bool

    def in_words(self, value: float, limit: float, where: str) -> str:
        """About a softness whose overlap over something is ``value``; overlaps go with E^(-2/5)."""
        factor = math.pow(value / limit, 2.5)
        if not self.softened and factor < 1:
            return f"the materials' own stiffness, {where}; {factor:.1g} of it would do"
        if not self.softened:
            return f"the materials' own stiffness, {where}: they are this soft in fact"
        stiffer = f"; {factor:.2g} times as stiff would do" if factor > 1 else ""
        return f"softened to {self.cap_Pa:.2g} Pa, {where}{stiffer}"


def softness(scene: Scene) -> Softness:
    """The largest of all pairs of particles, and of particles and panels, that meet, or what a run
    had.  Hertz:
    overlap = (15 m v^2 / (16 sqrt(R) E*))^(2/5) = 0.9745 (m^2 v^4 / (R E*^2))^(1/5) with reduced
    mass, radius and modulus; over the radius it knows no size.  Johnson, K. L., Contact Mechanics,
    1985, section 11.4."""
    case = scene.case
    grains = set(smallest_diameters_m(case))
    overlaps = [_overlap(scene, *pair, both=pair[1] in grains) for pair in _meeting(case)]
    cap_Pa = case.particles.largest_youngs_modulus_Pa
    overlap, where = max(overlaps, default=0.0), f"at {scene.impact_m_per_s:.2g} m/s"
    if scene.observed.deepest is not None:
        overlap, where = 2.0 * scene.observed.deepest.per_diameter, "deepest of the run"
    return Softness(overlap, where, cap_Pa, is_softened(case))


def is_softened(case: Case) -> bool:
    """Whether contacts are softer than one of the materials that meet in them."""
    cap_Pa = case.particles.largest_youngs_modulus_Pa
    moduli = [contact_moduli(case.materials[n], None)[0] for pair in _meeting(case) for n in pair]
    return cap_Pa is not None and cap_Pa < max(moduli, default=0.0)


def _meeting(case: Case) -> set[tuple[str, str]]:
    """Materials of a particle and of what it can meet: particles or panels."""
    grains = set(smallest_diameters_m(case))
    others = grains | {panel.material for panel in case.screen.panels.values()}
    return {
        (grain, other)
        for row in case.contacts
        for grain, other in (row.between, row.between[::-1])
        if grain in grains and other in others
    }


def _overlap(scene: Scene, grain: str, other: str, both: bool) -> float:
    """Of two equal spheres (``both``) or a sphere and a surface, over the sphere's radius 1 m."""
    case = scene.case
    cap_Pa = case.particles.largest_youngs_modulus_Pa
    one, two = (contact_moduli(case.materials[name], cap_Pa) for name in (grain, other))
    reduced_Pa = reduced_modulus_Pa(one, two)
    half = 0.5 if both else 1.0
    mass_kg = half * sphere_mass_kg(2.0, case.materials[grain].density_kg_per_m3)
    return hertz_overlap_m(mass_kg, half, reduced_Pa, scene.impact_m_per_s)


def contacts_on_deck(case: Case) -> list[Contact]:
    """Contacts of particles with panels or, without any, with other surfaces."""
    grains = set(smallest_diameters_m(case))
    panels = {panel.material for panel in case.screen.panels.values()} or surface_materials(case)
    return [
        row
        for row in case.contacts
        for grain, panel in (row.between, row.between[::-1])
        if grain in grains and panel in panels
    ]


def of_slope(friction: float, slope: float) -> float:
    """Share of a slope's acceleration that friction takes; infinite on the level."""
    if slope < 1e-9:
        return math.inf if friction else 0.0
    return friction / slope


def friction_over_pull(scene: Scene, friction: float) -> float:
    """Of a coefficient, or as a run has it carried: share of what pulls the bed down the deck."""
    bearing = scene.observed.bearing
    return of_slope(friction, scene.slope) * (1.0 if bearing is None else bearing.carried)


def describe_friction(ratio: float, how: str) -> str:
    """That share in words."""
    if math.isinf(ratio):
        return "on the level, friction holds what lies"
    if ratio >= 1:
        return f"what is {how} stops on the flattest panel"
    return f"takes {ratio:.0%} of the acceleration of what is {how} down the flattest panel"
