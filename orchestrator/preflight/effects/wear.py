"""Wear of the panels, which matters by the largest share of the thickness lost in a thousand hours.

The estimate assumes that the bed always lies on the panel, and slides as fast as the frames shake plus
its own speed along the deck.
"""

from __future__ import annotations

import math

from orchestrator.case.deck.panels import axes
from orchestrator.preflight.scene.contacts import contact_law_effect, contacts_on_deck
from orchestrator.preflight.scene.effect import Verdict, compare
from orchestrator.preflight.scene.scene import Scene

SERVICE_S = 1000 * 3600.0
HARSHEST_M3_PER_N_M = 1e-10  # a polyurethane on abrasive paper: docs/theory/wear.md


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the share of the thickness that wears off; None without panels."""
    if not scene.panels:
        return None
    rate_m3_per_N_m = max((row.specific_wear_m3_per_N_m for row in contacts_on_deck(scene.case)), default=0.0)
    share: float | None = _worn_share(scene, rate_m3_per_N_m)
    why = f"after 1000 hours at most {share:.1%} of the thinnest panel is worn off"
    if not rate_m3_per_N_m:
        share, harshest = None, _worn_share(scene, HARSHEST_M3_PER_N_M)
        why = (
            f"no contact has specific wear; with {HARSHEST_M3_PER_N_M:g} m3/(N m), as on abrasive paper, "
            f"1000 hours would take {harshest:.1%} of the thickness at most"
        )
    return compare("worn in 1000 h / thickness", share, why, cost="a few products per contact and step")


def _worn_share(scene: Scene, rate_m3_per_N_m: float) -> float:
    pressure_Pa = scene.bed_kg_per_m2 * scene.gravity_m_per_s2
    worn_m = rate_m3_per_N_m * pressure_Pa * _sliding_m_per_s(scene) * SERVICE_S
    return worn_m / min(panel.panel.table.thickness_m for panel in scene.panels)


def _sliding_m_per_s(scene: Scene) -> float:
    """Return the mean speed of the fastest frame along the deck plus the speed of the material."""
    along = axes(scene.case)[:, 0]
    shaking_m_per_s = (
        sum(row.speed_rad_per_s * abs(row.amplitude_m[body.name] @ along) for row in scene.shaken)
        for body in scene.plan.bodies
    )
    return 2 / math.pi * float(max(shaking_m_per_s, default=0.0)) + scene.transport_m_per_s


EFFECT = contact_law_effect(
    judge,
    coefficient="specific_wear_m3_per_N_m",
    law="wear",
    laws=("archard",),
    without="nothing wears",
    key="contacts.<n>.specific_wear_m3_per_N_m",
    checked_by="bed_kg_per_m2",
)
