"""Rolling friction: a sphere rolls down with 5/7 g (sin - mu_r cos)."""

from __future__ import annotations

from orchestrator.casefile.case import Case
from orchestrator.casefile.contents import has_particles
from orchestrator.scene.effect import TENTH, Effect, Overlay, Verdict
from orchestrator.scene.scene import Scene
from orchestrator.scene.slope_friction import of_slope, on_deck, takes


def judge(scene: Scene) -> Verdict:
    friction = max((row.rolling_friction for row in on_deck(scene.case)), default=0.0)
    ratio = of_slope(friction, scene.slope)
    return Verdict(
        number="mu_r / tan(slope)",
        value=ratio,
        threshold="0.1 (rolling sphere)",
        matters=ratio > TENTH,
        why=takes(ratio, "rolling alone"),
        cost="a contact history (epsd2)",
    )


def described(case: Case) -> bool:
    return has_particles(case) and any(row.rolling_friction for row in case.contacts)


def left_out(case: Case) -> str:
    off = case.particles.rolling == "none" and described(case)
    return "particles.rolling none: no resistance to rolling" if off else ""


def undescribed(case: Case) -> Overlay:
    return {"contacts": {str(k): {"rolling_friction": 0.0} for k in range(len(case.contacts))}}


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=described,
    left_out=left_out,
    undescribed=undescribed,
    overlay=lambda case: {"particles": {"rolling": "none"}},
    laws={law: {"particles": {"rolling": law}} for law in ("cdt", "epsd2")},
    key="particles.rolling",
)
