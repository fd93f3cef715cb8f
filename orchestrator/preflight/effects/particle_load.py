"""Load of the particles on the panels, which matters by the mass of the bed over the panel's mass."""

from __future__ import annotations

from orchestrator.case.tables.case import has_particles
from orchestrator.preflight.scene.effect import TENTH, Verdict, compare, exchange_effect
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the mass of the bed over the panel's; None without particles."""
    if not has_particles(scene.case):
        return None
    ratio = scene.bed_kg_per_m2 / min(panel.mass_kg_per_m2 for panel in scene.panels)
    verdict = compare(
        "bed / panel, mass per area",
        ratio,
        f"the bed has up to {scene.bed_kg_per_m2:.3g} kg/m2",
        threshold="0.1 (a tenth of the inertia)",
        cost="a sync interval below a tenth of the shortest impact",
    )
    if verdict.matters:
        change = scene.change_of_response(mass_ratio=ratio)
        if change is not None and change <= TENTH:
            return verdict.doubted(f"taut panels' middles move as far without, to {change:.1%}")
    elif any(scene.near_resonance(panel) for panel in scene.panels):
        return verdict.doubted("near a panel's resonance little mass shifts much")
    return verdict


EFFECT = exchange_effect(
    "panels",
    judge,
    "particle_load",
    off="panels do not feel the particles",
    described=has_particles,
    needs=("panel-deformation",),
    checked_by="bed_kg_per_m2",
    about=("panels",),
)
