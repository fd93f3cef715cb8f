"""Contacts that are softer than the materials, for longer steps: what that does to overlaps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

from orchestrator.bed.contact_times import contact_moduli, reduced_modulus_Pa, smallest_diameters_m
from orchestrator.bed.size_distribution import classes
from orchestrator.deck.opening_places import smaller_sides_m
from orchestrator.effects.scene import Scene
from orchestrator.effects.verdict import Verdict

LARGEST_OVERLAP = 0.1  # of the radius: contacts are small against bodies, as Hertz's theory wants
LARGEST_SHIFT = 0.01  # of an opening, by which soft particles seem smaller: the project's choice
NEAR = 1.5  # ratio to an opening of what may just pass or just not: the project's choice
STEP_COST = "the particles' step goes with 1/sqrt(stiffness)"


@dataclass(frozen=True)
class Softness:
    """Overlap of an impact over the radius, with the stiffness in use, and what it goes with."""

    overlap: float
    cap_Pa: float | None
    softened: bool


def softness(scene: Scene) -> Softness:
    """The largest of all pairs of particles, and of particles and panels, that meet.  Hertz:
    overlap = (15 m v^2 / (16 sqrt(R) E*))^(2/5) = 0.9745 (m^2 v^4 / (R E*^2))^(1/5) with reduced
    mass, radius and modulus; over the radius it knows no size.  Johnson, K. L., Contact Mechanics,
    1985, section 11.4."""
    case = scene.case
    grains = set(smallest_diameters_m(case))
    others = grains | {panel.material for panel in case.screen.panels.values()}
    pairs = {
        (grain, other)
        for row in case.contacts
        for grain, other in (row.between, row.between[::-1])
        if grain in grains and other in others
    }
    overlaps = [_overlap(scene, grain, other, both=other in grains) for grain, other in pairs]
    moduli = [contact_moduli(case.materials[name], None)[0] for pair in pairs for name in pair]
    cap_Pa = case.particles.largest_youngs_modulus_Pa
    softened = cap_Pa is not None and cap_Pa < max(moduli, default=0.0)
    return Softness(max(overlaps, default=0.0), cap_Pa, softened)


def _overlap(scene: Scene, grain: str, other: str, both: bool) -> float:
    """Of two equal spheres (``both``) or a sphere and a surface, over the sphere's radius 1 m."""
    case = scene.case
    cap_Pa = case.particles.largest_youngs_modulus_Pa
    one, two = (contact_moduli(case.materials[name], cap_Pa) for name in (grain, other))
    reduced_Pa = reduced_modulus_Pa(one, two)
    half = 0.5 if both else 1.0
    mass_kg = half * 4 / 3 * math.pi * case.materials[grain].density_kg_m3
    return hertz_overlap_m(mass_kg, half, reduced_Pa, scene.impact_m_s)


def hertz_overlap_m(mass_kg: float, radius_m: float, reduced_Pa: float, speed_m_s: float) -> float:
    """Largest overlap of an elastic impact, with reduced mass, radius and modulus."""
    return math.pow(15 * mass_kg * speed_m_s**2 / (16 * math.sqrt(radius_m) * reduced_Pa), 0.4)


def contact_stiffness(scene: Scene) -> Verdict:
    """Softened contacts must stay small against the particles."""
    found = softness(scene)
    return _stiffness(
        "contact-stiffness",
        "overlap / radius",
        found,
        found.overlap,
        LARGEST_OVERLAP,
        f"at {scene.impact_m_s:.2g} m/s",
        "0.1 (Hertz: small contacts)",
    )


def stiffness_at_openings(scene: Scene) -> Verdict | None:
    """A soft particle passes an opening that is smaller by its overlap; None without openings."""
    openings_m = list(smaller_sides_m(scene.case))
    if not openings_m:
        return None
    found, opening_m = softness(scene), max(openings_m)
    verdict = _stiffness(
        "stiffness-at-openings",
        "overlap / opening",
        found,
        found.overlap / 2,
        LARGEST_SHIFT,
        f"a particle of {opening_m * 1e3:.2g} mm at {scene.impact_m_s:.2g} m/s",
        "0.01 (own choice)",
    )
    if any(low < NEAR * opening_m and high > opening_m / NEAR for low, high in _sizes_m(scene)):
        return verdict
    why = (
        f"no particles are within a factor of {NEAR:g} of the openings of {opening_m * 1e3:.2g} mm"
    )
    return replace(verdict, value=0.0, matters=False, why=why)


def _sizes_m(scene: Scene) -> Iterator[tuple[float, float]]:
    """Limits of all classes, of real particles."""
    k = scene.case.particles.coarse_graining
    for one in scene.case.bed.particles.values():
        yield one.diameter_m, one.diameter_m
    for source in scene.case.bed.sources:
        for row in classes(source):
            yield row.smallest_m / k, row.largest_m / k


def _stiffness(
    effect: str,
    number: str,
    found: Softness,
    value: float,
    limit: float,
    where: str,
    threshold: str,
) -> Verdict:
    """Of a softness whose overlap over something is ``value``; overlaps go with E^(-2/5)."""
    factor = math.pow(value / limit, 2.5)
    return Verdict(
        effect=effect,
        present=not found.softened,
        number=number,
        value=value,
        threshold=threshold,
        matters=value > limit,
        why=_words(found, factor, where),
        key="particles.largest_youngs_modulus_Pa",
        cost=STEP_COST,
    )


def _words(found: Softness, factor: float, where: str) -> str:
    if not found.softened and factor < 1:
        return f"the materials' own stiffness, {where}; {factor:.1g} of it would do"
    if not found.softened:
        return f"the materials' own stiffness, {where}: they are this soft in fact"
    stiffer = f"; {factor:.2g} times as stiff would do" if factor > 1 else ""
    return f"softened to {found.cap_Pa:.2g} Pa, {where}{stiffer}"
