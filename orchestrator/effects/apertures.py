"""Openings: whether the smallest particles pass; if nothing can, what they take of the panel."""

from __future__ import annotations

from typing import Any

from orchestrator.bed.contact_times import smallest_diameters_m
from orchestrator.casefile.case import Case
from orchestrator.casefile.contents import has_particles
from orchestrator.deck.opening_places import smaller_sides_m
from orchestrator.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.scene.scene import Scene


def judge(scene: Scene) -> Verdict:
    open_share = 1 - min(panel.material_share for panel in scene.panels)
    passing, there = _smallest_over_opening(scene), open_share > 0
    passes = passing is not None and passing < 1
    return Verdict(
        number="smallest particle / opening" if passes else "open share",
        value=(passing if passes else open_share) if there else None,
        threshold="below 1 (geometry)" if passes else "0.1 (of the panel's mass)",
        matters=(passes or open_share > TENTH) if there else None,
        why=f"{open_share:.1%} of the free panel is open"
        if there
        else "the case names no openings: which the deck has is not said",
        cost="thousands of triangles for the particles",
    )


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
)
