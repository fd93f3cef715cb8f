"""Feeds, which matter by the share of the bed that they replace in the run."""

from __future__ import annotations

from dataclasses import replace

from orchestrator.case.tables.case import has_particles
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.passage import compare_passage
from orchestrator.preflight.scene.scene import Scene


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the passage of the bed; None without particles."""
    if not has_particles(scene.case):
        return None
    verdict = compare_passage(scene, cost="a deck that fills for as long as material stays on it")
    bed = scene.case.bed
    if bed.blocks or bed.particles or bed.is_carried:
        return verdict
    return replace(verdict, matters=True, why="at t = 0 the deck is empty: the feed is all there is")


EFFECT = Effect(
    part="machine",
    judge=judge,
    described=lambda case: bool(case.bed.feeds),
    overlay=lambda case: {"bed": {"feeds": None}} if case.bed.feeds else {},
    key="bed.feeds.<name>",
    checked_by="transport_m_per_s",
    about=("particles",),
)
