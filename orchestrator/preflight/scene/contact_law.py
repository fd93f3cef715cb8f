"""Effects whose coefficient stands in the contacts and whose law is a key of the particles."""

from __future__ import annotations

from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.effect import Effect, Judge, Overlay
from orchestrator.preflight.scene.seen import What


def contact_law(
    judge: Judge,
    *,
    coefficient: str,
    law: str,
    laws: tuple[str, ...],
    without: str,
    key: str,
    checked_by: What | None = None,
) -> Effect:
    """An effect of the particles that a case describes by a ``coefficient`` of its contacts above
    zero, and whose ``law``, a key of the particles, is one of ``laws`` or "none": ``without`` says
    what that means."""

    def described(case: Case) -> bool:
        return has_particles(case) and any(getattr(row, coefficient) for row in case.contacts)

    def left_out(case: Case) -> str:
        off = getattr(case.particles, law) == "none" and described(case)
        return f"particles.{law} none: {without}" if off else ""

    def undescribed(case: Case) -> Overlay:
        return {"contacts": {str(n): {coefficient: 0.0} for n in range(len(case.contacts))}}

    return Effect(
        part="particles",
        judge=judge,
        described=described,
        left_out=left_out,
        undescribed=undescribed,
        overlay=lambda case: {"particles": {law: "none"}},
        laws={name: {"particles": {law: name}} for name in laws},
        key=key,
        checked_by=checked_by,
        saves=True,
        about=("particles",),
    )
