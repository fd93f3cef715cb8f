"""How much of the bed comes and goes in a run."""

from __future__ import annotations

from orchestrator.bed.transport import deck_length_m
from orchestrator.scene.effect import TENTH, Verdict
from orchestrator.scene.scene import Scene


def passage(scene: Scene, cost: str) -> Verdict:
    """Share of the bed that is replaced in the run."""
    speed_m_s = scene.transport_m_s
    share = scene.case.duration_s * speed_m_s / max(deck_length_m(scene.case), 1e-9)
    level = scene.slope < 1e-9 and scene.seen.transport_m_s is None
    why = f"in the run {share:.0%} of the bed goes over the deck, at {speed_m_s:.2g} m/s"
    if level:
        why = "the deck is level: whether it carries the bed along, only a run tells"
    return Verdict(
        number="run / time on the deck",
        value=None if level else share,
        threshold="0.1 (mass balance)",
        matters=None if level else share > TENTH,
        why=why,
        cost=cost,
    )
