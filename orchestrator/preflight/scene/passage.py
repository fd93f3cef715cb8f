"""How much of the bed comes and goes in a run: as a range, since how fast a deck carries its bed is
only known after a run."""

from __future__ import annotations

import math

from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.deck.openings import smaller_sides_m
from orchestrator.case.deck.panels import TRANSPORT_M_S, deck_length_m
from orchestrator.preflight.scene.effect import TENTH, Verdict
from orchestrator.preflight.scene.scene import Scene

SLOWEST_M_S = TRANSPORT_M_S / 3  # a thick bed on a flat deck
SLIDING = "slides down without friction"
THROWN = "is as fast as what throws it"


def passage(scene: Scene, cost: str) -> Verdict:
    """Share of the bed that is replaced in the run."""
    slow_m_per_s, fast_m_per_s, how = speeds_m_per_s(scene)
    per_speed = scene.case.duration_s / max(deck_length_m(scene.case), 1e-9)
    low, high = per_speed * slow_m_per_s, per_speed * fast_m_per_s
    why = (
        f"in the run {low:.0%} to {high:.0%} of the bed goes over the deck, at {slow_m_per_s:.2g} to "
        f"{fast_m_per_s:.2g} m/s{how}"
    )
    matters: bool | None = True if low > TENTH else None if high > TENTH else False
    if matters is False and falls_through(scene):
        matters, why = None, f"{why}; yet some pass the openings and fall to what is below"
    if scene.slope < 1e-9 and scene.observed.transport_m_per_s is None:
        matters = None
        why = "the deck is level: whether it carries the bed along, only a run tells"
    return Verdict(
        number="run / time on the deck",
        value=high,
        threshold="0.1 (mass balance)",
        matters=matters,
        why=why,
        cost=cost,
        limit=TENTH,
    )


def speeds_m_per_s(scene: Scene) -> tuple[float, float, str]:
    """Slowest and fastest speed of the bed along the deck that can be, and what the fastest is of:
    what slides down all the deck without friction, or is as fast as the frames and panels that
    throw it.  Of a run, its own."""
    observed = scene.observed.transport_m_per_s
    if observed is not None:
        return observed, observed, ", by the run"
    drop_m = deck_length_m(scene.case) * math.sin(math.atan(scene.slope))
    sliding_m_per_s = math.sqrt(2 * scene.gravity_m_per_s2 * drop_m)
    fast_m_per_s, how = max((sliding_m_per_s, SLIDING), (scene.impact_m_per_s, THROWN))
    return min(SLOWEST_M_S, fast_m_per_s), fast_m_per_s, f", if it {how}"


def falls_through(scene: Scene) -> bool:
    """Whether some particles are smaller than the openings."""
    openings_m = list(smaller_sides_m(scene.case))
    if not openings_m:
        return False
    finest_m = min(smallest_diameters_m(scene.case).values()) / scene.case.particles.coarse_graining
    return finest_m < max(openings_m)
