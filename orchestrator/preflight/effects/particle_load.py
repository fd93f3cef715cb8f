"""Particles load the panels: mass of the bed over mass of the panel."""

from __future__ import annotations

from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """None without particles."""
    if not has_particles(scene.case):
        return None
    bed = scene.bed_kg_per_m2
    ratio = bed / min(panel.mass_kg_per_m2 for panel in scene.panels)
    matters: bool | None = ratio > TENTH
    why = f"the bed has up to {bed:.3g} kg/m2"
    if not matters and any(scene.near_resonance(panel) for panel in scene.panels):
        matters, why = None, f"{why}; near a panel's resonance little mass shifts much"
    change = scene.change_of_response(mass_ratio=ratio)
    if matters and change is not None and change <= TENTH:
        matters, why = None, f"{why}; taut panels' middles move as far without, to {change:.1%}"
    return Verdict(
        number="bed / panel, mass per area",
        value=ratio,
        threshold="0.1 (a tenth of the inertia)",
        matters=matters,
        limit=TENTH,
        why=why,
        cost="a sync interval below a tenth of the shortest impact",
    )


def described(case: Case) -> bool:
    return has_particles(case) and bool(case.screen.panels)


def left_out(case: Case) -> str:
    off = "exchange.particle_load is off: panels do not feel the particles"
    return "" if case.exchange.particle_load else off


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=described,
    left_out=left_out,
    overlay=lambda case: {"exchange": {"particle_load": False}},
    needs=("panel-deformation",),
    key="exchange.particle_load",
    checked_by="bed_kg_per_m2",
    about=("panels",),
)
