"""Removal of material at exits, which matters by the share of the bed that leaves."""

from __future__ import annotations

from orchestrator.case.tables.case import has_particles
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.passage import compare_passage
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the passage of the bed; None without particles."""
    return compare_passage(scene, cost="nothing") if has_particles(scene.case) else None


EFFECT = Effect(
    part="machine",
    judge=judge,
    described=lambda case: has_particles(case) and bool(case.screen.exits),
    overlay=lambda case: {"screen": {"exits": None}} if case.screen.exits else {},
    key="screen.exits.<name>",
    checked_by="transport_m_per_s",
    about=("particles",),
)
