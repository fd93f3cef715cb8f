"""Walls of the openings, between the upper and the lower side of the mat.

A sphere that falls onto an opening passes it with the chance of a thin rim, however deep it is: who has sunk
below the upper rim, a wall does not throw back (docs/theory/deep_openings.md).  A grain as large as an
opening is what walls hold and rims do not: the stretched mat, or a blow, lets it in, and the walls clamp it.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from orchestrator.case.bed.grains import shapes
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.deck import PanelSheet
from orchestrator.preflight.effects.stiffness_at_openings import passing_more, pressed_overlap_m
from orchestrator.preflight.scene.contacts import compute_softness
from orchestrator.preflight.scene.effect import Effect, Verdict, compare
from orchestrator.preflight.scene.scene import Scene

OF_SPHERES = "what walls do to grains that must turn to pass, spheres do not tell"
SPHERE = "sphere"


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the mass that walls can clamp over the mass that passes; None without openings.

    A grain can be clamped that is larger than an opening, and no larger than the opening of the mat at its
    tautest and the overlaps of a blow on both sides make room for.
    """
    if not scene.openings_m:
        return None
    opening_m, strain = max(scene.openings_m), max(row.strain for row in scene.panels)
    struck_m = max(pressed_overlap_m(scene, opening_m), compute_softness(scene).overlap * opening_m / 2)
    clamped = passing_more(scene, opening_m, struck_m + strain * opening_m / 2)
    verdict = compare(
        "mass that walls can clamp / that passes",
        clamped,
        f"sizes from {opening_m * 1e3:.3g} mm up to what a strain of {strain:.1%} and an overlap of "
        f"{struck_m * 1e3:.2g} mm on both sides let in; what a sphere passes with, depth does not change",
        cost="three times the triangles of the deck",
    )
    shaped = any(shape.name != SPHERE for shape in shapes(scene.case))
    return verdict.doubted(OF_SPHERES) if shaped and not verdict.matters else verdict


def is_deep(sheet: PanelSheet) -> bool:
    """Return whether the openings of a panel or deck have walls."""
    return sheet.apertures is not None and sheet.apertures.rims == "deep"


def thin_rims(case: Case) -> Mapping[str, Any]:
    """Return the overlay that makes all deep rims thin."""
    keys = {"apertures": {"rims": "thin", "depth_m": None, "relief_deg": None}}
    kinds: dict[str, Mapping[str, PanelSheet]] = {"panels": case.screen.panels, "decks": case.screen.decks}
    tables = {
        kind: overlay
        for kind, rows in kinds.items()
        if (overlay := {name: keys for name, row in rows.items() if is_deep(row)})
    }
    return {"screen": tables} if tables else {}


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: any(is_deep(row) for row in case.screen.panels.values()),
    overlay=thin_rims,
    needs=("apertures",),
    key='apertures of panels or decks: rims = "deep"',
    saves=True,
    about=("particles",),
)
