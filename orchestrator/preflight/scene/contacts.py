"""The contacts of particles in a scene: effects of contact laws, overlaps, and friction on the deck."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Any

from orchestrator.case.bed.adhesion import surface_materials
from orchestrator.case.bed.contact_times import contact_moduli, hertz_overlap_m, pair_modulus_Pa
from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.tables.case import Case, Contact, has_particles
from orchestrator.preflight.scene.effect import Effect, Judge
from orchestrator.preflight.scene.scene import Scene, layer_kg_per_m2


def contact_law_effect(
    judge: Judge, *, coefficient: str, law: str, laws: tuple[str, ...], without: str, **more: Any
) -> Effect:
    """Return an effect of the particles that is a contact law.

    A case describes it by a positive ``coefficient`` of one of its contacts.  The key ``law`` of the
    particles chooses one of ``laws`` or "none"; ``without`` says what "none" means.  ``more`` has the
    effect's other fields.
    """

    def described(case: Case) -> bool:
        return any(getattr(row, coefficient) for row in case.contacts)

    def left_out(case: Case) -> str:
        off = getattr(case.particles, law) == "none" and has_particles(case) and described(case)
        return f"particles.{law} none: {without}" if off else ""

    return Effect(
        part="particles",
        judge=judge,
        described=described,
        left_out=left_out,
        overlay=lambda case: {"particles": {law: "none"}},
        laws={name: {"particles": {law: name}} for name in laws},
        saves=True,
        about=("particles",),
        **more,
    )


LEVEL = 1e-9  # slope of a deck that counts as level
FEWEST_LAYERS = 2.0  # of a bed in which grains hold each other back; the project's own choice
STEP_COST = "the particles' step goes with 1/sqrt(stiffness)"


@dataclass(frozen=True)
class Softness:
    """The largest overlap of impacts over the radius with the stiffness in use.

    ``where`` describes the impact, ``cap_Pa`` limits Young's moduli, and ``softened`` says whether it
    softens a contact.
    """

    overlap: float
    where: str
    cap_Pa: float | None
    softened: bool

    def in_words(self, limit: float) -> str:
        """Return a text that compares the overlap with a limit; overlaps go with E^(-2/5)."""
        factor = math.pow(self.overlap / limit, 2.5)
        if not self.softened and factor < 1:
            return f"the materials' own stiffness, {self.where}; {factor:.1g} of it would do"
        if not self.softened:
            return f"the materials' own stiffness, {self.where}: they are this soft in fact"
        stiffer = f"; {factor:.2g} times as stiff would do" if factor > 1 else ""
        return f"softened to {self.cap_Pa:.2g} Pa, {self.where}{stiffer}"


def compute_softness(scene: Scene) -> Softness:
    """Return the softness of contacts among particles and with panels, by the run if it tells.

    Hertz's overlap is (15 m v^2 / (16 sqrt(R) E*))^(2/5) = 0.9745 (m^2 v^4 / (R E*^2))^(1/5) with
    reduced mass, radius and modulus.  Divided by the radius, it does not depend on the size.  Johnson,
    K. L., Contact Mechanics, 1985, section 11.4.
    """
    case = scene.case
    grains = set(smallest_grains(case))
    overlaps = [_overlap(scene, *pair, both=pair[1] in grains) for pair in _meeting(case)]
    overlap, where = max(overlaps, default=0.0), f"at {scene.impact_m_per_s:.2g} m/s"
    if scene.observed.deepest is not None:
        overlap, where = 2.0 * scene.observed.deepest.per_diameter, "deepest of the run"
    return Softness(overlap, where, case.particles.largest_youngs_modulus_Pa, is_softened(case))


def is_softened(case: Case) -> bool:
    """Return whether contacts are softer than one of the materials that meet in them."""
    cap_Pa = case.particles.largest_youngs_modulus_Pa
    moduli = [contact_moduli(case.materials[n], None)[0] for pair in _meeting(case) for n in pair]
    return cap_Pa is not None and cap_Pa < max(moduli, default=0.0)


def _meeting(case: Case) -> set[tuple[str, str]]:
    """Return the pairs of materials of a particle and of a particle or panel that it can meet."""
    panels = {panel.material for panel in case.screen.panels.values()}
    met = panels | set(smallest_grains(case))
    return {pair for _, pair in _contacts_with(case, met)}


def contacts_on_deck(case: Case) -> list[Contact]:
    """Return the contacts of particles with panels or, without panels, with other surfaces."""
    panels = {panel.material for panel in case.screen.panels.values()} or surface_materials(case)
    return [row for row, _ in _contacts_with(case, panels)]


def _contacts_with(case: Case, materials: Collection[str]) -> Iterator[tuple[Contact, tuple[str, str]]]:
    """Yield the contacts of particles with some materials, each with its pair, the particle's first."""
    grains = set(smallest_grains(case))
    for row in case.contacts:
        for grain, other in (row.between, row.between[::-1]):
            if grain in grains and other in materials:
                yield row, (grain, other)


def _overlap(scene: Scene, grain: str, other: str, both: bool) -> float:
    """Return the overlap over the radius of two equal spheres (``both``), or of a sphere and a surface.

    The spheres have a radius of 1 m.
    """
    reduced_Pa = pair_modulus_Pa(scene.case, (grain, other))
    half = 0.5 if both else 1.0
    unit = smallest_grains(scene.case)[grain].resized(2.0)
    mass_kg, radius_m = half * unit.mass_kg, half * unit.contact_radius_m
    return hertz_overlap_m(mass_kg, radius_m, reduced_Pa, scene.impact_m_per_s)


def friction_over_pull(scene: Scene, friction: float) -> float:
    """Return the ratio of a friction coefficient's force to the pull on the bed down the deck.

    The share of the weight that the deck carries is that of a run if it tells.  On a level deck, the
    ratio is infinite, or 0 without friction.
    """
    if scene.slope < LEVEL:
        return math.inf if friction else 0.0
    bearing = scene.observed.bearing
    return friction / scene.slope * (1.0 if bearing is None else bearing.carried)


@dataclass(frozen=True)
class Rolling:
    """How lone spheres roll on the flattest panel.

    ``friction`` is the smallest coefficient of rolling friction of particles on the deck, in the contact of
    the two materials ``between``; ``slope`` is the tangent of the panel's angle, and ``layers`` the mass of
    the bed over that of one layer of its largest particles.
    """

    friction: float
    between: tuple[str, str]
    slope: float
    layers: float

    @property
    def is_endless(self) -> bool:
        """Whether a sphere on the deck runs ever faster, and no bed holds it back."""
        return self.slope >= LEVEL and self.friction < self.slope and self.layers < FEWEST_LAYERS

    @property
    def in_words(self) -> str:
        """A text that compares friction with slope, and names the bed."""
        what = "less" if self.friction < self.slope else "not less"
        layers = f"{self.layers:.2g} layer{'s' * (round(self.layers, 2) != 1)}"
        return (
            f"rolling friction {self.friction:.3g} of {' on '.join(self.between)} is {what} than the tangent "
            f"of the slope, {self.slope:.3g}, under a bed of {layers}"
        )


def rolling_on_deck(scene: Scene) -> Rolling | None:
    """Return how lone spheres roll on the deck; None without panels or particles."""
    rows = contacts_on_deck(scene.case) if scene.panels else []
    if not rows:
        return None
    row = min(rows, key=lambda row: row.rolling_friction)
    grains = smallest_grains(scene.case)
    between = row.between if row.between[0] in grains else row.between[::-1]
    friction = 0.0 if scene.case.particles.rolling == "none" else row.rolling_friction
    return Rolling(friction, between, scene.slope, scene.bed_kg_per_m2 / layer_kg_per_m2(scene.case))


def describe_friction(ratio: float, how: str) -> str:
    """Return a text about the ratio of friction to the pull down the deck."""
    if math.isinf(ratio):
        return "on the level, friction holds what lies"
    if ratio >= 1:
        return f"what is {how} stops on the flattest panel"
    return f"takes {ratio:.0%} of the acceleration of what is {how} down the flattest panel"
