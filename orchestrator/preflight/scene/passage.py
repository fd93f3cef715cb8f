"""The share of the bed that comes and goes in a run.

It is a range, because only a run tells how fast a deck carries its bed.
"""

from __future__ import annotations

import math
from dataclasses import replace

from orchestrator.case.deck.panels import TRANSPORT_M_PER_S, deck_length_m
from orchestrator.preflight.scene.effect import TENTH, Verdict, compare
from orchestrator.preflight.scene.scene import Scene

SLOWEST_M_PER_S = TRANSPORT_M_PER_S / 3  # a thick bed on a flat deck


def compare_passage(scene: Scene, cost: str) -> Verdict:
    """Return the verdict on the share of the bed that is replaced in the run."""
    slow_m_per_s, fast_m_per_s, how = _speeds_m_per_s(scene)
    per_speed = scene.case.duration_s / max(deck_length_m(scene.case), 1e-9)
    low, high = per_speed * slow_m_per_s, per_speed * fast_m_per_s
    why = (
        f"in the run {low:.0%} to {high:.0%} of the bed goes over the deck, at {slow_m_per_s:.2g} to "
        f"{fast_m_per_s:.2g} m/s{how}"
    )
    level = scene.slope < 1e-9 and scene.observed.transport_m_per_s is None
    if level:
        why = "the deck is level: whether it carries the bed along, only a run tells"
    verdict = compare("run / time on the deck", high, why, "0.1 (mass balance)", cost=cost)
    if level or low <= TENTH < high:
        return replace(verdict, matters=None)
    if not verdict.matters and scene.falls_through:
        return verdict.doubted("yet some pass the openings and fall to what is below")
    return verdict


def _speeds_m_per_s(scene: Scene) -> tuple[float, float, str]:
    """Return the lowest and the highest possible speed of the bed along the deck, and a text about it.

    The fastest material slides down the whole deck without friction, or is as fast as the frames and
    panels that throw it.  After a run, both speeds are the speed in the run.
    """
    observed = scene.observed.transport_m_per_s
    if observed is not None:
        return observed, observed, ", by the run"
    drop_m = deck_length_m(scene.case) * math.sin(math.atan(scene.slope))
    sliding_m_per_s = math.sqrt(2 * scene.gravity_m_per_s2 * drop_m)
    fast_m_per_s, how = max(
        (sliding_m_per_s, "slides down without friction"),
        (scene.impact_m_per_s, "is as fast as what throws it"),
    )
    return min(SLOWEST_M_PER_S, fast_m_per_s), fast_m_per_s, f", if it {how}"
