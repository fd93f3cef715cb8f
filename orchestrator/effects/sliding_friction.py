"""Sliding friction: a body slides down with g (sin - mu cos); mu / tan is what friction takes."""

from __future__ import annotations

from orchestrator.casefile.case import Case
from orchestrator.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.scene.scene import Scene
from orchestrator.scene.slope_friction import of_slope, on_deck, takes


def judge(scene: Scene) -> Verdict:
    ratio = of_slope(_friction(scene.case), scene.slope)
    return Verdict(
        number="mu / tan(slope)",
        value=ratio,
        threshold="0.1 (Coulomb)",
        matters=ratio > TENTH,
        why=takes(ratio, "sliding"),
        cost="hardly anything",
    )


def overlay(case: Case) -> Overlay:
    frictionless = {str(k): {"sliding_friction": 0.0} for k in range(len(case.contacts))}
    return {"contacts": frictionless} if frictionless else {}


def _friction(case: Case) -> float:
    return max((row.sliding_friction for row in on_deck(case)), default=0.0)


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: _friction(case) > 0,
    overlay=overlay,
    key="contacts.sliding_friction",
)
