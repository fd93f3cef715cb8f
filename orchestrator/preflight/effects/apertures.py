"""Openings of the panels.

They matter if the smallest particles pass them, if they take away much of the panel's mass, or if
they change the stroke by taking away stiffness.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from orchestrator.case.tables.case import has_particles
from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.preflight.scene.clamp_motion import largest_stroke_m
from orchestrator.preflight.scene.effect import TENTH, Effect, Verdict, compare, overlay_of_panels
from orchestrator.preflight.scene.moved_panel import softest_share, stiffness_share
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import solve_shakings

COST = "thousands of triangles for the particles"
BY_MASS = "0.1 (of the panel's mass)"

Share = Callable[[AperturePattern | None, Rectangle], float]
"""Function that returns the share of a panel's stiffness that its openings leave."""


def judge(scene: Scene) -> Verdict:
    """Judge the openings by the particles that fit through, the open share, and the change of the stroke."""
    open_share = 1 - min(panel.panel.material_share for panel in scene.panels)
    if open_share == 0:
        unknown = "the case names no openings: which the deck has is not said"
        return compare("open share", None, unknown, cost=COST)
    why = f"{open_share:.1%} of the free panel is open"
    if has_particles(scene.case) and scene.falls_through:
        passing = scene.finest_m / max(scene.openings_m)
        return Verdict("smallest particle / opening", passing, "below 1 (geometry)", True, why, COST)
    if open_share > TENTH:
        return Verdict("open share", open_share, BY_MASS, True, why, COST)
    least, most, words = _changes_of_stroke(scene)
    if most <= open_share:
        return compare("open share", open_share, f"{why}; {words}", BY_MASS, cost=COST)
    verdict = compare("change of the stroke by openings", most, f"{why}; {words}", cost=COST)
    return replace(verdict, matters=None) if least <= TENTH < most else verdict


def _changes_of_stroke(scene: Scene) -> tuple[float, float, str]:
    """Return the least and the largest relative change of the stroke without openings, and a text.

    Both follow from bounds of the panels' stiffness.
    """
    low_m, high_m = sorted(_stroke_m(scene, share) for share in (stiffness_share, softest_share))
    closed_m = _stroke_m(scene, lambda pattern, rectangle: 1.0)
    least, most = sorted(abs(closed_m / open_m - 1) if open_m else 0.0 for open_m in (low_m, high_m))
    strokes = f"{closed_m * 1e3:.3g} instead of {low_m * 1e3:.3g} to {high_m * 1e3:.3g} mm"
    return least, most, f"without them the stroke would be {strokes}"


def _stroke_m(scene: Scene, share: Share) -> float:
    """Return the stroke if openings leave another share of the panels' stiffness.

    The springs of a scene have the share of ``stiffness_share``, or 1 after a run without openings.
    """
    springs = []
    for panel, spring in zip(scene.panels, scene.springs, strict=True):
        pattern, rectangle = panel.panel.mean_apertures, panel.panel.rectangle
        present_share = 1.0 if scene.observed.closed else stiffness_share(pattern, rectangle)
        stiffness_N_per_m = spring.stiffness_N_per_m * float(share(pattern, rectangle) / present_share)
        springs.append(replace(spring, stiffness_N_per_m=stiffness_N_per_m))
    return largest_stroke_m(scene, solve_shakings(scene.plan, springs))


EFFECT = Effect(
    part="panels",
    judge=judge,
    described=lambda case: any(row.apertures for row in case.screen.panels.values()),
    overlay=lambda case: overlay_of_panels(case, "apertures"),
    key="apertures of panels or decks",
    checked_by="frames_throw",
    saves=True,
)
