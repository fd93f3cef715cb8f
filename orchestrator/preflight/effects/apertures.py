"""Openings: whether the smallest particles pass, what they take of the panel's mass, and what they
take of its stiffness, by which the stroke changes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.deck.openings import smaller_sides_m
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.clamp_motion import largest_stroke_m
from orchestrator.preflight.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.preflight.scene.moved_panel import MovedPanel, softest_share, stiffness_share
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import solve_shakings

COST = "thousands of triangles for the particles"


def judge(scene: Scene) -> Verdict:
    open_share = 1 - min(panel.material_share for panel in scene.panels)
    if open_share == 0:
        unknown = "the case names no openings: which the deck has is not said"
        return Verdict("open share", None, "0.1", None, unknown, COST)
    passing = _smallest_over_opening(scene)
    said = f"{open_share:.1%} of the free panel is open"
    if passing is not None and passing < 1:
        number, limit = "smallest particle / opening", "below 1 (geometry)"
        return Verdict(number, passing, limit, True, said, COST)
    if open_share > TENTH:
        limit = "0.1 (of the panel's mass)"
        return Verdict("open share", open_share, limit, True, said, COST)
    least, most, words = _changes_of_stroke(scene)
    number, value, limit = "open share", open_share, "0.1 (of the panel's mass)"
    if most > open_share:
        number, value, limit = "change of the stroke by openings", most, "0.1"
    matters: bool | None = most > TENTH
    if matters and least <= TENTH:
        matters = None
    return Verdict(number, value, limit, matters, f"{said}; {words}", COST, TENTH)


def _changes_of_stroke(scene: Scene) -> tuple[float, float, str]:
    """Relative changes of the stroke by leaving out the openings, the least and the most that
    bounds of the panels' stiffness give, and words about them."""
    strokes_m = [_stroke_m(scene, share) for share in (stiffness_share, softest_share)]
    closed_m = _stroke_m(scene, lambda pattern, rectangle: 1.0)
    changes = sorted(abs(closed_m / one - 1) if one else 0.0 for one in strokes_m)
    low_m, high_m = sorted(strokes_m)
    words = (
        f"without them the stroke would be {closed_m * 1e3:.3g} instead of {low_m * 1e3:.3g} to "
        f"{high_m * 1e3:.3g} mm"
    )
    return changes[0], changes[1], words


def _stroke_m(scene: Scene, share: Any) -> float:
    """With a share of the stiffness that openings leave: of the panels' that the scene has."""
    springs = tuple(
        replace(spring, stiffness_N_per_m=spring.stiffness_N_per_m * _against(scene, panel, share))
        for panel, spring in zip(scene.panels, scene.springs, strict=True)
    )
    moved = replace(scene, springs=springs, shaken=solve_shakings(scene.plan, springs))
    return largest_stroke_m(moved, moved.shaken)


def _against(scene: Scene, panel: MovedPanel, share: Any) -> float:
    """Over the share that is in the springs of the scene: all of it in a run without openings."""
    pattern, rectangle = panel.panel.apertures, panel.panel.rectangle
    there = 1.0 if scene.observed.closed else stiffness_share(pattern, rectangle)
    return float(share(pattern, rectangle) / there)


def _smallest_over_opening(scene: Scene) -> float | None:
    """Of real particles, whatever coarse ones the case computes; None without either."""
    openings_m = list(smaller_sides_m(scene.case))
    if not has_particles(scene.case) or not openings_m:
        return None
    k = scene.case.particles.coarse_graining
    return min(smallest_diameters_m(scene.case).values()) / k / max(openings_m)


def overlay(case: Case) -> Overlay:
    found: dict[str, Any] = {}
    for kind, rows in (("panels", case.screen.panels), ("decks", case.screen.decks)):
        for name, row in rows.items():
            if row.apertures is not None:
                found.setdefault(kind, {})[name] = {"apertures": None}
    return {"screen": found} if found else {}


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: any(row.apertures for row in case.screen.panels.values()),
    overlay=overlay,
    key="apertures of panels or decks",
    checked_by="frames_throw",
    saves=True,
)
