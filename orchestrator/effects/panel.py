"""Effects in the panels and between panels and particles.  Of several panels the one for which an
effect is largest speaks."""

from __future__ import annotations

import math

from orchestrator.bed.contact_times import smallest_diameters_m
from orchestrator.casefile.left_out import has_particles
from orchestrator.deck.opening_places import smaller_sides_m
from orchestrator.effects.moved_panel import MovedPanel, loss_factor, mooney_ratio
from orchestrator.effects.scene import Scene, bed_kg_m2
from orchestrator.effects.verdict import TENTH, Verdict

LARGE_DEFLECTION = 0.2
WIDE = 1.0  # docs/theory/panel_strip.md: at width / length 0.15 and 1.2 a strip is off by 2 and 9 %
NOTHING_MOVES = "nothing moves the panels' ends: what particles do to them, only a run tells"
ELASTIC = "every panel.solver but rigid has it"


def particle_load(scene: Scene) -> Verdict | None:
    """Mass of the bed over mass of the panel; None without particles."""
    if not has_particles(scene.case):
        return None
    bed = bed_kg_m2(scene.case)
    ratio = bed / min(panel.mass_kg_m2 for panel in scene.panels)
    off = {"particle-load", "panel-deformation"} & set(scene.left_out)
    return Verdict(
        effect="particle-load",
        present=not off,
        number="bed / panel, mass per area",
        value=ratio,
        threshold="0.1 (a tenth of the inertia)",
        matters=ratio > TENTH,
        why=f"the bed has up to {bed:.3g} kg/m2",
        key="hand_over.particle_load",
        cost="a sync interval below a tenth of the shortest impact",
    )


def panel_deformation(scene: Scene) -> Verdict:
    """What the panels' middles move, against the frames."""
    throw, rigid = scene.panels_throw, scene.frames_throw
    ratio = throw / rigid if rigid else math.inf
    shaken = scene.speed_rad_s > 0
    why = f"panels' middles are thrown with {throw:.2g} g, frames with {rigid:.2g} g"
    return Verdict(
        effect="panel-deformation",
        present="panel-deformation" not in scene.left_out,
        number="throw of panel / of frame",
        value=ratio if shaken else None,
        threshold="0.1",
        matters=ratio > TENTH if shaken else None,
        why=why if shaken else NOTHING_MOVES,
        key="panel.solver",
        cost="a strip little, a sheet up to the particles' time",
    )


def large_deflection(scene: Scene) -> Verdict:
    """Sag over thickness."""
    ratio = max(panel.sag_m / panel.panel.table.thickness_m for panel in scene.panels)
    sag_m = max(panel.sag_m for panel in scene.panels)
    moves = scene.speed_rad_s > 0 or ratio > 0
    return Verdict(
        effect="large-deflection",
        present="panel-deformation" not in scene.left_out,
        number="sag / thickness",
        value=ratio if moves else None,
        threshold="0.2 (Ventsel, Krauthammer 2001)",
        matters=ratio > LARGE_DEFLECTION if moves else None,
        why=f"the slackest panel sags by {sag_m * 1e3:.3g} mm" if moves else NOTHING_MOVES,
        cost=ELASTIC,
    )


def panel_inertia(scene: Scene) -> Verdict:
    """Square of the excitation's frequency over the panel's lowest."""
    frequency = min(panel.frequency_rad_s for panel in scene.panels)
    ratio = (scene.speed_rad_s / frequency) ** 2
    shaken = scene.speed_rad_s > 0
    return Verdict(
        effect="panel-inertia",
        present="panel-deformation" not in scene.left_out,
        number="(speed / lowest frequency)^2",
        value=ratio if shaken else None,
        threshold="0.1 (one oscillator)",
        matters=ratio > TENTH if shaken else None,
        why=f"the empty panel's lowest is at {frequency:.3g} rad/s" if shaken else NOTHING_MOVES,
        cost=ELASTIC,
    )


def hyperelasticity(scene: Scene) -> Verdict:
    """Mooney-Rivlin's stress against the linear law's, where the panel is most taut."""
    panel = max(scene.panels, key=lambda one: one.strain)
    off = abs(mooney_ratio(panel.material, panel.strain) - 1)
    return Verdict(
        effect="hyperelasticity",
        present="panel-deformation" not in scene.left_out,
        number="Mooney-Rivlin / linear stress - 1",
        value=off,
        threshold="0.1 (a tenth of the force)",
        matters=off > TENTH,
        why=f"the tautest panel is stretched by {panel.strain:.2%}",
        cost=ELASTIC,
    )


def panel_damping(scene: Scene) -> Verdict:
    """Energy lost per cycle over energy stored: 2 pi times the loss factor."""
    if scene.speed_rad_s == 0:
        speed, where = min(panel.frequency_rad_s for panel in scene.panels), "its own frequency"
    else:
        speed, where = scene.speed_rad_s, "the excitation's frequency"
    factor = max(loss_factor(panel.material, speed) for panel in scene.panels)
    lost = 2 * math.pi * factor
    given = any(panel.material.branches for panel in scene.panels)
    unknown = "no Maxwell branches are given: measure the loss factor (0.02 would matter)"
    return Verdict(
        effect="panel-damping",
        present=given and "panel-deformation" not in scene.left_out,
        number="energy lost / stored, per cycle",
        value=lost if given else None,
        threshold="0.1 (loss factor 0.016)",
        matters=lost > TENTH if given else None,
        why=f"loss factor {factor:.2g} at {where}" if given else unknown,
        key="materials.<name>.hyperelastic.maxwell",
        cost="a twentieth of a strip's time, a fifth of a sheet's",
    )


def apertures(scene: Scene) -> Verdict:
    """Whether the smallest particles pass; if nothing can, what the openings take of the panel."""
    open_share = 1 - min(panel.material_share for panel in scene.panels)
    passing, there = _smallest_over_opening(scene), open_share > 0
    passes = passing is not None and passing < 1
    return Verdict(
        effect="apertures",
        present=there,
        number="smallest particle / opening" if passes else "open share",
        value=(passing if passes else open_share) if there else None,
        threshold="below 1 (geometry)" if passes else "0.1 (of the panel's mass)",
        matters=(passes or open_share > TENTH) if there else None,
        why=f"{open_share:.1%} of the free panel is open"
        if there
        else "the case names no openings: which the deck has is not said",
        key="apertures of panels or decks",
        cost="thousands of triangles for the particles",
    )


def _smallest_over_opening(scene: Scene) -> float | None:
    """Of real particles, whatever coarse ones the case computes; None without either."""
    openings_m = list(smaller_sides_m(scene.case))
    if not has_particles(scene.case) or not openings_m:
        return None
    k = scene.case.particles.coarse_graining
    return min(smallest_diameters_m(scene.case).values()) / k / max(openings_m)


def variation_across(scene: Scene) -> Verdict:
    """Width over length: clamps hinder a wide panel's contraction."""
    panel = max(scene.panels, key=_aspect)
    aspect, whole = _aspect(panel), _whole_aspect(scene)
    note = "particles spread unevenly across, and corners, are not in this number"
    if scene.case.slice is not None:
        note = f"of the slice; the whole machine's panels have {whole:.2g}"
    return Verdict(
        effect="variation-across",
        present=not {"variation-across", "panel-deformation"} & set(scene.left_out),
        number="width / length",
        value=aspect,
        threshold="1 (measured: strip against sheet)",
        matters=True if aspect > WIDE else None,
        why=note,
        key="panel.solver",
        cost="a sheet takes 6 times a strip's time",
    )


def _aspect(panel: MovedPanel) -> float:
    return panel.panel.rectangle.width_m / panel.length_m


def _whole_aspect(scene: Scene) -> float:
    return max(row.width_m / row.length_m for row in scene.case.whole.screen.panels.values())
